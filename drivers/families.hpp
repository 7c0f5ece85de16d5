// The table of drive families: one line a family. A new family adds its folder and its line.
#pragma once

#include <cstdint>
#include <memory>
#include <optional>
#include <span>
#include <string>
#include <string_view>
#include <vector>

#include "drivers/bench_dialogue.hpp"
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

/// One frame of a drive's cycle once it is enabled, for the bus-time budget and the timeline.
struct CyclicFrame {
  std::string_view what;  ///< "torque", "state", "SYNC"
  std::uint32_t id = 0;
  std::uint8_t bytes = 8;
  bool extended = false;
  bool reply = false;       ///< the drive sends it
  bool once_a_bus = false;  ///< whoever is DriveOptions::leader sends it for all of its family
  double share = 1.0;  ///< of the cycles in which it comes: a heartbeat every 100 ms, 0.01 at 1 kHz
  bool unasked = false;         ///< a reply by the drive's own timer: it answers no command
  bool classic = false;         ///< a classic frame even where the bus carries CAN FD
  bool bit_rate_switch = true;  ///< of a CAN FD frame
  std::int64_t latency_ns = 0;  ///< from the end of the command to its answer; 0: nobody knows
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
  /// At most kMaxDriveSettings options that this family alone has.
  std::span<const DriveSetting> settings;
  /// All frames of a cycle, commands first, in the order in which they are sent. The i-th reply
  /// that is not unasked answers the i-th command, or the last where there are fewer; in a family
  /// with a command once a bus all answer that one.
  std::vector<CyclicFrame> (*cyclic_frames)(const DriveOptions&, double rate_hz);
  /// After power-on the drive's position is only known up to whole multiples of this [rad]; 0: it
  /// knows its turns.
  double (*position_period_rad)(const DriveOptions&);
  /// @param fd  the bus carries CAN FD.
  std::unique_ptr<Scanner> (*make_scanner)(bool fd);
  std::unique_ptr<Zeroing> (*make_zeroing)(const DriveOptions&);
};

/// Every family there is. Not real-time.
std::span<const Family> families();
/// The family of that name; null if there is none.
const Family* find_family(std::string_view name);

}  // namespace geodesic::drivers
