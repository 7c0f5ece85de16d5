// Jogging one joint; see the header.
#include "tools/geodesic/jog_session.hpp"

#include <fmt/format.h>
#include <poll.h>

#include <algorithm>
#include <cmath>
#include <ctime>

#include "drivers/families.hpp"
#include "rt/clock.hpp"

namespace geodesic::tools {
namespace {

using control::DriveCondition;
using control::DriveMode;

/// The joint's bus alone, with all joints on it.
drivers::ArmOptions bus_of(const config::Robot& robot, std::size_t joint) {
  drivers::ArmOptions options;
  const std::size_t bus = robot.arm.joints[joint].bus;
  options.buses.push_back(robot.arm.buses[bus]);
  for (const drivers::JointOptions& one : robot.arm.joints) {
    if (one.bus != bus) continue;
    options.joints.push_back(one);
    options.joints.back().bus = 0;
  }
  return options;
}

std::size_t index_of(const drivers::ArmOptions& options, const std::string& name) {
  const auto found = std::find_if(options.joints.begin(), options.joints.end(),
                                  [&](const auto& joint) { return joint.name == name; });
  return static_cast<std::size_t>(found - options.joints.begin());
}

void sleep_until(std::int64_t due_ns, const sigset_t* mask) {
  const std::int64_t left_ns = due_ns - rt::now_ns();
  const std::int64_t nap_ns = std::max<std::int64_t>(left_ns, 0);
  timespec left{};
  left.tv_sec = static_cast<decltype(left.tv_sec)>(nap_ns / rt::kNanosecondsPerSecond);
  left.tv_nsec = static_cast<decltype(left.tv_nsec)>(nap_ns % rt::kNanosecondsPerSecond);
  ::ppoll(nullptr, 0, &left, mask);  // a signal may end it early: the next cycle comes sooner
}

}  // namespace

std::string trouble_of(const control::JointState& joint, const drivers::DriveComplaint& complaint,
                       const drivers::JointOptions& options) {
  std::string text;
  switch (joint.condition) {
    case DriveCondition::kUnknown:
      text = fmt::format(
          "drive 0x{:X} does not answer: check supply, wiring and id; `geodesic "
          "scan` shows who does",
          options.drive.id);
      break;
    case DriveCondition::kConfiguring:
      text = "the drive's start-up does not end";
      break;
    case DriveCondition::kError: {
      const drivers::Family* family = drivers::find_family(options.drive.family);
      text = fmt::format("the drive reports error 0x{:X}: {}", joint.drive_error,
                         family == nullptr ? "?" : family->error_name(joint.drive_error));
      break;
    }
    case DriveCondition::kRefused:
      text = "the drive contradicts the robot file";
      break;
    case DriveCondition::kDisabled:
    case DriveCondition::kEnabled:
      return text;
  }
  if (complaint.quantity != nullptr) {
    text += fmt::format("; {}: found {:.6g}, expected {:.6g}", complaint.quantity, complaint.found,
                        complaint.expected);
    if (complaint.fix != nullptr) text += fmt::format("; {}", complaint.fix);
  }
  return text;
}

JogSession::JogSession(const config::Robot& robot, std::size_t joint)
    : options_(bus_of(robot, joint)),
      index_(index_of(options_, robot.arm.joints[joint].name)),
      period_ns_(std::max<std::int64_t>(robot.period_ns, 1'000'000)),
      arm_(options_) {
  command_.joints = options_.joints.size();
}

JogSession::~JogSession() {
  let_go();
}

void JogSession::exchange(const control::JointCommand& command, const sigset_t* waiting_mask) {
  const std::int64_t now_ns = rt::now_ns();
  tick_ns_ = tick_ns_ + 2 * period_ns_ < now_ns ? now_ns : tick_ns_ + period_ns_;
  sleep_until(tick_ns_, waiting_mask);
  command_.joint[index_] = command;  // every other joint keeps DriveMode::kMonitor
  arm_.transmit(command_, tick_ns_);
  state_ = arm_.receive(tick_ns_, tick_ns_ + period_ns_ * 8 / 10);
}

std::string JogSession::connect(const std::atomic<bool>& stop, const sigset_t& waiting_mask) {
  const std::int64_t end_ns = rt::now_ns() + kConnectNs;
  while (!stop.load() && rt::now_ns() < end_ns) {
    exchange({}, &waiting_mask);
    if (joint().condition == DriveCondition::kDisabled && joint().stamp_ns != 0) return {};
    if (joint().condition == DriveCondition::kRefused) break;
  }
  if (stop.load()) return "stopped";
  const std::string text = trouble_of(joint(), arm_.complaint(index_), options_.joints[index_]);
  return text.empty() ? "the drive is enabled by somebody else, and stays so" : text;
}

void JogSession::begin(const JogOptions& options) {
  law_ = JogLaw(options);
  active_ = true;
}

/// What the joint's own drive does not tell.
void JogSession::look_around() {
  const control::BusState& bus = state_.bus[0];
  if (bus.down || bus.bus_off) {
    law_.fail(bus.down ? "the bus is down" : "the controller has left the bus (bus-off)");
  } else if (bus.foreign_commander) {
    law_.fail("somebody else commands drives on this bus");
  }
  for (std::size_t i = 0; i < state_.joints; ++i) {
    if (i != index_ && state_.joint[i].condition == DriveCondition::kEnabled) {
      law_.fail(
          fmt::format("joint {} is enabled: somebody else commands it", options_.joints[i].name));
    }
  }
  if (law_.phase() == JogPhase::kFault) return;
  const std::string trouble = trouble_of(joint(), arm_.complaint(index_), options_.joints[index_]);
  if (!trouble.empty()) law_.fail(trouble);
}

void JogSession::cycle(const JogRequest& request, const sigset_t& waiting_mask) {
  look_around();
  // Each update sees the time at which its torque leaves, not the one at which the last one did.
  const control::JointCommand command = law_.update(rt::now_ns(), joint(), request);
  peak_torque_ = std::max(peak_torque_, std::abs(command.torque));
  exchange(command, &waiting_mask);
}

bool JogSession::let_go() {
  if (!active_) return true;
  active_ = false;
  const std::int64_t end_ns = rt::now_ns() + kLetGoNs;
  constexpr int kAtLeast = 5;  // a drive that was just asked to enable may not have said so yet
  for (int i = 0; rt::now_ns() < end_ns; ++i) {
    exchange({.mode = DriveMode::kDisable}, nullptr);
    if (i >= kAtLeast && joint().fresh && joint().condition != DriveCondition::kEnabled) {
      return true;
    }
  }
  return joint().condition != DriveCondition::kEnabled;
}

}  // namespace geodesic::tools
