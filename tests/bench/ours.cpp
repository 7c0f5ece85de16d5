// This project's mechanism through the door of the peers.
#include "control/mechanism/dynamics.hpp"
#include "tests/bench/dynamics.hpp"

namespace geodesic::bench {
namespace {

using control::Mechanism;
using control::Workspace;
using In = Eigen::Map<const Eigen::VectorXd>;
using Out = Eigen::Map<Eigen::VectorXd>;

struct Model {
  explicit Model(const control::TreeDescription& tree, const Eigen::Vector3d& gravity)
      : mechanism(tree, gravity), workspace(mechanism) {}
  In in(const double* numbers) const { return {numbers, mechanism.dof()}; }
  Out out(double* numbers) const { return {numbers, mechanism.dof()}; }
  Mechanism mechanism;
  Workspace workspace;
};

/// The flat form back into a description, so that we are given what the others are given.
control::TreeDescription description(const PeerRobot& robot) {
  control::TreeDescription tree;
  tree.name = "robot";
  tree.root_link = "world";
  tree.links.push_back({"world", {}});
  for (int i = 0; i < robot.bodies; ++i) {
    const PeerBody& body = robot.body[i];
    using RowMajor = Eigen::Matrix<double, 3, 3, Eigen::RowMajor>;
    control::LinkDescription link;
    link.name = "link" + std::to_string(i);
    link.inertia.mass_kg = body.mass;
    link.inertia.com_m = Eigen::Vector3d(body.com);
    link.inertia.inertia_kg_m2 = Eigen::Map<const RowMajor>(body.inertia);
    control::JointDescription joint;
    joint.name = "joint" + std::to_string(1000 + i);  // siblings sort by name
    joint.kind = body.kind == PeerBody::kFixed       ? control::JointKind::kFixed
                 : body.kind == PeerBody::kPrismatic ? control::JointKind::kPrismatic
                                                     : control::JointKind::kContinuous;
    joint.parent_link = body.parent < 0 ? "world" : "link" + std::to_string(body.parent);
    joint.child_link = link.name;
    joint.parent_from_joint.linear() = Eigen::Map<const RowMajor>(body.rotation);
    joint.parent_from_joint.translation() = Eigen::Vector3d(body.translation);
    joint.axis = Eigen::Vector3d(body.axis);
    tree.links.push_back(link);
    tree.joints.push_back(joint);
  }
  return tree;
}

void* make(const PeerRobot* robot, const char** /*why*/) {
  return new Model(description(*robot), Eigen::Vector3d(robot->gravity));
}

Model& of(void* model) {
  return *static_cast<Model*>(model);
}

void destroy(void* model) {
  delete &of(model);
}

void call_bias(void* model, const double* q, const double* v, const double* /*x*/, double* out) {
  Model& m = of(model);
  m.out(out) = control::bias(m.mechanism, m.workspace, m.in(q), m.in(v));
}

void call_gravity(void* model, const double* q, const double* /*v*/, const double* /*x*/,
                  double* out) {
  Model& m = of(model);
  m.out(out) = control::gravity(m.mechanism, m.workspace, m.in(q));
}

void call_inverse_dynamics(void* model, const double* q, const double* v, const double* a,
                           double* out) {
  Model& m = of(model);
  m.out(out) = control::inverse_dynamics(m.mechanism, m.workspace, m.in(q), m.in(v), m.in(a));
}

void call_mass_matrix(void* model, const double* q, const double* /*v*/, const double* /*x*/,
                      double* out) {
  Model& m = of(model);
  const Eigen::Index n = m.mechanism.dof();
  Eigen::Map<Eigen::MatrixXd>(out, n, n) = control::metric(m.mechanism, m.workspace, m.in(q));
}

void call_forward_dynamics(void* model, const double* q, const double* v, const double* tau,
                           double* out) {
  Model& m = of(model);
  m.out(out) = *control::forward_dynamics(m.mechanism, m.workspace, m.in(q), m.in(v), m.in(tau));
}

}  // namespace

const Peer& our_peer() {
  static constexpr Peer kPeer{
      "Geodesic",
      GEODESIC_VERSION,
      0.0,
      make,
      destroy,
      {call_bias, call_gravity, call_inverse_dynamics, call_mass_matrix, call_forward_dynamics}};
  return kPeer;
}

}  // namespace geodesic::bench
