// Filling of records, events and counters, on the real-time thread.
#include "tools/geodesicd/telemetry.hpp"

#include <algorithm>
#include <cmath>

namespace geodesic::tools {
namespace {

constexpr std::int64_t kCountEveryNs = 50'000'000;

std::int64_t frame_age_ns(const control::JointState& joint, std::int64_t tick_ns) noexcept {
  return joint.stamp_ns == 0 ? -1 : std::max<std::int64_t>(0, tick_ns - joint.stamp_ns);
}

std::int32_t age_us(const control::JointState& joint, std::int64_t tick_ns) noexcept {
  if (joint.fresh) {
    return 0;
  }
  const std::int64_t age_ns = frame_age_ns(joint, tick_ns);
  return age_ns < 0 ? JointRecord::kNever
                    : static_cast<std::int32_t>(
                          std::min<std::int64_t>(age_ns / 1000, JointRecord::kNever - 1));
}

}  // namespace

Telemetry::Telemetry(const drivers::Arm& arm, std::int64_t period_ns)
    : arm_(arm), cycles_a_count_(std::max<std::int64_t>(1, kCountEveryNs / period_ns)) {}

void Telemetry::push(std::int64_t index, const control::ArmState& state,
                     const control::ArmCommand& command,
                     const control::ControllerReport& report) noexcept {
  if (counters_.first_tick_ns == 0) {
    counters_.first_tick_ns = state.tick_ns;
  }
  push_record(index, state, command, report);
  if (report.events > 0 || index >= next_count_) {
    next_count_ = index + cycles_a_count_;
    for (std::size_t i = 0; i < state.buses; ++i) {
      counters_.bus[i].state = state.bus[i];
    }
    publish_counters();
  }
  push_events(state, report);
}

void Telemetry::push_record(std::int64_t index, const control::ArmState& state,
                            const control::ArmCommand& command,
                            const control::ControllerReport& report) noexcept {
  record_.index = index;
  record_.tick_ns = state.tick_ns;
  record_.state = report.state;
  record_.law = report.law;
  record_.overran = state.overran;
  record_.authority = static_cast<float>(report.authority);
  record_.retuning = report.retuning;
  record_.arm = report.arm;
  for (std::size_t i = 0; i < state.joints; ++i) {
    const control::JointState& measured = state.joint[i];
    JointRecord& joint = record_.joint[i];
    joint.position = measured.position;
    joint.velocity = report.velocity[i];
    joint.torque = static_cast<float>(measured.torque);
    joint.command = static_cast<float>(command.joint[i].torque);
    joint.model = static_cast<float>(report.model_torque[i]);
    joint.external = static_cast<float>(report.external_torque[i]);
    joint.gain = static_cast<float>(report.gain[i]);
    joint.touched = control::has(report.touched, i);
    joint.static_check = report.static_check[i];
    joint.temperature_c = static_cast<float>(measured.temperature_c);
    joint.age_us = age_us(measured, state.tick_ns);
    joint.condition = measured.condition;
    joint.drive_error = measured.drive_error;
    Counters::Joint& counted = counters_.joint[i];
    counted.missing = report.missing[i];
    counted.max_torque = std::fmax(counted.max_torque, std::fabs(measured.torque));
    counted.max_command = std::fmax(counted.max_command, std::fabs(command.joint[i].torque));
    if (report.authority >= 1.0) {
      counted.max_external = std::fmax(counted.max_external, std::fabs(report.external_torque[i]));
    }
  }
  for (std::size_t i = 0; i < state.buses; ++i) {
    const std::uint64_t sent = arm_.bus_counters(i).sent;
    record_.sent[i] = static_cast<std::uint16_t>(sent - sent_before_[i]);
    sent_before_[i] = sent;
  }
  records_.push(record_);
}

void Telemetry::push_events(const control::ArmState& state,
                            const control::ControllerReport& report) noexcept {
  Event event;
  event.tick_ns = state.tick_ns;
  event.law = report.law;
  for (std::size_t i = 0; i < report.events; ++i) {
    event.fault = report.event[i];
    event.drive_error = 0;
    event.frame_age_ns = -1;
    event.complaint = {};
    if (event.fault.joint >= 0 && static_cast<std::size_t>(event.fault.joint) < state.joints) {
      const auto joint = static_cast<std::size_t>(event.fault.joint);
      event.drive_error = state.joint[joint].drive_error;
      event.frame_age_ns = frame_age_ns(state.joint[joint], state.tick_ns);
      event.last_frame = arm_.last_good_frame(joint);
      event.complaint = arm_.complaint(joint);
    }
    events_.push(event);
  }
  if (report.refused != nullptr) {
    event.kind = Event::Kind::kRefusal;
    event.refusal = report.refused;
    events_.push(event);
  }
  for (std::size_t a = 0; report.arms > 1 && a < report.arms; ++a) {
    if (report.arm[a].state != last_arm_state_[a]) {
      event.kind = Event::Kind::kArmState;
      event.arm = static_cast<int>(a);
      event.law = report.arm[a].law;
      event.from = last_arm_state_[a];
      event.to = report.arm[a].state;
      last_arm_state_[a] = event.to;
      events_.push(event);
    }
  }
  if (report.state != last_state_) {
    event.law = report.law;
    event.kind = Event::Kind::kState;
    event.from = last_state_;
    event.to = report.state;
    last_state_ = report.state;
    events_.push(event);
  }
}

void Telemetry::publish_counters() noexcept {
  for (std::size_t i = 0; i < arm_.joints(); ++i) {
    counters_.joint[i].frames = arm_.joint_counters(i);
    counters_.joint[i].complaint = arm_.complaint(i);
  }
  for (std::size_t i = 0; i < arm_.buses(); ++i) {
    counters_.bus[i].frames = arm_.bus_counters(i);
  }
  published_.back() = counters_;
  published_.publish();
}

void Telemetry::finish() noexcept {
  publish_counters();
  published_.update();
}

}  // namespace geodesic::tools
