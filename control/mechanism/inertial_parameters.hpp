// The ten inertial parameters of a body as numbers in a vector, their pseudo-inertia matrix, and
// whether a body can have them. Link inertias with a centre of mass are judged in
// inertia_check.hpp; what the parameters do at the joints is in regressor.hpp.
#pragma once

#include <Eigen/Core>

#include "control/geometry/spatial.hpp"
#include "control/mechanism/tree.hpp"

namespace geodesic::control {

/// m, m c (3), then the rotational inertia about the frame's origin: Ixx, Ixy, Ixz, Iyy, Iyz, Izz
/// [kg, kg·m, kg·m²], off-diagonal entries as they stand in the matrix. Linear in the body:
/// parameters of bodies joined rigidly add.
using InertialParameters = Eigen::Matrix<double, 10, 1>;

/// Real-time.
InertialParameters to_parameters(const RigidInertia& body) noexcept;

/// Inverse of to_parameters(). Real-time.
RigidInertia from_parameters(const InertialParameters& parameters) noexcept;

/// A link's inertia about its own frame's origin. Real-time.
RigidInertia to_rigid_inertia(const LinkInertia& link) noexcept;

/// The link with that inertia about its frame's origin; without mass the centre of mass is the
/// origin. Inverse of to_rigid_inertia() where there is mass. Real-time.
LinkInertia to_link_inertia(const RigidInertia& body) noexcept;

/// [[S, h], [h', m]]: S second moments of mass about the frame's origin, h first moment, m mass;
/// the moments of the mass distribution in homogeneous coordinates.
/// Source: Wensing, Kim, Slotine 2018 (inertia_check.hpp). Real-time.
Eigen::Matrix4d pseudo_inertia(const RigidInertia& body) noexcept;

/// Inverse of pseudo_inertia() on symmetric matrices. Real-time.
RigidInertia from_pseudo_inertia(const Eigen::Matrix4d& pseudo) noexcept;

/// Whether some distribution of positive mass that is not confined to a plane has these parameters:
/// the pseudo-inertia is positive definite. Equivalent: m > 0 and the principal moments about the
/// centre of mass keep A + B > C.
/// @param margin  how much matter must be out of every plane: the least eigenvalue of the second
///   moments about the centre of mass over their sum, at least; 0 admits all that are positive.
///   Rods and plates, which check_inertia() admits, are the boundary, and are not admitted.
/// Real-time. Source: Wensing, Kim, Slotine 2018.
bool physically_consistent(const RigidInertia& body, double margin = 0.0) noexcept;

}  // namespace geodesic::control
