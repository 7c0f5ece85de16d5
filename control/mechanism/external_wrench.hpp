// Wrenches that the surroundings exert on links, and what they are worth at the joints.
#pragma once

#include <span>

#include "control/geometry/spatial.hpp"
#include "control/mechanism/link_frame.hpp"
#include "control/mechanism/mechanism.hpp"
#include "control/mechanism/workspace.hpp"

namespace geodesic::control {

/// A wrench on a link.
struct ExternalWrench {
  int link = 0;  ///< index in mechanism.links()
  Frame frame = Frame::kLink;
  Wrench wrench;  ///< of the surroundings on the link [N, N·m]
};

/// Sum of J' f: the covector that does the wrenches' work.
/// @param q  size nq    @param wrenches  any number
/// @return   covector, size nv [N·m, N]; lives in the workspace until the next call.
/// Real-time, O(n + wrenches): each is put on its body and all travel inwards once (Featherstone
/// 2008, section 5.3).
const Eigen::VectorXd& external_torque(const Mechanism& mechanism, Workspace& workspace,
                                       const VectorIn& q,
                                       std::span<const ExternalWrench> wrenches) noexcept;

/// tau = M a + C v + g - sum of J' f: what the motors add to the wrenches for the motion a.
/// @param q  size nq    @param v  size nv    @param a  dv/dt, size nv
/// @return   covector, size nv, that of inverse_dynamics() without wrenches; lives in the workspace
///   until the next call. Real-time, O(n + wrenches).
const Eigen::VectorXd& inverse_dynamics(const Mechanism& mechanism, Workspace& workspace,
                                        const VectorIn& q, const VectorIn& v, const VectorIn& a,
                                        std::span<const ExternalWrench> wrenches) noexcept;

}  // namespace geodesic::control
