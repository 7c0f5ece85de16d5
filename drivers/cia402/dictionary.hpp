// The object dictionary of a simulated CiA 402 drive: values, access rights, and why a transfer is
// aborted. What the values do is simulated.hpp's.
#pragma once

#include <array>
#include <cstddef>
#include <cstdint>
#include <optional>

#include "drivers/cia402/layout.hpp"

namespace geodesic::drivers::cia402 {

/// Allocates nothing.
class Dictionary {
 public:
  enum class Access : std::uint8_t { kConstant, kReadOnly, kReadWrite };

  Dictionary();

  /// Adds an object with its factory value. `stored`: 0x1010 keeps it over power-off.
  void add(Object object, Access access, std::uint32_t value, bool stored = false);
  /// The drive has no such object.
  void remove(Object object);

  std::uint32_t value(Object object) const;
  std::int32_t signed_value(Object object) const;
  void set(Object object, std::uint32_t value);
  /// As the maker sets it: for good.
  void set_factory(Object object, std::uint32_t value);

  /// As a master reads and writes. Nothing: done; else why not.
  std::optional<Abort> read(std::uint16_t index, std::uint8_t sub, Object& found) const;
  std::optional<Abort> write(std::uint16_t index, std::uint8_t sub, std::uint8_t bytes,
                             std::uint32_t value);

  /// All at their power-on values, or those of 0x1000 to 0x1FFF only.
  void power_on();
  void reset_communication();
  void store();

 private:
  struct Entry {
    Object object;
    Access access = Access::kReadOnly;
    bool stored = false;
    std::uint32_t value = 0;
    std::uint32_t power_on = 0;
  };

  const Entry* find(std::uint16_t index, std::uint8_t sub) const;
  Entry* find(std::uint16_t index, std::uint8_t sub);
  std::optional<Abort> missing(std::uint16_t index) const;
  std::optional<Abort> check_mapping(const Entry& entry, std::uint32_t value) const;

  static constexpr std::size_t kMost = 160;
  std::array<Entry, kMost> entries_{};
  std::size_t count_ = 0;
};

}  // namespace geodesic::drivers::cia402
