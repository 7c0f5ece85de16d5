// Events in words.
#include "tools/geodesicd/event_text.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>

#include "control/arms.hpp"
#include "drivers/bus/frame_text.hpp"
#include "drivers/families.hpp"
#include "rt/seal.hpp"

namespace geodesic::tools {

using control::Fault;

namespace {

/// What found and limit of a fault measure.
enum class Quantity : std::uint8_t {
  kNone,
  kCycles,
  kPosition,
  kVelocity,
  kTorque,
  kTemperature,
  kSeconds,
  kCall,  ///< the number of a system call; it has no limit
};

Quantity quantity(Fault fault) {
  switch (fault) {
    case Fault::kJointSilent:
    case Fault::kOverrun:
      return Quantity::kCycles;
    case Fault::kPositionLimit:
    case Fault::kStartOutsideLimits:
    case Fault::kEncoderJump:
    case Fault::kEncoderStuck:
      return Quantity::kPosition;
    case Fault::kVelocityLimit:
    case Fault::kNotAtRest:
    case Fault::kEnableTimeout:
    case Fault::kVibration:
    case Fault::kVibrationPersists:
      return Quantity::kVelocity;
    case Fault::kTorqueSaturated:
    case Fault::kContact:
    case Fault::kStaticTorque:
      return Quantity::kTorque;
    case Fault::kTemperatureWarn:
    case Fault::kTemperatureLimit:
      return Quantity::kTemperature;
    case Fault::kConnectTimeout:
      return Quantity::kSeconds;
    case Fault::kForbiddenCall:
      return Quantity::kCall;
    default:
      return Quantity::kNone;
  }
}

const char* unit(Quantity what, int joint, const Vocabulary& words) {
  switch (what) {
    case Quantity::kCycles:
      return "cycles in a row";
    case Quantity::kPosition:
      return words.position_unit(joint);
    case Quantity::kVelocity:
      return words.velocity_unit(joint);
    case Quantity::kTorque:
      return words.torque_unit(joint);
    case Quantity::kTemperature:
      return "°C";
    case Quantity::kSeconds:
      return "s";
    case Quantity::kCall:
    case Quantity::kNone:
      break;
  }
  return "";
}

Severity severity(control::Action action) {
  switch (action) {
    case control::Action::kNone:
      return Severity::kInfo;
    case control::Action::kWarn:
    case control::Action::kDamp:
      return Severity::kWarning;
    default:
      return Severity::kError;
  }
}

const char* consequence(control::Action action) {
  switch (action) {
    case control::Action::kNone:
    case control::Action::kWarn:
      return "carrying on";
    case control::Action::kRefuse:
      return "start refused";
    case control::Action::kDamp:
      return "damping until it has gone";
    case control::Action::kControlledStop:
      return "controlled stop";
    case control::Action::kDriveDamping:
      return "drive damping, then off";
    case control::Action::kTorqueOff:
      return "torque off";
  }
  return "";
}

std::string where(const control::FaultEvent& fault, const Vocabulary& words) {
  if (fault.joint >= 0) {
    const auto joint = static_cast<std::size_t>(fault.joint);
    const drivers::JointOptions& options = words.robot->arm.joints.at(joint);
    return fmt::format("{}, bus {}, {} id 0x{:X}", words.joint(joint), words.bus(options.bus),
                       options.drive.family, options.drive.id);
  }
  return fault.bus >= 0 ? "bus " + words.bus(static_cast<std::size_t>(fault.bus)) : std::string();
}

std::string age_text(std::int64_t age_ns, const drivers::Frame& frame) {
  if (age_ns < 0) {
    return "no frame from it yet";
  }
  return fmt::format("last good frame {:.1f} ms ago: {}", static_cast<double>(age_ns) * 1e-6,
                     drivers::candump_text(frame));
}

/// What a difference of torque at arm-up looks like, and what to do about it.
std::string suspicion_text(const control::Suspicion& suspicion) {
  switch (suspicion.what) {
    case control::Suspect::kWrongSign:
      return "the joint's torque acts the wrong way round: check direction, and the motor's phases";
    case control::Suspect::kWrongMass:
      return fmt::format("looks like masses {:.0f} % {} than the model's: check the URDF",
                         100.0 * std::abs(suspicion.size),
                         suspicion.size > 0.0 ? "larger" : "smaller");
    case control::Suspect::kPayload:
      return fmt::format("looks like {} of {:.2f} kg at the tool: choose the payload it carries",
                         suspicion.size > 0.0 ? "an uncounted payload" : "a missing load",
                         std::abs(suspicion.size));
    case control::Suspect::kNone:
      break;
  }
  return "neither a payload nor wrong masses explain it: look for what holds the joint, and at its "
         "offset";
}

EventText describe_fault(const Event& event, const Vocabulary& words, double moment_s) {
  const control::FaultEvent& fault = event.fault;
  const control::FaultPolicy& policy = control::policy(fault.fault);
  const control::Action action =
      fault.action != control::Action::kNone ? fault.action : policy.action;
  const Quantity what = quantity(fault.fault);
  const char* of = unit(what, fault.joint, words);
  const std::string place = where(fault, words);

  EventText result;
  result.severity = severity(action);
  result.text =
      fmt::format("{}{}{}: {}", policy.name, place.empty() ? "" : " at ", place, policy.meaning);
  result.fields = {{"event", "fault"},
                   {"at_s", moment_s},
                   {"fault", policy.name},
                   {"class", control::to_string(action)}};
  if (words.robot->controller.arms.size() > 1) {
    result.fields["arm"] = words.arm(static_cast<std::size_t>(fault.arm));
    // A joint's name tells its arm.
    result.text += fault.joint >= 0
                       ? ""
                       : fmt::format("; arm {}", words.arm(static_cast<std::size_t>(fault.arm)));
  }
  if (what == Quantity::kCall) {
    const std::string call = rt::system_call_name(static_cast<int>(fault.found));
    result.text += fmt::format("; {} was not made", call);
    result.fields["system_call"] = call;
  } else if (what != Quantity::kNone) {
    result.text += fmt::format("; found {:.4g}, limit {:.4g} {}", fault.found, fault.limit, of);
    result.fields.update({{"found", fault.found}, {"limit", fault.limit}, {"unit", of}});
  }
  if (fault.fault == Fault::kStaticTorque) {
    const std::string suspicion = suspicion_text(fault.suspicion);
    result.text += "; " + suspicion;
    result.fields["suspicion"] = suspicion;
  }
  if (fault.bus >= 0) {
    result.fields["bus"] = words.robot->arm.buses.at(static_cast<std::size_t>(fault.bus)).interface;
  }
  if (fault.joint >= 0) {
    const auto joint = static_cast<std::size_t>(fault.joint);
    result.fields["joint"] = words.joint(joint);
    result.fields["bus"] =
        words.robot->arm.buses.at(words.robot->arm.joints.at(joint).bus).interface;
    if (event.drive_error != 0) {
      const char* error = words.drive_error(joint, event.drive_error);
      result.text += fmt::format("; the drive reports: {} (0x{:X})", error, event.drive_error);
      result.fields["drive_error"] = error;
    }
    if (const std::string complaint = describe(event.complaint); !complaint.empty()) {
      result.text += "; " + complaint;
      result.fields["complaint"] = complaint;
    }
    result.fields["drive_id"] = words.robot->arm.joints.at(joint).drive.id;
    result.text += "; " + age_text(event.frame_age_ns, event.last_frame);
    if (event.frame_age_ns >= 0) {
      result.fields["last_frame"] = drivers::candump_text(event.last_frame);
      result.fields["last_frame_age_ms"] = static_cast<double>(event.frame_age_ns) * 1e-6;
    }
  }
  result.text += fmt::format("; {} [t = {:.3f} s]", consequence(action), moment_s);
  return result;
}

EventText describe_state(const Event& event, const Vocabulary& words, double moment_s) {
  const bool active = event.to == control::SupervisorState::kActive;
  EventText result;
  result.severity =
      event.to == control::SupervisorState::kFault ? Severity::kError : Severity::kInfo;
  const bool of_arm = event.kind == Event::Kind::kArmState;
  const std::string arm = of_arm ? words.arm(static_cast<std::size_t>(event.arm)) : std::string();
  result.text =
      fmt::format("{}{} -> {}{} [t = {:.3f} s]", of_arm ? fmt::format("arm {}: ", arm) : "",
                  control::to_string(event.from), control::to_string(event.to),
                  active ? fmt::format("({})", control::to_string(event.law)) : "", moment_s);
  result.fields = {{"event", of_arm ? "arm_state" : "state"},
                   {"at_s", moment_s},
                   {"from", control::to_string(event.from)},
                   {"to", control::to_string(event.to)}};
  if (of_arm) {
    result.fields["arm"] = arm;
  }
  if (active) {
    result.fields["law"] = control::to_string(event.law);
  }
  return result;
}

EventText describe_refusal(const Event& event, double moment_s) {
  const std::string reason = event.refusal == nullptr ? "" : event.refusal;
  return {Severity::kWarning,
          fmt::format("request not followed: {} [t = {:.3f} s]", reason, moment_s),
          {{"event", "refusal"}, {"at_s", moment_s}, {"reason", reason}}};
}

}  // namespace

Vocabulary::Vocabulary(const config::Robot& of) : robot(&of) {
  for (const drivers::JointOptions& options : of.arm.joints) {
    const auto described =
        std::find_if(of.tree.joints.begin(), of.tree.joints.end(),
                     [&](const auto& joint) { return joint.name == options.name; });
    prismatic.push_back(described != of.tree.joints.end() &&
                        described->kind == control::JointKind::kPrismatic);
  }
}

const std::string& Vocabulary::joint(std::size_t index) const {
  return robot->arm.joints.at(index).name;
}

std::string Vocabulary::arm(std::size_t index) const {
  return control::arm_name(robot->controller, index);
}

std::string Vocabulary::bus(std::size_t index) const {
  const drivers::BusOptions& options = robot->arm.buses.at(index);
  return options.name.empty() || options.name == options.interface
             ? options.interface
             : options.name + " (" + options.interface + ")";
}

const char* Vocabulary::position_unit(int joint) const {
  return joint >= 0 && prismatic.at(static_cast<std::size_t>(joint)) ? "m" : "rad";
}

const char* Vocabulary::velocity_unit(int joint) const {
  return joint >= 0 && prismatic.at(static_cast<std::size_t>(joint)) ? "m/s" : "rad/s";
}

const char* Vocabulary::torque_unit(int joint) const {
  return joint >= 0 && prismatic.at(static_cast<std::size_t>(joint)) ? "N" : "N·m";
}

const char* Vocabulary::drive_error(std::size_t joint, std::uint8_t code) const {
  const drivers::Family* family = drivers::find_family(robot->arm.joints.at(joint).drive.family);
  return family != nullptr ? family->error_name(code) : "unknown error";
}

EventText describe(const Event& event, const Vocabulary& words, std::int64_t start_ns) {
  const double moment_s = static_cast<double>(event.tick_ns - start_ns) / 1e9;
  switch (event.kind) {
    case Event::Kind::kFault:
      return describe_fault(event, words, moment_s);
    case Event::Kind::kState:
    case Event::Kind::kArmState:
      return describe_state(event, words, moment_s);
    case Event::Kind::kRefusal:
      break;
  }
  return describe_refusal(event, moment_s);
}

namespace {

/// Registers are often counts or dates, which no exponent may shorten.
std::string register_value(double value) {
  constexpr double kExact = 1e15;
  return value == std::trunc(value) && std::abs(value) < kExact ? fmt::format("{:.0f}", value)
                                                                : fmt::format("{:.6g}", value);
}

}  // namespace

std::string describe(const drivers::DriveComplaint& complaint) {
  if (complaint.quantity == nullptr) {
    return {};
  }
  std::string text =
      fmt::format("{}: the drive has {}, the configuration expects {}", complaint.quantity,
                  register_value(complaint.found), register_value(complaint.expected));
  if (complaint.fix != nullptr) {
    text += fmt::format("; {}", complaint.fix);
  }
  return text;
}

std::string describe(const control::BusState& bus) {
  std::string text;
  const auto add = [&text](bool is, const char* what) {
    if (is) {
      text += text.empty() ? what : std::string(", ") + what;
    }
  };
  add(bus.down, "down");
  add(bus.bus_off, "bus-off");
  add(bus.error_passive, "error-passive");
  add(bus.stalled, "stalled");
  add(bus.foreign_commander, "foreign commander");
  return text.empty() ? "ok" : text;
}

const char* to_string(control::DriveCondition condition) noexcept {
  switch (condition) {
    case control::DriveCondition::kUnknown:
      return "unknown";
    case control::DriveCondition::kConfiguring:
      return "configuring";
    case control::DriveCondition::kDisabled:
      return "disabled";
    case control::DriveCondition::kEnabled:
      return "enabled";
    case control::DriveCondition::kError:
      return "error";
    case control::DriveCondition::kRefused:
      return "refused";
  }
  return "unknown";
}

}  // namespace geodesic::tools
