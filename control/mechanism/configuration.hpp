// The configuration space Q of a mechanism as the Lie group it is, a product with one factor a
// joint: its identity, steps along a velocity, differences, interpolation, distance, samples. The
// groups are in ../geometry; no masses here: geodesics of the metric are elsewhere.
#pragma once

#include <Eigen/Core>
#include <random>

#include "control/mechanism/mechanism.hpp"
#include "control/mechanism/workspace.hpp"

namespace geodesic::control {

/// The identity of every factor of Q: joints at 0, a floating base at the world's origin. Size nq.
/// Not real-time: allocates.
Eigen::VectorXd neutral(const Mechanism& mechanism);

/// q exp(dt v): the configuration reached from q [nq] by following v [nv], constant in the moving
/// frame, for dt seconds. Exact on SO(3) and SE(3), a sum elsewhere; quaternions come out with unit
/// length, angles are not wrapped. `result` [nq] may be q itself. Real-time, O(n).
/// Source: Murray, Li, Sastry 1994, proposition 2.9.
void integrate(const Mechanism& mechanism, const VectorIn& q, const VectorIn& v, double dt,
               Eigen::Ref<Eigen::VectorXd> result) noexcept;

/// The shortest velocity [nv] that leads from q0 to q1 [nq] in one second: log(q0^-1 q1), so that
/// integrate(q0, v, 1) is q1, a turned-round quaternion and whole turns of a continuous joint
/// aside. A revolute joint, which has limits, goes through all angles between the two; continuous
/// joints, planar and spherical ones turn by at most pi. Real-time, O(n).
void difference(const Mechanism& mechanism, const VectorIn& q0, const VectorIn& q1,
                Eigen::Ref<Eigen::VectorXd> v) noexcept;

/// The point that divides the way from q0 (share 0) to q1 (share 1) [nq] along q0 exp(share
/// difference(q0, q1)), a one-parameter subgroup: in each joint at constant velocity, the shortest
/// way on S1, R and SO(3) and a screw motion on SE(3). `result` [nq] may be either. (It is no
/// geodesic of the kinetic energy.) Real-time, O(n).
void interpolate(const Mechanism& mechanism, const VectorIn& q0, const VectorIn& q1, double share,
                 Eigen::Ref<Eigen::VectorXd> result) noexcept;

/// Distance of q0 and q1 [nq] in metres: that of the product of the factors' left-invariant
/// metrics, in which a radian counts as an arc of radius `metres_per_radian`. Real-time, O(n).
double distance(const Mechanism& mechanism, const VectorIn& q0, const VectorIn& q1,
                double metres_per_radian = 1.0) noexcept;

/// The same point of Q [nq] in its simplest numbers: quaternions of unit length with w >= 0 (one of
/// length zero becomes the identity), the angles of continuous and planar joints in [-pi, pi].
/// Real-time, O(n).
void normalise(const Mechanism& mechanism, Eigen::Ref<Eigen::VectorXd> q) noexcept;

/// A point of Q [nq], uniform: rotations by Haar's measure, angles over the circle, joints with two
/// finite limits between those, other positions within +-1 m. Not real-time: allocates.
Eigen::VectorXd random_configuration(const Mechanism& mechanism, std::mt19937& engine);

}  // namespace geodesic::control
