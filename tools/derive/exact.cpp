// Recognises exact figures; see the header.
#include "tools/derive/exact.hpp"

#include <fmt/format.h>

#include <Eigen/Geometry>
#include <array>
#include <cmath>
#include <optional>

namespace geodesic::tools::derive {
namespace {

constexpr double kTurnTolerance = 1e-10;
constexpr double kRounding = 1e-15;
constexpr double kLengthTolerance = 1e-12;
constexpr double kInertiaTolerance = 1e-10;

// Entries of rotations by multiples of 15 degrees and of products of two such by 30 or 45 degrees.
std::array<long double, 12> exact_entries() {
  const long double r2 = std::sqrt(2.0L);
  const long double r3 = std::sqrt(3.0L);
  return {0.0L,
          0.25L,
          r2 / 4,
          r3 / 4,
          0.5L,
          r2 * r3 / 4,
          r2 / 2,
          0.75L,
          r3 / 2,
          1.0L,
          r2 * (r3 - 1) / 4,
          r2 * (r3 + 1) / 4};
}

std::optional<long double> exact_entry(double value, double tolerance) {
  static const auto entries = exact_entries();
  for (const long double entry : entries) {
    if (std::abs(std::abs(static_cast<long double>(value)) - entry) <= tolerance) {
      return value < 0.0 ? -entry : entry;
    }
  }
  return std::nullopt;
}

std::optional<LongMatrix3> exact_matrix(const Eigen::Matrix3d& rotation, double tolerance) {
  LongMatrix3 exact;
  for (Eigen::Index i = 0; i < 9; ++i) {
    const auto entry = exact_entry(rotation(i), tolerance);
    if (!entry) return std::nullopt;
    exact(i) = *entry;
  }
  const LongMatrix3 rest = exact.transpose() * exact - LongMatrix3::Identity();
  if (rest.cwiseAbs().maxCoeff() > 1e-17L) return std::nullopt;
  return exact;
}

// Assigns and returns how far it was off; nothing if it is as exact as doubles are.
std::optional<double> make_exact(Eigen::Matrix3d& rotation) {
  const auto exact = exact_matrix(rotation, kTurnTolerance);
  if (!exact) return std::nullopt;
  const Eigen::Matrix3d rounded = exact->cast<double>();
  const double off = (rounded - rotation).cwiseAbs().maxCoeff();
  rotation = rounded;
  return off > kRounding ? std::optional(off) : std::nullopt;
}

std::optional<double> make_exact(Eigen::Vector3d& axis) {
  Eigen::Matrix<long double, 3, 1> exact;
  for (Eigen::Index i = 0; i < 3; ++i) {
    const auto entry = exact_entry(axis[i], kTurnTolerance);
    if (!entry) return std::nullopt;
    exact[i] = *entry;
  }
  if (std::abs(exact.squaredNorm() - 1.0L) > 1e-17L) return std::nullopt;
  const Eigen::Vector3d rounded = exact.cast<double>();
  const double off = (rounded - axis).cwiseAbs().maxCoeff();
  axis = rounded;
  return off > kRounding ? std::optional(off) : std::nullopt;
}

// The largest figure that was dropped; 0 if none was.
template <typename Figures>
double drop_below(Figures&& figures, double bound) {
  double largest = 0.0;
  for (double& figure : figures.reshaped()) {
    if (figure == 0.0 || std::abs(figure) >= bound) continue;
    largest = std::max(largest, std::abs(figure));
    figure = 0.0;
  }
  return largest;
}

}  // namespace

ExactTree exact_tree(const control::TreeDescription& tree) {
  ExactTree result{tree, {}};
  const auto note = [&](const std::string& text) { result.notes.push_back(text); };
  for (control::JointDescription& joint : result.tree.joints) {
    Eigen::Matrix3d rotation = joint.parent_from_joint.linear();
    if (const auto off = make_exact(rotation)) {
      note(fmt::format("joint '{}': the rotation of its frame, {:.1e} off, is taken as {}",
                       joint.name, *off, "a turn by whole multiples of 15 degrees"));
    }
    joint.parent_from_joint.linear() = rotation;
    Eigen::Vector3d translation = joint.parent_from_joint.translation();
    if (const double most = drop_below(translation, kLengthTolerance); most > 0.0) {
      note(fmt::format("joint '{}': offsets up to {:.1e} m are taken as 0", joint.name, most));
    }
    joint.parent_from_joint.translation() = translation;
    if (joint.kind == control::JointKind::kFixed) continue;
    if (const auto off = make_exact(joint.axis)) {
      note(
          fmt::format("joint '{}': its axis, {:.1e} off, is taken as a coordinate axis or a turn "
                      "of one by whole multiples of 15 degrees",
                      joint.name, *off));
    }
  }
  for (control::LinkDescription& link : result.tree.links) {
    Eigen::Matrix3d& inertia = link.inertia.inertia_kg_m2;
    const double bound = kInertiaTolerance * inertia.cwiseAbs().maxCoeff();
    if (const double most = drop_below(inertia, bound); most > 0.0) {
      note(
          fmt::format("link '{}': moments and products of inertia up to {:.1e} kg·m² are taken "
                      "as 0",
                      link.name, most));
    }
    if (const double most = drop_below(link.inertia.com_m, kLengthTolerance); most > 0.0) {
      note(fmt::format("link '{}': coordinates of its centre of mass up to {:.1e} m are taken as 0",
                       link.name, most));
    }
  }
  return result;
}

LongMatrix3 exact_rotation(const Eigen::Matrix3d& rotation) {
  if (const auto exact = exact_matrix(rotation, kRounding)) return *exact;
  LongMatrix3 orthonormal = rotation.cast<long double>();
  // Newton's step for the polar decomposition: two of them double 16 digits twice.
  for (int step = 0; step < 2; ++step) {
    const LongMatrix3 square = orthonormal.transpose() * orthonormal;
    orthonormal = (orthonormal * (3.0L * LongMatrix3::Identity() - square) / 2.0L).eval();
  }
  return orthonormal;
}

}  // namespace geodesic::tools::derive
