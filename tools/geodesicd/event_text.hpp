// Events in words for people, and as fields for programs: which joint, on which bus, what was found
// against which limit, what the drive says. Writes to nothing.
#pragma once

#include <nlohmann/json.hpp>
#include <string>

#include "config/robot.hpp"
#include "tools/geodesicd/log.hpp"
#include "tools/geodesicd/telemetry.hpp"

namespace geodesic::tools {

/// How people call things that the real-time thread numbers.
struct Vocabulary {
  const config::Robot* robot = nullptr;
  std::vector<bool> prismatic;  ///< by joint, in order of v

  explicit Vocabulary(const config::Robot& of);

  const std::string& joint(std::size_t index) const;
  std::string arm(std::size_t index) const;
  /// Name and interface: "arm (can0)".
  std::string bus(std::size_t index) const;
  const char* position_unit(int joint) const;  ///< "rad" or "m"; kNoJoint: "rad"
  const char* velocity_unit(int joint) const;
  const char* torque_unit(int joint) const;
  /// The drive's error in the words of its family.
  const char* drive_error(std::size_t joint, std::uint8_t code) const;
};

struct EventText {
  Severity severity = Severity::kInfo;
  std::string text;
  nlohmann::ordered_json fields;
};

/// @param start_ns  tick from which moments are counted
EventText describe(const Event& event, const Vocabulary& words, std::int64_t start_ns);

/// "PMAX (register 21) [rad]: the drive has 12, the configuration expects 12.5; FIX", or empty.
std::string describe(const drivers::DriveComplaint& complaint);

/// "can0 is down, bus-off" and the like; "ok" if nothing is wrong.
std::string describe(const control::BusState& bus);

const char* to_string(control::DriveCondition condition) noexcept;

}  // namespace geodesic::tools
