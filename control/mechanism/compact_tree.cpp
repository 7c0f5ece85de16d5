// Turns frames, slides origins and hands masses on; all of it once, at load time.
#include "control/mechanism/compact_tree.hpp"

#include <Eigen/Geometry>
#include <cmath>

#include "control/mechanism/compact_dispatch.hpp"
#include "control/mechanism/mechanism.hpp"

namespace geodesic::control {
namespace {

/// How a body's frame is changed: turned about its z axis, its origin slid along it.
struct Change {
  double turn = 0.0;   ///< [rad]
  double slide = 0.0;  ///< [m]
};

/// Rz(before) Rx(tilt) Rz(after): any rotation, whether or not its axes are parallel.
struct Turns {
  double before = 0.0;
  SineCosine tilt;
  double after = 0.0;
};

/// Inertia in the changed frame, and with what lighter bodies hand on.
struct Moments {
  double mass = 0.0;
  Eigen::Vector3d first = Eigen::Vector3d::Zero();
  Eigen::Matrix3d second = Eigen::Matrix3d::Zero();
};

double cleaned(double value) {
  return std::abs(value) <= kNegligible ? 0.0 : value;
}

/// Of an angle; a multiple of a right angle gives zeros and ones.
SineCosine cleaned_sine_cosine(double angle) {
  return {cleaned(std::sin(angle)), cleaned(std::cos(angle))};
}

Eigen::Matrix3d about_z(double angle) {
  const auto [s, c] = cleaned_sine_cosine(angle);
  Eigen::Matrix3d rotation;
  rotation << c, -s, 0.0, s, c, 0.0, 0.0, 0.0, 1.0;
  return rotation;
}

Turns decompose(const Eigen::Matrix3d& rotation) {
  Turns turns;
  turns.tilt = {cleaned(std::hypot(rotation(0, 2), rotation(1, 2))), cleaned(rotation(2, 2))};
  if (turns.tilt.sine > 0.0) {
    turns.before = std::atan2(rotation(0, 2), -rotation(1, 2));
  }
  const Eigen::Matrix3d rest = about_z(-turns.before) * rotation;
  turns.after = std::atan2(-rest(0, 1), rest(0, 0));
  return turns;
}

bool parallel(const Turns& turns) {
  return turns.tilt.sine == 0.0 && turns.tilt.cosine > 0.0;
}

/// Decides how each frame is changed: from the tips, since an origin slides to suit the child's.
/// Bodies with more than one degree of freedom report in their own axes and stay as they are.
std::vector<Change> changes(const std::vector<Body>& bodies, const std::vector<Turns>& turns) {
  const std::size_t n = bodies.size();
  std::vector<int> first_child(n, -1);
  for (std::size_t i = n; i-- > 0;) {
    if (bodies[i].parent != kWorld) {
      first_child[static_cast<std::size_t>(bodies[i].parent)] = static_cast<int>(i);
    }
  }
  std::vector<Change> result(n);
  for (std::size_t i = n; i-- > 0;) {
    if (freedoms(bodies[i].motion) > 1) {
      continue;
    }
    const Pose& pose = bodies[i].parent_from_joint;
    if (first_child[i] < 0) {
      // A tip's frame is free to make the angle the joint's own, its origin to come closest.
      result[i].slide =
          bodies[i].parent == kWorld ? 0.0 : -pose.translation.dot(pose.rotation.col(2));
      continue;
    }
    const auto child = static_cast<std::size_t>(first_child[i]);
    const Pose& below = bodies[child].parent_from_joint;
    const Eigen::Vector3d joint = below.translation + result[child].slide * below.rotation.col(2);
    result[i].slide = joint.z();
    result[i].turn =
        !parallel(turns[child]) || freedoms(bodies[child].motion) > 1
            ? turns[child].before
            : (joint.head<2>().norm() > kNegligible ? std::atan2(joint.y(), joint.x()) : 0.0);
  }
  for (std::size_t i = 0; i < n; ++i) {
    if (first_child[i] < 0 && freedoms(bodies[i].motion) == 1) {
      const bool follows = bodies[i].parent != kWorld && parallel(turns[i]);
      result[i].turn = (follows ? result[static_cast<std::size_t>(bodies[i].parent)].turn : 0.0) -
                       turns[i].after;
    }
  }
  return result;
}

Moments moments(const Body& body, const Change& change) {
  const Eigen::Matrix3d to_own = about_z(-change.turn);
  Eigen::Matrix3d inertia = body.inertia.rotational;
  inertia.triangularView<Eigen::StrictlyLower>() = inertia.transpose();
  const double mass = body.inertia.mass;
  const Eigen::Vector3d first = body.inertia.first_moment;
  const Eigen::Vector3d d(0.0, 0.0, -change.slide);  // of the old origin from the new
  Eigen::Matrix3d second = 0.5 * inertia.trace() * Eigen::Matrix3d::Identity() - inertia;
  second += first * d.transpose() + d * first.transpose() + mass * d * d.transpose();
  return {mass, to_own * (first + mass * d), to_own * second * to_own.transpose()};
}

/// The joint in the changed frames of its parent and of its body. @return its angle at q = 0 [rad].
double place(const Body& from, const Turns& turns, const Change& parent, const Change& own,
             CompactBody& body) {
  const Pose& pose = from.parent_from_joint;
  const double turn = turns.before - parent.turn;
  double angle = turns.after + own.turn + (body.rotates ? from.offset : 0.0);
  const Eigen::Matrix3d to_parent = about_z(-parent.turn);
  const Eigen::Vector3d at = to_parent * (pose.translation + own.slide * pose.rotation.col(2)) -
                             parent.slide * Eigen::Vector3d::UnitZ();
  const Eigen::Vector3d along = to_parent * pose.rotation.col(2);
  body.x = cleaned(at.x());
  body.y = cleaned(at.y());
  body.z = cleaned(at.z());
  body.slides_along = {along.x(), along.y(), along.z()};
  body.slide = from.motion == Motion::kTranslation ? from.offset : 0.0;
  if (parallel(turns)) {
    body.tilt = Tilt::kNone;
    angle = turn + angle;
  } else {
    const bool quarter = turns.tilt.cosine == 0.0 && std::abs(turn) <= kNegligible;
    body.tilt = quarter ? Tilt::kQuarter : Tilt::kAny;
    body.lean = turns.tilt;
    body.turn = cleaned_sine_cosine(turn);
    body.turned = std::abs(turn) > kNegligible;
  }
  const bool moves = from.motion == Motion::kTranslation || from.motion == Motion::kFree;
  if (moves || body.z != 0.0) {
    body.reach = Reach::kAny;
  } else {
    body.reach = body.x != 0.0 || body.y != 0.0 ? Reach::kInPlane : Reach::kNone;
  }
  return cleaned(angle);
}

/// At the world only the direction of gravity matters, in the joint's own axes. @return as place().
double place_at_base(const Body& from, const Change& own, const Eigen::Vector3d& gravity,
                     CompactBody& body) {
  const Eigen::Vector3d up = -(from.parent_from_joint.rotation.transpose() * gravity);
  body.up = {cleaned(up.x()), cleaned(up.y()), cleaned(up.z())};
  return own.turn + (body.rotates ? from.offset : 0.0);
}

Step step_of(const CompactBody& body) {
  if (!body.chained || !body.rotates || body.forks || body.reach == Reach::kAny) {
    return Step::kGeneral;
  }
  const bool reaches = body.reach == Reach::kInPlane;
  if (body.tilt == Tilt::kQuarter) {
    return reaches ? Step::kQuarterReaching : Step::kQuarter;
  }
  if (body.tilt == Tilt::kAny) {
    return reaches ? Step::kAnyReaching : Step::kAny;
  }
  return reaches ? Step::kParallelReaching : Step::kGeneral;
}

/// What lies on the axis of a turning body, to where it does not move: the parent.
void hand_on(const CompactBody& body, Moments& own, Moments* parent) {
  const double mass = own.mass;
  const double moment = own.first.z();
  const double second = own.second(2, 2);
  own.mass = 0.0;
  own.first.z() = 0.0;
  own.second(2, 2) = 0.0;
  if (parent == nullptr) {
    return;
  }
  const Eigen::Vector3d p(body.x, body.y, body.z);
  const Eigen::Vector3d z(body.slides_along.x, body.slides_along.y, body.slides_along.z);
  parent->mass += mass;
  parent->first += mass * p + moment * z;
  parent->second += mass * p * p.transpose() + moment * (p * z.transpose() + z * p.transpose()) +
                    second * z * z.transpose();
}

void write(const Moments& from, CompactBody& body) {
  body.mass = from.mass;
  body.h_x = from.first.x();
  body.h_y = from.first.y();
  body.h_z = from.first.z();
  body.s_xx = from.second(0, 0);
  body.s_xy = from.second(0, 1);
  body.s_xz = from.second(0, 2);
  body.s_yy = from.second(1, 1);
  body.s_yz = from.second(1, 2);
  body.s_zz = from.second(2, 2);
}

}  // namespace

CompactTree compact(const std::vector<Body>& bodies, const Eigen::Vector3d& gravity) {
  const std::size_t n = bodies.size();
  std::vector<Turns> turns(n);
  for (std::size_t i = 0; i < n; ++i) {
    turns[i] = decompose(bodies[i].parent_from_joint.rotation);
  }
  const std::vector<Change> change = changes(bodies, turns);
  CompactTree tree{std::vector<CompactBody>(n), std::vector<int>(n + kMostLanes, 0),
                   std::vector<double>(n + kMostLanes, 0.0),
                   std::vector<double>(n + kMostLanes, 0.0)};
  std::vector<CompactBody>& result = tree.bodies;
  std::vector<Moments> own(n);
  for (std::size_t i = 0; i < n; ++i) {
    const Body& from = bodies[i];
    CompactBody& body = result[i];
    body.parent = static_cast<short>(from.parent);
    body.dof = static_cast<short>(from.dof);
    body.coordinate = static_cast<short>(from.coordinate);
    body.motion = from.motion;
    body.ratio = from.ratio;
    body.rotates = from.motion == Motion::kRotation;
    body.light = body.rotates;
    body.many = freedoms(from.motion) > 1;
    body.at_base = from.parent == kWorld;
    body.chained = from.parent != kWorld && from.parent == static_cast<int>(i) - 1;
    body.pushes = !body.light;
    own[i] = moments(from, change[i]);
    tree.coordinate[i] = from.coordinate;
    tree.rate[i] = body.rotates ? from.ratio : 0.0;
    if (body.at_base) {
      tree.angle_0[i] = place_at_base(from, change[i], gravity, body);
    } else {
      const auto parent = static_cast<std::size_t>(from.parent);
      tree.angle_0[i] = place(from, turns[i], change[parent], change[i], body);
      result[parent].forks = result[parent].forks || !body.chained;
    }
  }
  for (std::size_t i = n; i-- > 0;) {
    const auto parent = static_cast<std::size_t>(std::max(bodies[i].parent, 0));
    if (result[i].light) {
      hand_on(result[i], own[i], result[i].at_base ? nullptr : &own[parent]);
    }
    write(own[i], result[i]);
    if (result[i].pushes && !result[i].at_base) {
      result[parent].pushes = true;
    }
  }
  for (CompactBody& body : result) {
    body.step = step_of(body);
  }
  return tree;
}

}  // namespace geodesic::control
