// Turns frames and hands masses on; all of it once, at load time.
#include "control/mechanism/compact_tree.hpp"

#include <Eigen/Geometry>
#include <cmath>

#include "control/mechanism/mechanism.hpp"

namespace geodesic::control {
namespace {

/// Rz(before) Rx(tilt) Rz(after): any rotation, whether or not its axes are parallel.
struct Turns {
  double before = 0.0;
  SineCosine tilt;
  double after = 0.0;
};

Eigen::Matrix3d about_z(double angle) {
  return Eigen::AngleAxisd(angle, Eigen::Vector3d::UnitZ()).toRotationMatrix();
}

Turns decompose(const Eigen::Matrix3d& rotation) {
  Turns turns;
  turns.tilt = {std::hypot(rotation(0, 2), rotation(1, 2)), rotation(2, 2)};
  if (turns.tilt.sine > 0.0) {
    turns.before = std::atan2(rotation(0, 2), -rotation(1, 2));
  }
  const Eigen::Matrix3d rest = about_z(-turns.before) * rotation;
  turns.after = std::atan2(-rest(0, 1), rest(0, 0));
  return turns;
}

/// What lies on the axis of a turning body, to where it does not move: the parent.
void hand_on(CompactBody& body, CompactBody* parent) {
  const double mass = body.mass;
  const double moment = body.first_moment.z();
  const double second = body.second_moment(2, 2);
  body.mass = 0.0;
  body.first_moment.z() = 0.0;
  body.second_moment(2, 2) = 0.0;
  body.light = true;
  if (parent == nullptr) {
    return;
  }
  const Eigen::Vector3d& p = body.translation;
  const Eigen::Vector3d& z = body.slides_along;
  parent->mass += mass;
  parent->first_moment += mass * p + moment * z;
  parent->second_moment += mass * p * p.transpose() +
                           moment * (p * z.transpose() + z * p.transpose()) +
                           second * z * z.transpose();
}

}  // namespace

std::vector<CompactBody> compact(const std::vector<Body>& bodies) {
  const std::size_t n = bodies.size();
  std::vector<CompactBody> result(n);
  const bool floating = n > 0 && bodies.front().motion == Motion::kFree;
  std::vector<Turns> turns(n);
  std::vector<bool> settled(n, false);  // the frame has been turned for a first child
  std::vector<double> frame_turn(n, 0.0);
  for (std::size_t i = 0; i < n; ++i) {
    if (bodies[i].motion == Motion::kFree) {
      settled[i] = true;  // its wrench is reported in its own axes
      continue;
    }
    turns[i] = decompose(bodies[i].parent_from_joint.rotation);
    const auto parent = static_cast<std::size_t>(std::max(bodies[i].parent, 0));
    if (bodies[i].parent != kWorld && !settled[parent]) {
      frame_turn[parent] = turns[i].before;
      settled[parent] = true;
    }
  }
  for (std::size_t i = 0; i < n; ++i) {
    const Body& from = bodies[i];
    CompactBody& body = result[i];
    body.parent = from.parent;
    body.dof = from.dof;
    body.coordinate = floating && i > 0 ? from.dof + 1 : from.dof;
    body.rotates = from.motion == Motion::kRotation;
    body.free = from.motion == Motion::kFree;
    body.ratio = from.ratio;
    // A leaf's frame is free to make the angle the joint's own.
    const double own_turn = settled[i] ? frame_turn[i] : -turns[i].after;
    const double parent_turn =
        from.parent == kWorld ? 0.0 : frame_turn[static_cast<std::size_t>(from.parent)];
    const double turn = turns[i].before - parent_turn;
    body.turned = turn != 0.0;
    body.turn = {std::sin(turn), std::cos(turn)};
    body.tilt = turns[i].tilt;
    body.rate = body.rotates ? from.ratio : 0.0;
    body.angle_0 = turns[i].after + own_turn + (body.rotates ? from.offset : 0.0);
    body.slide = body.rotates ? 0.0 : from.offset;
    body.translation = about_z(-parent_turn) * from.parent_from_joint.translation;
    body.slides_along = about_z(-parent_turn) * from.parent_from_joint.rotation.col(2);

    const Eigen::Matrix3d to_own = about_z(-own_turn);
    Eigen::Matrix3d inertia = from.inertia.rotational;
    inertia.triangularView<Eigen::StrictlyLower>() = inertia.transpose();
    body.mass = from.inertia.mass;
    body.first_moment = to_own * from.inertia.first_moment;
    body.second_moment = to_own * (0.5 * inertia.trace() * Eigen::Matrix3d::Identity() - inertia) *
                         to_own.transpose();
  }
  for (std::size_t i = n; i-- > 0;) {
    if (result[i].rotates) {
      hand_on(result[i],
              result[i].parent < 0 ? nullptr : &result[static_cast<std::size_t>(result[i].parent)]);
    }
  }
  for (CompactBody& body : result) {
    body.pushes = !body.light;
  }
  for (std::size_t i = n; i-- > 0;) {
    if (result[i].pushes && result[i].parent >= 0) {
      result[static_cast<std::size_t>(result[i].parent)].pushes = true;
    }
  }
  return result;
}

}  // namespace geodesic::control
