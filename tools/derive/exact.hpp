// Figures that stand for exact ones: 1.57079632679 for a quarter turn, 6e-17 for nothing. Closed
// forms are short only when such zeros are zeros; every figure taken for another is reported.
#pragma once

#include <Eigen/Core>
#include <string>
#include <vector>

#include "control/mechanism/tree.hpp"

namespace geodesic::tools::derive {

using LongMatrix3 = Eigen::Matrix<long double, 3, 3>;

struct ExactTree {
  control::TreeDescription tree;
  std::vector<std::string> notes;  ///< one for every figure that was taken for another
};

/// Rotations and axes within 1e-10 of turns by multiples of 15 degrees about coordinate axes (and
/// of products of such) become those; lengths below 1e-12 m and products of inertia below 1e-10 of
/// the largest moment become 0. The metric changes by no more than some 1e-10 of itself.
ExactTree exact_tree(const control::TreeDescription& tree);

/// The rotation that `rotation` is the nearest double to: exact where it is one of those above,
/// else orthonormal to the last digit of long double.
LongMatrix3 exact_rotation(const Eigen::Matrix3d& rotation);

}  // namespace geodesic::tools::derive
