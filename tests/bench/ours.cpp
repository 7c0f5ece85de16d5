// This project's mechanism through the door of the peers.
#include "control/mechanism/coriolis.hpp"
#include "control/mechanism/forward_dynamics.hpp"
#include "control/mechanism/gravity.hpp"
#include "control/mechanism/metric.hpp"
#include "control/mechanism/musical.hpp"
#include "control/mechanism/newton_euler.hpp"
#include "tests/bench/dynamics.hpp"

namespace geodesic::bench {
namespace {

using control::Mechanism;
using control::Workspace;
using In = Eigen::Map<const Eigen::VectorXd>;
using Out = Eigen::Map<Eigen::VectorXd>;

struct Model {
  Model(const control::TreeDescription& tree, const Eigen::Vector3d& gravity, control::Base base)
      : mechanism(tree, gravity, {base, {}}), workspace(mechanism) {}
  In position(const double* numbers) const { return {numbers, mechanism.nq()}; }
  In in(const double* numbers) const { return {numbers, mechanism.dof()}; }
  Out out(double* numbers) const { return {numbers, mechanism.dof()}; }
  Mechanism mechanism;
  Workspace workspace;
};

bool floats(const PeerRobot& robot) {
  return robot.bodies > 0 && robot.body[0].kind == PeerBody::kFree;
}

/// The flat form back into a description, so that we are given what the others are given.
control::TreeDescription description(const PeerRobot& robot) {
  control::TreeDescription tree;
  tree.name = "robot";
  tree.root_link = "world";
  if (!floats(robot)) {
    tree.links.push_back({"world", {}});
  }
  for (int i = 0; i < robot.bodies; ++i) {
    const PeerBody& body = robot.body[i];
    using RowMajor = Eigen::Matrix<double, 3, 3, Eigen::RowMajor>;
    control::LinkDescription link;
    link.name = body.kind == PeerBody::kFree ? "world" : "link" + std::to_string(i);
    link.inertia.mass_kg = body.mass;
    link.inertia.com_m = Eigen::Vector3d(body.com);
    link.inertia.inertia_kg_m2 = Eigen::Map<const RowMajor>(body.inertia);
    tree.links.push_back(link);
    if (body.kind == PeerBody::kFree) {
      continue;
    }
    control::JointDescription joint;
    joint.name = "joint" + std::to_string(1000 + i);  // siblings sort by name
    joint.kind = body.kind == PeerBody::kFixed       ? control::JointKind::kFixed
                 : body.kind == PeerBody::kPrismatic ? control::JointKind::kPrismatic
                                                     : control::JointKind::kContinuous;
    joint.parent_link =
        tree.links[static_cast<std::size_t>(body.parent + (floats(robot) ? 0 : 1))].name;
    joint.child_link = link.name;
    joint.parent_from_joint.linear() = Eigen::Map<const RowMajor>(body.rotation);
    joint.parent_from_joint.translation() = Eigen::Vector3d(body.translation);
    joint.axis = Eigen::Vector3d(body.axis);
    tree.joints.push_back(joint);
  }
  return tree;
}

void* make(const PeerRobot* robot, const char** /*why*/) {
  return new Model(description(*robot), Eigen::Vector3d(robot->gravity),
                   floats(*robot) ? control::Base::kFloating : control::Base::kFixed);
}

Model& of(void* model) {
  return *static_cast<Model*>(model);
}

void destroy(void* model) {
  delete &of(model);
}

void call_bias(void* model, const double* q, const double* v, const double* /*x*/, double* out) {
  Model& m = of(model);
  m.out(out) = control::bias(m.mechanism, m.workspace, m.position(q), m.in(v));
}

void call_gravity(void* model, const double* q, const double* /*v*/, const double* /*x*/,
                  double* out) {
  Model& m = of(model);
  m.out(out) = control::gravity(m.mechanism, m.workspace, m.position(q));
}

void call_inverse_dynamics(void* model, const double* q, const double* v, const double* a,
                           double* out) {
  Model& m = of(model);
  m.out(out) = control::inverse_dynamics(m.mechanism, m.workspace, m.position(q), m.in(v), m.in(a));
}

void call_mass_matrix(void* model, const double* q, const double* /*v*/, const double* /*x*/,
                      double* out) {
  Model& m = of(model);
  const Eigen::Index n = m.mechanism.dof();
  Eigen::Map<Eigen::MatrixXd>(out, n, n) = control::metric(m.mechanism, m.workspace, m.position(q));
}

void call_forward_dynamics(void* model, const double* q, const double* v, const double* tau,
                           double* out) {
  Model& m = of(model);
  m.out(out) =
      *control::forward_dynamics(m.mechanism, m.workspace, m.position(q), m.in(v), m.in(tau));
}

void call_coriolis_matrix(void* model, const double* q, const double* v, const double* /*x*/,
                          double* out) {
  Model& m = of(model);
  const Eigen::Index n = m.mechanism.dof();
  Eigen::Map<Eigen::MatrixXd>(out, n, n) =
      control::coriolis_matrix(m.mechanism, m.workspace, m.position(q), m.in(v));
}

void call_metric_inverse(void* model, const double* q, const double* /*v*/, const double* /*x*/,
                         double* out) {
  Model& m = of(model);
  const Eigen::Index n = m.mechanism.dof();
  Eigen::Map<Eigen::MatrixXd>(out, n, n) =
      *control::metric_inverse(m.mechanism, m.workspace, m.position(q));
}

}  // namespace

const Peer& our_peer() {
  static constexpr Peer kPeer{"Geodesic",
                              GEODESIC_VERSION,
                              0.0,
                              make,
                              destroy,
                              {call_bias, call_gravity, call_inverse_dynamics, call_mass_matrix,
                               call_forward_dynamics, call_coriolis_matrix, call_metric_inverse}};
  return kPeer;
}

}  // namespace geodesic::bench
