// The mechanism as a whole: centre of mass, its velocity, total momentum. Moving links only.
#pragma once

#include <Eigen/Core>

#include "control/mechanism/mechanism.hpp"
#include "control/mechanism/workspace.hpp"

namespace geodesic::control {

/// Sum of mass * centre of mass [kg·m], world axes, about the world's origin.
/// @param q  size nq    Real-time, O(n).
Eigen::Vector3d first_moment(const Mechanism& mechanism, Workspace& workspace,
                             const VectorIn& q) noexcept;

/// [m], world; the origin if nothing that moves has mass.
/// @param q  size nq    Real-time, O(n).
Eigen::Vector3d centre_of_mass(const Mechanism& mechanism, Workspace& workspace,
                               const VectorIn& q) noexcept;

/// World axes; rotors left out.
struct CentroidalMomentum {
  Eigen::Vector3d linear = Eigen::Vector3d::Zero();   ///< [kg·m/s]
  Eigen::Vector3d angular = Eigen::Vector3d::Zero();  ///< about the centre of mass [kg·m²/s]
  Eigen::Vector3d centre_of_mass = Eigen::Vector3d::Zero();  ///< [m]
  Eigen::Vector3d velocity = Eigen::Vector3d::Zero();        ///< of the centre of mass [m/s]
};

/// @param q  size nq    @param v  size nv    Real-time, O(n).
/// Source: Orin, Goswami, Lee 2013, "Centroidal dynamics of a humanoid robot", summed body by body.
CentroidalMomentum centroidal_momentum(const Mechanism& mechanism, Workspace& workspace,
                                       const VectorIn& q, const VectorIn& v) noexcept;

}  // namespace geodesic::control
