// Twists and wrenches in named frames: each against its definition by the motion of points, and all
// against the power that no choice of frame can change.
#include "control/mechanism/link_frame.hpp"

#include <gtest/gtest.h>

#include <string>

#include "control/mechanism/configuration.hpp"
#include "rt/heap_counter.hpp"
#include "tests/control/mechanism/random_tree.hpp"

namespace geodesic::control {
namespace {

using Eigen::Vector3d;
using Eigen::VectorXd;
using testing::RandomArm;

constexpr Frame kFrames[] = {Frame::kLink, Frame::kWorldOrigin, Frame::kLinkOrigin};

Twist difference(const Twist& a, const Twist& b) {
  return {a.linear - b.linear, a.angular - b.angular};
}
double size(const Twist& x) {
  return x.linear.norm() + x.angular.norm();
}

TEST(LinkFrames, TwistsAreTheMotionOfPoses) {
  constexpr double kStep = 1e-5;
  for (unsigned seed = 0; seed < 24; ++seed) {
    SCOPED_TRACE("seed " + std::to_string(seed));
    const Mechanism m = testing::random_mechanism(seed);
    Workspace w(m);
    RandomArm random(300 + seed);
    const VectorXd q = random.configuration(m);
    const VectorXd v = random.vector(m.dof());
    VectorXd before = q;
    VectorXd after = q;
    integrate(m, q, v, -kStep, before);
    integrate(m, q, v, kStep, after);
    const int link = random.below(static_cast<int>(m.links().size()));
    const Pose at = link_pose(m, q, link);
    const Pose from = link_pose(m, before, link);
    const Pose to = link_pose(m, after, link);
    const Twist local = (0.5 / kStep) * log(inverse(from) * to);
    const Twist world = (0.5 / kStep) * log(to * inverse(from));
    const Twist aligned{(0.5 / kStep) * (to.translation - from.translation), world.angular};
    const double tolerance = 1e-7 * (1.0 + size(world) * size(world) * size(world));
    EXPECT_LE(size(difference(link_twist(m, w, q, v, link, Frame::kLink), local)), tolerance);
    EXPECT_LE(size(difference(link_twist(m, w, q, v, link, Frame::kWorldOrigin), world)),
              tolerance);
    EXPECT_LE(size(difference(link_twist(m, w, q, v, link, Frame::kLinkOrigin), aligned)),
              tolerance);
    EXPECT_LE(size(difference(to_parent(at, link_twist(m, w, q, v, link, Frame::kLink)),
                              link_twist(m, w, q, v, link, Frame::kWorldOrigin))),
              1e-12 * (1.0 + size(world)))
        << "Ad";
  }
}

TEST(LinkFrames, PowerIsTheSameInEveryFrameAndAtTheJoints) {
  for (unsigned seed = 0; seed < 24; ++seed) {
    SCOPED_TRACE("seed " + std::to_string(seed));
    const Mechanism m = testing::random_mechanism(seed);
    Workspace w(m);
    RandomArm random(400 + seed);
    const VectorXd q = random.configuration(m);
    const VectorXd v = random.vector(m.dof());
    const int link = random.below(static_cast<int>(m.links().size()));
    const Wrench local{Vector3d(random.vector(3, 5.0)), Vector3d(random.vector(3, 2.0))};
    const double power = dot(local, link_twist(m, w, q, v, link, Frame::kLink));
    const double tolerance = 1e-12 * (1.0 + std::abs(power) + 10.0 * v.norm());
    for (const Frame frame : kFrames) {
      const std::uint64_t heap = rt::heap_calls();
      const Wrench there = link_wrench(m, q, link, local, Frame::kLink, frame);
      const Twist twist = link_twist(m, w, q, v, link, frame);
      const Jacobian& j = jacobian(m, w, q, link, frame);
      EXPECT_EQ(rt::heap_calls(), heap);
      EXPECT_NEAR(dot(there, twist), power, tolerance);
      const Eigen::Matrix<double, 6, 1> mapped = j * v;
      EXPECT_LE(size(difference(twist, {mapped.head<3>(), mapped.tail<3>()})),
                1e-12 * (1.0 + mapped.norm()));
      for (const Frame other : kFrames) {
        const Wrench moved = link_wrench(m, q, link, there, frame, other);
        const Wrench back = link_wrench(m, q, link, moved, other, Frame::kLink);
        EXPECT_LE((back.force - local.force).norm() + (back.moment - local.moment).norm(), 1e-12);
      }
    }
  }
}

TEST(LinkFrames, AForceAtAPointHasAMomentAboutTheWorldsOrigin) {
  TreeDescription tree;
  tree.root_link = "base";
  tree.links = {{"base", {}}, {"tool", {}}};
  JointDescription joint;
  joint.name = "turn";
  joint.kind = JointKind::kContinuous;
  joint.parent_link = "base";
  joint.child_link = "tool";
  joint.axis = Vector3d::UnitZ();
  joint.parent_from_joint.translation() = Vector3d(2.0, 0.0, 0.0);
  tree.joints = {joint};
  const Mechanism m(tree, Vector3d::Zero());
  const VectorXd q = VectorXd::Constant(1, 0.5 * M_PI);
  // 3 N along the link's x axis, which now is the world's y, at (2, 0, 0).
  const Wrench along_x{Vector3d(3.0, 0.0, 0.0), Vector3d::Zero()};
  const Wrench aligned = link_wrench(m, q, 1, along_x, Frame::kLink, Frame::kLinkOrigin);
  EXPECT_LE((aligned.force - Vector3d(0.0, 3.0, 0.0)).norm(), 1e-15);
  EXPECT_LE(aligned.moment.norm(), 1e-15);
  const Wrench world = link_wrench(m, q, 1, along_x, Frame::kLink, Frame::kWorldOrigin);
  EXPECT_LE((world.moment - Vector3d(0.0, 0.0, 6.0)).norm(), 1e-15);
}

}  // namespace
}  // namespace geodesic::control
