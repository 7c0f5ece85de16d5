// What Arm keeps of each joint and each bus, and joint units to drive units and back. For arm.cpp
// alone.
#pragma once

#include <cstddef>
#include <cstdint>
#include <memory>
#include <utility>
#include <vector>

#include "control/joint.hpp"
#include "drivers/arm.hpp"
#include "drivers/bus/bus.hpp"
#include "drivers/drive.hpp"
#include "drivers/reply_routes.hpp"
#include "drivers/turn_resolver.hpp"

namespace geodesic::drivers::arm {

inline constexpr DriveComplaint kElsewhere{
    "position at power-on [rad or m at the joint]", 0.0, 0.0,
    "no turn of the drive brings it between start_lower and start_upper: move the joint there by "
    "hand, or correct offset and direction"};
inline constexpr DriveComplaint kAnyTurn{
    "position at power-on [rad or m at the joint]", 0.0, 0.0,
    "more than one turn of the drive lies between start_lower and start_upper: bring them closer"};

/// Whether the turn the drive is in is known.
enum class Turn : std::uint8_t { kUnknown, kKnown, kRefused };

struct Joint {
  Joint(std::unique_ptr<Drive> made, const JointOptions& options, double period)
      : drive(std::move(made)),
        line(options.bus),
        scale(options.direction * options.ratio),
        offset(options.offset),
        turns(period * options.ratio, options.start_lower, options.start_upper) {}

  std::unique_ptr<Drive> drive;
  std::size_t line = 0;
  double scale = 1.0;   ///< direction * ratio
  double offset = 0.0;  ///< and what the turns add
  TurnResolver turns;
  Turn turn = Turn::kUnknown;
  bool turn_found = false;  ///< by the last resolution
  DriveComplaint lost;      ///< why the turn was refused
  std::size_t sent = 0;     ///< this cycle's frames that the kernel took
  std::size_t due = 0;      ///< answers to them
  std::size_t heard = 0;    ///< frames that answer them
  bool answered = false;
  int surplus = 0;  ///< see kSurplusLimit
  bool doubled = false;
  JointCounters counters;
  Frame last_good;
};

struct Line {
  std::unique_ptr<Bus> bus;
  ReplyRoutes routes;
  std::vector<Frame> frames;        ///< this cycle's, [0 .. filled)
  std::vector<std::size_t> owners;  ///< joint of each frame
  std::size_t filled = 0;
  std::size_t owed = 0;  ///< joints on this bus that have not answered; simulated time: its tick
  int missing = 0;       ///< ticks in a row that nobody answered
  std::int64_t sent_ns = 0;
  bool read = false;  ///< in this cycle
  bool gone = false;  ///< waiting on it is in vain in this cycle
  short events = 0;   ///< what poll said of it
};

inline DriveCommand to_drive(const control::JointCommand& command, const Joint& joint) noexcept {
  return {.mode = command.mode,
          .torque_nm = command.torque * joint.scale,
          .position_rad = (command.position - joint.offset - joint.turns.shift()) / joint.scale,
          .velocity_rad_s = command.velocity / joint.scale,
          .stiffness_nm_rad = command.stiffness * joint.scale * joint.scale,
          .damping_nm_s_rad = command.damping * joint.scale * joint.scale};
}

/// A drive that has been silent for less than this has not been off.
inline constexpr std::int64_t kOffAtLeastNs = 100'000'000;

/// The first report after power-on says where the joint stands but for whole turns. `last` is what
/// was known of the joint before: one that was not off has kept its turns.
inline void find_turn(double reading, std::int64_t stamp_ns, const control::JointState& last,
                      Joint& joint) noexcept {
  const bool kept = joint.turn_found && stamp_ns - last.stamp_ns < kOffAtLeastNs &&
                    joint.turns.continues(reading, last.position);
  const TurnResolver::Verdict verdict =
      kept ? TurnResolver::Verdict::kUnique : joint.turns.resolve(reading);
  joint.turn_found = verdict == TurnResolver::Verdict::kUnique;
  joint.turn = verdict == TurnResolver::Verdict::kUnique ? Turn::kKnown : Turn::kRefused;
  joint.lost = verdict == TurnResolver::Verdict::kOutside ? kElsewhere : kAnyTurn;
  joint.lost.found = reading;
}

inline void to_joint(const DriveState& drive, const Joint& joint,
                     control::JointState& out) noexcept {
  out.position = drive.position_rad * joint.scale + joint.offset + joint.turns.shift();
  out.velocity = drive.velocity_rad_s * joint.scale;
  out.torque = drive.torque_nm / joint.scale;
  out.temperature_c = drive.temperature_c;
  out.stamp_ns = drive.stamp_ns;
}

}  // namespace geodesic::drivers::arm
