// Implements configuration.hpp, factor by factor.
#include "control/mechanism/configuration.hpp"

#include <Eigen/Geometry>
#include <cassert>
#include <cmath>
#include <numbers>

#include "control/geometry/se3.hpp"
#include "control/geometry/so2.hpp"
#include "control/geometry/so3.hpp"

namespace geodesic::control {
namespace {

/// A velocity or step of one factor; its first nv numbers count.
using FactorStep = Eigen::Matrix<double, 6, 1>;
using Numbers = Eigen::Ref<Eigen::VectorXd>;

bool has_quaternion(const Factor& factor) noexcept {
  return factor.nq > factor.nv;
}

/// Index in q of the factor's quaternion, which is last.
int quaternion_at(const Factor& factor) noexcept {
  return factor.q + factor.nq - 4;
}

Eigen::Quaterniond orientation(const Factor& factor, const VectorIn& q) noexcept {
  const int at = quaternion_at(factor);
  return Eigen::Quaterniond(q[at + 3], q[at], q[at + 1], q[at + 2]).normalized();
}

/// Whether number i of the factor is an angle that a whole turn brings back.
bool is_cyclic(const Factor& factor, int i) noexcept {
  return factor.kind == JointKind::kContinuous || (factor.kind == JointKind::kPlanar && i == 2);
}

bool is_angle(const Factor& factor, int i) noexcept {
  return factor.kind == JointKind::kRevolute || is_cyclic(factor, i);
}

void step(const Factor& factor, const VectorIn& q, const FactorStep& by, Numbers result) noexcept {
  if (!has_quaternion(factor)) {
    for (int i = 0; i < factor.nq; ++i) {
      result[factor.q + i] = q[factor.q + i] + by[i];
    }
    return;
  }
  const Eigen::Quaterniond from = orientation(factor, q);
  const Eigen::Vector3d angular = by.segment<3>(factor.nv - 3);
  if (factor.kind == JointKind::kFloating) {
    const Pose moved = exp(Twist{by.head<3>(), angular});
    const Eigen::Vector3d position = q.segment<3>(factor.q) + from * moved.translation;
    result.segment<3>(factor.q) = position;
  }
  result.segment<4>(quaternion_at(factor)) = (from * quaternion_exp(angular)).normalized().coeffs();
}

FactorStep way(const Factor& factor, const VectorIn& q0, const VectorIn& q1) noexcept {
  FactorStep by = FactorStep::Zero();
  if (!has_quaternion(factor)) {
    for (int i = 0; i < factor.nv; ++i) {
      const double from = q0[factor.q + i];
      const double to = q1[factor.q + i];
      by[i] = is_cyclic(factor, i) ? shortest_turn(from, to) : to - from;
    }
    return by;
  }
  const Eigen::Quaterniond from = orientation(factor, q0);
  const Eigen::Vector3d angular = log(from.conjugate() * orientation(factor, q1));
  if (factor.kind == JointKind::kFloating) {
    const Eigen::Vector3d moved =
        from.conjugate() * Eigen::Vector3d(q1.segment<3>(factor.q) - q0.segment<3>(factor.q));
    by.head<3>() = left_jacobian_inverse(angular) * moved;
  }
  by.segment<3>(factor.nv - 3) = angular;
  return by;
}

double squared_distance(const Factor& factor, const VectorIn& q0, const VectorIn& q1,
                        double metres_per_radian) noexcept {
  double sum = 0.0;
  const auto add = [&sum](double distance) { sum += distance * distance; };
  if (!has_quaternion(factor)) {
    const FactorStep by = way(factor, q0, q1);
    for (int i = 0; i < factor.nv; ++i) {
      add(is_angle(factor, i) ? metres_per_radian * by[i] : by[i]);
    }
    return sum;
  }
  if (factor.kind == JointKind::kFloating) {
    add((q1.segment<3>(factor.q) - q0.segment<3>(factor.q)).norm());
  }
  add(SO3::distance(orientation(factor, q0), orientation(factor, q1), metres_per_radian));
  return sum;
}

}  // namespace

Eigen::VectorXd neutral(const Mechanism& mechanism) {
  Eigen::VectorXd q = Eigen::VectorXd::Zero(mechanism.nq());
  for (const Factor& factor : mechanism.factors()) {
    if (has_quaternion(factor)) {
      q[quaternion_at(factor) + 3] = 1.0;
    }
  }
  return q;
}

void integrate(const Mechanism& mechanism, const VectorIn& q, const VectorIn& v, double dt,
               Eigen::Ref<Eigen::VectorXd> result) noexcept {
  assert(q.size() == mechanism.nq() && v.size() == mechanism.dof() && result.size() == q.size());
  for (const Factor& factor : mechanism.factors()) {
    FactorStep by = FactorStep::Zero();
    for (int i = 0; i < factor.nv; ++i) {
      by[i] = dt * v[factor.v + i];
    }
    step(factor, q, by, result);
  }
}

void difference(const Mechanism& mechanism, const VectorIn& q0, const VectorIn& q1,
                Eigen::Ref<Eigen::VectorXd> v) noexcept {
  assert(q0.size() == mechanism.nq() && q1.size() == q0.size() && v.size() == mechanism.dof());
  for (const Factor& factor : mechanism.factors()) {
    v.segment(factor.v, factor.nv) = way(factor, q0, q1).head(factor.nv);
  }
}

void interpolate(const Mechanism& mechanism, const VectorIn& q0, const VectorIn& q1, double share,
                 Eigen::Ref<Eigen::VectorXd> result) noexcept {
  assert(q0.size() == mechanism.nq() && q1.size() == q0.size() && result.size() == q0.size());
  for (const Factor& factor : mechanism.factors()) {
    const FactorStep by = share * way(factor, q0, q1);
    step(factor, q0, by, result);
  }
}

double distance(const Mechanism& mechanism, const VectorIn& q0, const VectorIn& q1,
                double metres_per_radian) noexcept {
  assert(q0.size() == mechanism.nq() && q1.size() == q0.size());
  double sum = 0.0;
  for (const Factor& factor : mechanism.factors()) {
    sum += squared_distance(factor, q0, q1, metres_per_radian);
  }
  return std::sqrt(sum);
}

void normalise(const Mechanism& mechanism, Eigen::Ref<Eigen::VectorXd> q) noexcept {
  assert(q.size() == mechanism.nq());
  for (const Factor& factor : mechanism.factors()) {
    if (has_quaternion(factor)) {
      auto numbers = q.segment<4>(quaternion_at(factor));
      const double length = numbers.stableNorm();
      if (length > 0.0) {
        numbers *= (std::signbit(numbers[3]) ? -1.0 : 1.0) / length;
      } else {
        numbers << 0.0, 0.0, 0.0, 1.0;
      }
      continue;
    }
    for (int i = 0; i < factor.nq; ++i) {
      if (is_cyclic(factor, i)) {
        q[factor.q + i] = shortest_turn(0.0, q[factor.q + i]);
      }
    }
  }
}

Eigen::VectorXd random_configuration(const Mechanism& mechanism, std::mt19937& engine) {
  Eigen::VectorXd q = neutral(mechanism);
  const auto between = [&engine](double lower, double upper) {
    return std::uniform_real_distribution<double>(lower, upper)(engine);
  };
  std::size_t joint = 0;  // the base, if it floats, comes first and is none
  for (const Factor& factor : mechanism.factors()) {
    const bool is_base = mechanism.floating() && factor.v == 0;
    const JointLimits limits = is_base ? JointLimits{} : mechanism.joint_limits()[joint];
    joint += is_base ? 0 : 1;
    if (has_quaternion(factor)) {
      q.segment<4>(quaternion_at(factor)) = random_rotation(engine).coeffs();
      for (int i = 0; i < factor.nq - 4; ++i) {
        q[factor.q + i] = between(-1.0, 1.0);
      }
      continue;
    }
    const bool bounded = factor.nv == 1 && factor.kind != JointKind::kContinuous &&
                         std::isfinite(limits.lower) && std::isfinite(limits.upper);
    for (int i = 0; i < factor.nq; ++i) {
      const double reach = is_angle(factor, i) ? std::numbers::pi : 1.0;
      q[factor.q + i] = bounded ? between(limits.lower, limits.upper) : between(-reach, reach);
    }
  }
  return q;
}

}  // namespace geodesic::control
