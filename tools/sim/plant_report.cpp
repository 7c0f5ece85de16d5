// What the plant records of its arm: the release, drift, rest, contact. It changes no motion.
#include <algorithm>
#include <cmath>

#include "tools/sim/plant.hpp"

namespace geodesic::tools {
namespace {

constexpr double kNs = 1e-9;
constexpr double kRestVelocity = 1e-3;  // [rad/s or m/s]
constexpr double kRestTime = 0.2;       // [s]

}  // namespace

void Plant::let_go() {
  report_.release_s = elapsed_s();
  release_ns_ = now_ns_;
  report_.energy_at_release = physics_.energy();
  for (std::size_t i = 0; i < drives_.size(); ++i) physics_.set_torque(i, torque_[i]);
  const std::vector<double> residual = physics_.unbalanced_torques();
  for (std::size_t i = 0; i < drives_.size(); ++i) {
    report_.joints[i].at_release = physics_.position(i);
    report_.joints[i].residual = residual[i];
  }
}

void Plant::observe() {
  if (!released()) {
    for (std::size_t i = 0; i < drives_.size(); ++i) {
      JointHistory& joint = report_.joints[i];
      joint.motion_before = std::max(joint.motion_before, std::abs(position(i) - joint.start));
      joint.torque_max = std::max(joint.torque_max, std::abs(torque_[i]));
    }
    return;
  }
  const double since_release_s = static_cast<double>(now_ns_ - release_ns_) * kNs;
  double worst = 0.0;
  for (std::size_t i = 0; i < drives_.size(); ++i) {
    JointHistory& joint = report_.joints[i];
    const double drift = std::abs(position(i) - joint.at_release);
    worst = std::max(worst, drift);
    joint.drift_max = std::max(joint.drift_max, drift);
    joint.torque_max = std::max(joint.torque_max, std::abs(torque_[i]));
  }
  const auto bin = static_cast<std::size_t>(since_release_s / PlantReport::kDriftBin);
  if (report_.drift.size() <= bin) report_.drift.resize(bin + 1, 0.0);
  report_.drift[bin] = std::max(report_.drift[bin], worst);

  note_disabled();
  if (!report_.disabled_s) observe_rest(since_release_s);
  if (!robot_.simulation.floor) return;
  const double force = physics_.floor_force();
  if (force > 0.0) report_.contact_s += static_cast<double>(step_ns_) * kNs;
  report_.contact_force_max_n = std::max(report_.contact_force_max_n, force);
}

// After the release, the first drive that is not enabled any more ends what can be called floating.
void Plant::note_disabled() {
  if (!released() || report_.disabled_s) return;
  for (std::size_t i = 0; i < drives_.size(); ++i) {
    if (!enabled(i)) report_.disabled_s = elapsed_s();
  }
}

// At rest: after the last push, every joint slower than kRestVelocity for kRestTime.
void Plant::observe_rest(double since_release_s) {
  if (report_.rest_s) {
    for (std::size_t i = 0; i < drives_.size(); ++i) {
      double& drift = report_.joints[i].drift_rest;
      drift = std::max(drift, std::abs(position(i) - rest_position_[i]));
    }
    return;
  }
  bool slow = since_release_s >= pushes_end_s_;
  for (std::size_t i = 0; i < drives_.size() && slow; ++i) {
    slow = std::abs(velocity(i)) < kRestVelocity;
  }
  if (!slow) {
    at_rest_since_s_ = -1.0;
    return;
  }
  if (at_rest_since_s_ < 0.0) at_rest_since_s_ = since_release_s;
  if (since_release_s - at_rest_since_s_ < kRestTime) return;
  report_.rest_s = elapsed_s();
  rest_position_.clear();
  for (std::size_t i = 0; i < drives_.size(); ++i) rest_position_.push_back(position(i));
}

}  // namespace geodesic::tools
