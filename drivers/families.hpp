// The table of drive families: one line a family. A new family adds its folder and its line.
#pragma once

#include <memory>
#include <optional>
#include <span>
#include <string>
#include <string_view>
#include <vector>

#include "drivers/drive.hpp"

namespace geodesic::drivers {

/// One value of a frame in words: {"torque", "1.25", "N·m"}.
struct DecodedField {
  std::string name;
  std::string value;
  std::string unit;
};

/// A frame in words, for people. `kind` is e.g. "MIT command", "state", "register reply".
struct DecodedFrame {
  std::string kind;
  std::vector<DecodedField> fields;
};

struct Family {
  std::string_view name;
  std::string_view summary;
  std::unique_ptr<Drive> (*make_drive)(const DriveOptions&);
  std::unique_ptr<SimulatedDrive> (*make_simulated)(const DriveOptions&);
  /// What `frame` means to or from this drive; nothing if it is not this drive's.
  std::optional<DecodedFrame> (*decode)(const Frame& frame, const DriveOptions&);
  /// What is wrong with these options for this family (identifier ranges, clashes with its special
  /// identifiers, figures out of range), each a sentence; empty: nothing.
  std::vector<std::string> (*check)(const DriveOptions&);
  /// Name of a drive error code in words, a literal; "unknown error" where there is none.
  const char* (*error_name)(std::uint8_t code);
  /// Frames of one cycle for one drive, for the bus-time budget: bytes of a command and of a reply.
  std::uint8_t command_bytes;
  std::uint8_t reply_bytes;
};

/// Every family there is. Not real-time.
std::span<const Family> families();
/// The family of that name; null if there is none.
const Family* find_family(std::string_view name);

}  // namespace geodesic::drivers
