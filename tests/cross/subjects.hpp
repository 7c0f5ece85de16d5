// The robots that other engines are asked about as well, and how two answers are compared. No
// engine is named here.
#pragma once

#include <Eigen/Core>
#include <string>
#include <vector>

#include "control/mechanism/mechanism.hpp"
#include "control/mechanism/tree.hpp"
#include "tests/control/mechanism/random_tree.hpp"

namespace geodesic::cross {

struct Subject {
  std::string name;
  control::TreeDescription tree;
  control::Base base = control::Base::kFixed;
};

/// The robots of tests/data/oracles and tests/data/robots, fixed and floating, then random trees of
/// 1 to 32 joints with branches and mimic joints, half of them with joints of every kind.
std::vector<Subject> subjects();

/// Reports a difference above `tolerance` of the largest expected entry (at least 1e-3).
void expect_same(const Eigen::MatrixXd& ours, const Eigen::MatrixXd& theirs, double tolerance,
                 const char* what);

/// How far two right answers may lie apart. Both engines round in double: after up to 60 rotations
/// in a row, each within 2e-16, then sums of some hundred terms that cancel by a factor of ten or
/// so. Seen: 1e-14. A wrong sign, a dropped link or a snapped angle is at 1e-9 or more.
inline constexpr double kRounding = 1e-12;

}  // namespace geodesic::cross
