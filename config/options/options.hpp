// How options are declared: once, by a describe() function that shows every option of a table to an
// OptionVisitor. One visitor reads TOML (toml_reader), another writes the reference (reference).
#pragma once

#include <array>
#include <cstdint>
#include <functional>
#include <limits>
#include <span>
#include <string>
#include <string_view>
#include <vector>

#include "config/robot.hpp"

namespace geodesic::config {

/// A value with where it came from.
template <class T>
struct Given {
  T value{};           ///< the default, until something is read
  bool given = false;  ///< a file says so
  Place place;         ///< where, if given
};

/// One entry of a table whose keys are names: `elbow = 1.2`.
struct NamedNumber {
  std::string name;
  double value = 0.0;
  Place name_place;
  Place value_place;
};

struct Range {
  double lower = -std::numeric_limits<double>::infinity();
  double upper = std::numeric_limits<double>::infinity();
  bool lower_open = false;  ///< lower itself is not allowed

  bool holds(double value) const noexcept {
    return (lower_open ? value > lower : value >= lower) && value <= upper;
  }
};
inline constexpr Range kAnyNumber{};
inline constexpr Range kPositive{0.0, std::numeric_limits<double>::infinity(), true};
inline constexpr Range kNotNegative{0.0, std::numeric_limits<double>::infinity(), false};
constexpr Range between(double lower, double upper) {
  return {lower, upper, false};
}

/// "0 < x <= 5"; empty for any number.
std::string to_string(const Range& range);

/// Whether a running daemon takes a change of an option. (Declared in robot.hpp.)
enum class Live : std::uint8_t {
  kUnsaid,     ///< a slip: every option says (tests/config/options_test.cpp)
  kYes,        ///< it moves over while the arm is in torque
  kNo,         ///< refused by name; it needs a restart
  kElsewhere,  ///< the daemon does not look at it (the simulated arm does)
};
/// "yes", "restart", "simulator"; "?" for an option that does not say.
std::string_view to_string(Live live);
inline constexpr Live kLive = Live::kYes;
inline constexpr Live kRestart = Live::kNo;
inline constexpr Live kElsewhere = Live::kElsewhere;

/// What is said of an option once and for all.
struct Spec {
  std::string_view key = {};
  std::string_view doc = {};   ///< one line
  std::string_view unit = {};  ///< empty: none
  Range range = {};
  std::span<const std::string_view> choices = {};  ///< texts: the allowed ones; empty: any
  bool required = false;
  std::string_view default_text = {};  ///< how the default is found where it is no constant
  std::string_view like = {};          ///< tables: documented there, with everything but the name
  Live live = Live::kUnsaid;           ///< `tables`: of adding and removing one; `table`: not asked
};

class OptionVisitor {
 public:
  using Describe = std::function<void(OptionVisitor&)>;
  using DescribeOne = std::function<void(OptionVisitor&, std::size_t)>;

  virtual ~OptionVisitor() = default;

  virtual void number(const Spec& spec, Given<double>& value) = 0;
  virtual void integer(const Spec& spec, Given<std::int64_t>& value) = 0;
  virtual void flag(const Spec& spec, Given<bool>& value) = 0;
  virtual void text(const Spec& spec, Given<std::string>& value) = 0;
  virtual void integers(const Spec& spec, Given<std::vector<std::int64_t>>& value) = 0;
  virtual void vector(const Spec& spec, Given<std::array<double, 3>>& value) = 0;
  /// A table whose keys are names, each with a number.
  virtual void by_name(const Spec& spec, std::vector<NamedNumber>& values) = 0;
  /// A table; `describe` is called if it is there.
  virtual void table(const Spec& spec, const Describe& describe) = 0;
  /// A table that only holds what others fall back to: nothing in it is required.
  virtual void partial_table(const Spec& spec, const Describe& describe) = 0;
  /// An array of tables, each with a "name" as its first option. `present` are there already;
  /// `describe` shows the one of that index, and adds one if the index is as many as are there.
  virtual void tables(const Spec& spec, std::size_t present, const DescribeOne& describe) = 0;

  /// The table being described.
  virtual Place here() const = 0;

 protected:
  OptionVisitor() = default;
  OptionVisitor(const OptionVisitor&) = default;
  OptionVisitor& operator=(const OptionVisitor&) = default;
};

}  // namespace geodesic::config
