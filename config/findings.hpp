// Collects what reading and checking finds, and helps to word it: places, did-you-mean, lists of
// names. Knows nothing of TOML or URDF.
#pragma once

#include <span>
#include <string>
#include <string_view>
#include <vector>

#include "config/robot.hpp"

namespace geodesic::config {

class Findings {
 public:
  void error(Place place, std::string text);
  void warning(Place place, std::string text);
  void add(Message message);

  bool has_errors() const noexcept { return errors_ > 0; }
  std::size_t errors() const noexcept { return errors_; }

  /// All messages in order of place: files in order of their first message, then line and column.
  std::vector<Message> take();

 private:
  std::vector<Message> messages_;
  std::size_t errors_ = 0;
};

/// Letters to insert, remove, replace or swap with their neighbour to get from one to the other.
std::size_t edit_distance(std::string_view a, std::string_view b);

/// The known name most like `found`, if it is like it at all; empty otherwise.
std::string_view nearest_name(std::string_view found, std::span<const std::string> known);

/// `; did you mean "NAME"?`, or nothing.
std::string did_you_mean(std::string_view found, std::span<const std::string> known);

/// `a, b, c`; `none` if there are none; long lists are cut and say so.
std::string list_names(std::span<const std::string> names);

/// Text as it may be shown on any terminal: control characters and broken UTF-8 become '?'.
std::string printable(std::string_view text);

/// Text as it may be shown: quoted, control characters and broken UTF-8 replaced, cut if long.
std::string quote(std::string_view text, std::size_t most = 60);
/// A path is never cut: people copy it.
std::string quote_path(const std::filesystem::path& path);

}  // namespace geodesic::config
