// What is done to the simulated arm and when: pushes on joints, forces on links, faults of drives,
// as the command line spells them. Only parsed here; plant.hpp carries it out.
#pragma once

#include <Eigen/Core>
#include <cstdint>
#include <string>
#include <string_view>
#include <vector>

#include "config/robot.hpp"

namespace geodesic::tools {

/// Times count from the moment the stand lets the arm go [s].
struct Push {
  std::size_t joint = 0;  ///< in order of v
  double torque = 0.0;    ///< [N·m or N]
  double start_s = 0.0;
  double duration_s = 0.0;
};

struct LinkForce {
  std::string link;
  Eigen::Vector3d force_n = Eigen::Vector3d::Zero();  ///< world axes, at the link's origin
  double start_s = 0.0;
  double duration_s = 0.0;
};

enum class FaultKind : std::uint8_t {
  kSilent,        ///< neither hears nor answers (a pulled cable) for `value` s; 0: from now on
  kError,         ///< falls into its family's error `code`
  kPowerCycle,    ///< off and on
  kTemperature,   ///< is `value` °C warm from now on
  kEncoderJump,   ///< its encoder is off by `value` from now on [rad or m at the joint]
  kEncoderStuck,  ///< its position stands still from now on; its velocity stays true
  kDouble,        ///< a second drive with its identifiers answers too, `value` away and not moving
  kBabble,        ///< something on its bus floods it, and wins every arbitration, for `value` s
  kHoldBus,       ///< nothing moves on its bus for `value` s, then everything that waited
};

/// As the command line spells it.
const char* to_string(FaultKind kind) noexcept;

/// What a fault's time counts from.
enum class FaultBase : std::uint8_t {
  kRelease,  ///< the stand lets the arm go
  kStart,    ///< of the simulation
  kEnabled,  ///< all drives are enabled for the first time
};

struct ScriptedFault {
  std::size_t joint = 0;
  FaultKind kind = FaultKind::kSilent;
  std::uint8_t code = 0;
  double value = 0.0;
  FaultBase base = FaultBase::kRelease;
  double at_s = 0.0;
};

struct Script {
  std::vector<Push> pushes;
  std::vector<LinkForce> forces;
  std::vector<ScriptedFault> faults;
};

/// "JOINT:TORQUE@T+D". JOINT is a name, or a number from 1 in the robot's order.
/// @throws std::invalid_argument in words for the user.
Push parse_push(std::string_view text, const config::Robot& robot);

/// "LINK:FX,FY,FZ@T+D". @throws as above.
LinkForce parse_force(std::string_view text, const config::Robot& robot);

/// "JOINT:KIND@T", "JOINT:KIND@start+T" or "JOINT:KIND@enabled+T" with KIND one of silent[=S],
/// error=CODE, power-cycle, temperature=C, encoder-jump[=RAD], encoder-stuck, double[=RAD],
/// babble[=S], hold-bus=S.
/// @throws as above.
ScriptedFault parse_fault(std::string_view text, const config::Robot& robot);

/// "a,b,c": as many finite numbers. @throws as above; `what` names them in the error.
std::vector<double> parse_numbers(std::string_view text, std::string_view what);

}  // namespace geodesic::tools
