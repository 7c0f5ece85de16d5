// Reach and worst gravity torques by random search and coordinate ascent; see the header.
#include "tools/geodesic/workload.hpp"

#include <algorithm>
#include <cmath>
#include <functional>
#include <numbers>
#include <random>

namespace geodesic::tools {
namespace {

constexpr int kSamples = 3000;
constexpr int kRounds = 30;

struct Range {
  double lower;
  double upper;
};

std::vector<Range> ranges_of(const config::Robot& robot, const control::Mechanism& mechanism) {
  std::vector<Range> ranges;
  for (std::size_t i = 0; i < mechanism.joint_limits().size(); ++i) {
    const control::JointLimits& limits = mechanism.joint_limits()[i];
    Range range{limits.lower, limits.upper};
    if (i < robot.controller.joints.size()) {
      range.lower = std::max(range.lower, robot.controller.joints[i].position_lower);
      range.upper = std::min(range.upper, robot.controller.joints[i].position_upper);
    }
    if (!std::isfinite(range.lower)) range.lower = -std::numbers::pi;
    if (!std::isfinite(range.upper)) range.upper = std::numbers::pi;
    ranges.push_back(range);
  }
  return ranges;
}

// Improves q joint by joint, in ever smaller steps; the ranges are kept.
double ascend(const std::vector<Range>& ranges, Eigen::VectorXd& q,
              const std::function<double(const Eigen::VectorXd&)>& value) {
  double best = value(q);
  double step = 0.25;
  for (int round = 0; round < kRounds; ++round) {
    bool better = false;
    for (Eigen::Index i = 0; i < q.size(); ++i) {
      const Range& range = ranges[static_cast<std::size_t>(i)];
      for (const double sign : {1.0, -1.0}) {
        const double before = q[i];
        const double width = range.upper - range.lower;
        q[i] = std::clamp(before + sign * step * width, range.lower, range.upper);
        const double found = value(q);
        if (found > best) {
          best = found;
          better = true;
        } else {
          q[i] = before;
        }
      }
    }
    if (!better) step *= 0.5;
  }
  return best;
}

}  // namespace

Workload find_workload(const config::Robot& robot, const control::Mechanism& mechanism,
                       int tool_link) {
  const std::vector<Range> ranges = ranges_of(robot, mechanism);
  const Eigen::Index count = mechanism.nq();
  const auto joints = static_cast<std::size_t>(count);
  control::Workspace workspace(mechanism);
  const Eigen::Vector3d foot = mechanism.bodies().empty()
                                   ? Eigen::Vector3d::Zero()
                                   : mechanism.bodies().front().parent_from_joint.translation;
  const auto reach = [&](const Eigen::VectorXd& q) {
    return (control::link_pose(mechanism, q, tool_link).translation - foot).norm();
  };

  std::mt19937 random(1);  // NOLINT(bugprone-random-generator-seed): repeatable on purpose
  std::vector<Eigen::VectorXd> worst(joints, Eigen::VectorXd::Zero(count));
  std::vector<double> most(joints, -1.0);
  Eigen::VectorXd farthest = Eigen::VectorXd::Zero(count);
  double far = -1.0;
  for (int sample = 0; sample < kSamples; ++sample) {
    Eigen::VectorXd q(count);
    for (Eigen::Index i = 0; i < count; ++i) {
      const Range& range = ranges[static_cast<std::size_t>(i)];
      const double part = static_cast<double>(random()) / static_cast<double>(std::mt19937::max());
      q[i] = range.lower + part * (range.upper - range.lower);
    }
    const Eigen::VectorXd& torque = control::gravity(mechanism, workspace, q);
    for (std::size_t i = 0; i < joints; ++i) {
      const double size = std::abs(torque[static_cast<Eigen::Index>(i)]);
      if (size <= most[i]) continue;
      most[i] = size;
      worst[i] = q;
    }
    if (reach(q) > far) {
      far = reach(q);
      farthest = q;
    }
  }

  Workload result;
  result.reach_m = ascend(ranges, farthest, reach);
  for (std::size_t i = 0; i < joints; ++i) {
    JointWorkload joint;
    joint.gravity_max = ascend(ranges, worst[i], [&](const Eigen::VectorXd& q) {
      return std::abs(control::gravity(mechanism, workspace, q)[static_cast<Eigen::Index>(i)]);
    });
    joint.worst_pose.assign(worst[i].begin(), worst[i].end());
    joint.torque_limit = robot.controller.joints[i].torque_limit;
    joint.drive_range = robot.arm.joints[i].drive.torque_range_nm / robot.arm.joints[i].ratio;
    joint.effort = mechanism.joint_limits()[i].effort;
    joint.available = std::min({joint.torque_limit, joint.drive_range, joint.effort});
    result.joints.push_back(std::move(joint));
  }
  return result;
}

}  // namespace geodesic::tools
