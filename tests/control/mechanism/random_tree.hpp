// Random trees and states for property tests: every kind of joint, branches, fixed links, mimic
// joints. The same seed gives the same tree.
#pragma once

#include <Eigen/Core>
#include <random>

#include "control/mechanism/mechanism.hpp"
#include "control/mechanism/tree.hpp"

namespace geodesic::control::testing {

struct RandomTreeOptions {
  int joints = 7;          ///< independent
  int mimic_joints = 0;    ///< in addition
  bool any_kind = false;   ///< planar, spherical and floating joints too
  double branching = 0.3;  ///< probability that a joint grows on any earlier link, not the last
};

class RandomArm {
 public:
  explicit RandomArm(unsigned seed) : engine_(seed) {}

  double uniform(double lower, double upper) {
    return std::uniform_real_distribution<double>(lower, upper)(engine_);
  }
  int below(int n) { return std::uniform_int_distribution<int>(0, n - 1)(engine_); }
  Eigen::VectorXd vector(int size, double magnitude = 1.0);
  Eigen::Isometry3d pose();
  LinkInertia inertia();
  TreeDescription tree(const RandomTreeOptions& options);
  /// A point of the configuration space, size nq.
  Eigen::VectorXd configuration(const Mechanism& mechanism);

 private:
  std::mt19937 engine_;
};

/// An arm for one seed of a sweep: size, kinds, base, gravity and rotor inertia vary with it.
Mechanism random_mechanism(unsigned seed);

}  // namespace geodesic::control::testing
