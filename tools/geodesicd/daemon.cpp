// One cycle of the real-time thread.
#include "tools/geodesicd/daemon.hpp"

#include <algorithm>
#include <span>

namespace geodesic::tools {

Daemon::Daemon(drivers::Arm& arm, control::Controller& controller, const DaemonOptions& options)
    : arm_(arm),
      controller_(controller),
      period_ns_(options.period_ns),
      receive_budget_ns_(options.receive_budget_ns),
      lifetime_(options.lifetime),
      phases_(options.measure_phases),
      telemetry_(arm, options.period_ns) {
  command_.joints = arm.joints();
}

rt::Next Daemon::step(const rt::Tick& tick) noexcept {
  phases_.begin();
  arm_.transmit(command_, tick.due_ns);  // computed in the last cycle: leaves on time
  phases_.transmit_done();

  state_ = arm_.receive(tick.due_ns, tick.due_ns + receive_budget_ns_);
  state_.overran = tick.skipped > 0;
  state_.forbidden_call = tick.refused_call;
  phases_.receive_done();

  take_setup();
  take_requests();
  command_ = controller_.update(state_, period_ns_);
  const Course course = follow_course();
  arm_.prepare(command_, tick.due_ns + period_ns_);
  phases_.compute_done(arm_.last_read_ns());

  controller_.observe();
  phases_.observe_done();
  telemetry_.push(tick.index, state_, command_, controller_.report());
  phases_.publish_done();
  return course == Course::kOver ? rt::Next::kStop : rt::Next::kContinue;
}

void Daemon::take_setup() noexcept {
  if (const control::Setup* setup = setups_.follow(controller_)) {
    lifetime_.retune(setup->options.safety);
  }
}

void Daemon::take_requests() noexcept {
  control::Request request;
  while (requests_.pop(request)) {
    controller_.request(request);
  }
}

Course Daemon::follow_course() noexcept {
  if (controller_.report().restart_drives) {
    arm_.restart(controller_.report().restart);
  }
  const auto joints = std::span(state_.joint).first(state_.joints);
  const bool any_enabled = std::any_of(joints.begin(), joints.end(), [](const auto& joint) {
    return joint.condition == control::DriveCondition::kEnabled;
  });
  const Course course = lifetime_.update(controller_.report().state, any_enabled, state_.tick_ns);
  if (course == Course::kAskStop) {
    controller_.request({control::Request::Kind::kStop, {}});
  } else if (course == Course::kTorqueOff) {
    command_.joint.fill({control::DriveMode::kDisable, 0.0, 0.0, 0.0, 0.0, 0.0});
  }
  return course;
}

}  // namespace geodesic::tools
