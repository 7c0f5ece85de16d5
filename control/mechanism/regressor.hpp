// Inverse dynamics as a linear function of the bodies' inertial parameters, from which they are
// identified.
#pragma once

#include <Eigen/Core>

#include "control/mechanism/mechanism.hpp"
#include "control/mechanism/workspace.hpp"

namespace geodesic::control {

/// Numbers in the parameter vector pi: ten for each of mechanism.bodies() (inertial_parameters.hpp,
/// in the body's own frame, links fixed to it included), then one rotor inertia for each of v.
int parameter_count(const Mechanism& mechanism) noexcept;

/// The mechanism's own pi, size parameter_count(). Not real-time: allocates.
Eigen::VectorXd parameters(const Mechanism& mechanism);

/// Y(q, v, a) with tau = Y pi for any parameters of the bodies; with parameters() it is
/// inverse_dynamics(). Column 10 b + p is the torque of parameter p of body b; a rotor's column is
/// its joint's acceleration (zero where a joint has several degrees of freedom, and no rotor).
/// @param q  size nq    @param v  size nv    @param a  dv/dt, size nv
/// @param result  nv x parameter_count()    Real-time, O(n depth).
/// Source: Atkeson, An, Hollerbach 1986, "Estimation of inertial parameters of manipulator loads
/// and links"; here about the frame's origin with the body's point accelerations a + U r.
void regressor(const Mechanism& mechanism, Workspace& workspace, const VectorIn& q,
               const VectorIn& v, const VectorIn& a, Eigen::Ref<Eigen::MatrixXd> result) noexcept;

}  // namespace geodesic::control
