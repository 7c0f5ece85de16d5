// Implements external_wrench.hpp.
#include "control/mechanism/external_wrench.hpp"

#include <cassert>

#include "control/mechanism/joint_motion.hpp"
#include "control/mechanism/kinematics.hpp"
#include "control/mechanism/newton_euler.hpp"

namespace geodesic::control {
namespace {

/// The wrench in the coordinates of the body that carries the link.
Wrench on_body(const ExternalWrench& external, const LinkFrame& link,
               const Pose& world_from_body) noexcept {
  switch (external.frame) {
    case Frame::kLink:
      return to_parent(link.body_from_link, external.wrench);
    case Frame::kWorldOrigin:
      return to_parent(inverse(world_from_body), external.wrench);
    case Frame::kLinkOrigin:
      break;
  }
  const auto turned = world_from_body.rotation.transpose();
  const Pose about_link{turned, link.body_from_link.translation};
  return to_parent(about_link, external.wrench);
}

}  // namespace

const Eigen::VectorXd& external_torque(const Mechanism& mechanism, Workspace& workspace,
                                       const VectorIn& q,
                                       std::span<const ExternalWrench> wrenches) noexcept {
  const auto& bodies = mechanism.bodies();
  update_poses(mechanism, workspace, q);
  for (auto& state : workspace.body) {
    state.force = {};
  }
  for (const ExternalWrench& external : wrenches) {
    assert(external.link >= 0 &&
           static_cast<std::size_t>(external.link) < mechanism.links().size());
    const LinkFrame& link = mechanism.links()[static_cast<std::size_t>(external.link)];
    if (link.body != kWorld) {
      const auto body = static_cast<std::size_t>(link.body);
      workspace.body[body].force += on_body(external, link, workspace.world_from_body[body]);
    }
  }
  Eigen::VectorXd& result = workspace.external_torque;
  result.setZero();
  for (std::size_t i = bodies.size(); i-- > 0;) {
    const Body& body = bodies[i];
    const Wrench& carried = workspace.body[i].force;
    for (int k = 0; k < freedoms(body.motion); ++k) {
      result[body.dof + k] += along_axis(body, carried, k);
    }
    if (body.parent != kWorld) {
      workspace.body[static_cast<std::size_t>(body.parent)].force +=
          to_parent(workspace.body[i].parent_from_body, carried);
    }
  }
  return result;
}

const Eigen::VectorXd& inverse_dynamics(const Mechanism& mechanism, Workspace& workspace,
                                        const VectorIn& q, const VectorIn& v, const VectorIn& a,
                                        std::span<const ExternalWrench> wrenches) noexcept {
  const Eigen::VectorXd& given = external_torque(mechanism, workspace, q, wrenches);
  inverse_dynamics(mechanism, workspace, q, v, a);
  workspace.inverse_dynamics -= given;
  return workspace.inverse_dynamics;
}

}  // namespace geodesic::control
