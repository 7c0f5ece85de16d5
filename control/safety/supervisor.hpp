// The state machine people trust, and the one table of faults that is policy and documentation at
// once. A pure function of (state, flags, time); it knows joints only as flags.
#pragma once

#include <cstdint>

#include "control/joint.hpp"

namespace geodesic::control {

enum class SupervisorState : std::uint8_t {
  kOff,         ///< drives disabled; nothing happens until somebody asks
  kConnecting,  ///< drives are configured and must report; no torque
  kReady,       ///< all is well; no torque
  kEnabling,    ///< drives are being enabled; zero torque
  kActive,      ///< the law runs; authority ramps in
  kStopping,    ///< controlled stop: compensation and damping until at rest
  kLowering,    ///< drives damp, authority ramps out
  kFault,       ///< drives disabled after a fault; an operator has to ask for a start
};

/// In rising severity: the worst of all raised wins.
enum class Action : std::uint8_t {
  kNone,
  kWarn,            ///< carry on, say so
  kRefuse,          ///< do not start; no effect once active
  kControlledStop,  ///< compensation and damping until at rest, then lowering, then fault
  kDriveDamping,    ///< encoders not trustworthy: drive-side damping only, then fault
  kTorqueOff,       ///< drives disabled at once
};

enum class Fault : std::uint8_t {
  kJointSilent,
  kDriveError,
  kDriveRefused,
  kDriveDisabled,      ///< a drive left enabled without being told
  kPositionLimit,
  kVelocityLimit,
  kTemperatureWarn,
  kTemperatureLimit,
  kTorqueSaturated,
  kEncoderJump,
  kNotFinite,
  kBusDown,
  kBusOff,
  kBusErrorPassive,
  kBusStalled,
  kForeignCommander,
  kOverrun,
  kConnectTimeout,
  kEnableTimeout,
  kNotAtRest,          ///< a start was asked for while a joint moved
  kCount
};

struct FaultPolicy {
  Fault fault;
  const char* name;     ///< as logs and summaries call it: "joint_silent"
  const char* meaning;  ///< one line for people
  Action action;
  const char* clears;   ///< when, and by whom
};

/// The one table.
const FaultPolicy& policy(Fault fault) noexcept;
const char* to_string(SupervisorState state) noexcept;
const char* to_string(Action action) noexcept;

inline constexpr std::size_t kMaxEventsPerCycle = 16;
inline constexpr int kNoJoint = -1;

/// A fault raised at a moment, with its evidence.
struct FaultEvent {
  std::int64_t time_ns = 0;  ///< ArmState::tick_ns of the cycle that found it
  Fault fault = Fault::kCount;
  int joint = kNoJoint;      ///< index in order of v
  int bus = -1;              ///< index of the bus, where it is the bus's fault
  double found = 0.0;
  double limit = 0.0;
};

}  // namespace geodesic::control
