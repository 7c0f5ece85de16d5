// MuJoCo's opinion on every robot, with a fixed and with a floating base: mj_inverse, mj_fullM,
// Jacobians, energies, momentum.
#include <gtest/gtest.h>
#include <mujoco/mujoco.h>

#include <Eigen/Eigenvalues>
#include <Eigen/Geometry>
#include <algorithm>
#include <cstring>
#include <memory>

#include "control/mechanism/dynamics.hpp"
#include "tests/cross/subjects.hpp"

namespace geodesic::cross {
namespace {

using control::JointDescription;
using control::JointKind;
using Eigen::MatrixXd;
using Eigen::VectorXd;

/// One of MuJoCo's joints, which move a body one after the other.
struct Part {
  std::string name;
  const char* type;
  Eigen::Vector3d axis;
};

/// A planar joint is two slides and a hinge; a floating one that is no base is three slides and a
/// ball, since MuJoCo's own is for bodies of the world alone.
std::vector<Part> parts(const JointDescription& joint) {
  const std::string& name = joint.name;
  const Eigen::Matrix3d axes = joint.kind == JointKind::kPlanar
                                   ? control::in_plane(joint.axis)
                                   : Eigen::Matrix3d(Eigen::Matrix3d::Identity());
  const Part x{name + " x", "slide", axes.col(0)};
  const Part y{name + " y", "slide", axes.col(1)};
  switch (joint.kind) {
    case JointKind::kFixed:
      return {};
    case JointKind::kPrismatic:
      return {{name, "slide", joint.axis}};
    case JointKind::kPlanar:
      return {x, y, {name, "hinge", axes.col(2)}};
    case JointKind::kSpherical:
      return {{name, "ball", axes.col(2)}};
    case JointKind::kFloating:
      return {x, y, {name + " z", "slide", axes.col(2)}, {name, "ball", axes.col(2)}};
    case JointKind::kRevolute:
    case JointKind::kContinuous:
      break;
  }
  return {{name, "hinge", joint.axis}};
}

/// Bodies and joints of `link` and below; "world" is MuJoCo's own name for one. Every figure is
/// set afterwards, in double and not as text.
void write(const control::TreeDescription& tree, const std::string& link, std::string& xml) {
  for (const JointDescription& joint : tree.joints) {
    if (joint.parent_link != link) {
      continue;
    }
    xml.append("<body name='its ").append(joint.child_link).append("' pos='1 1 1'>");
    xml.append("<inertial pos='1 2 3' quat='1 2 3 4' mass='1' diaginertia='1 1 1'/>");
    for (const Part& part : parts(joint)) {
      xml.append("<joint name='").append(part.name).append("' type='");
      xml.append(part.type).append("'/>");
    }
    write(tree, joint.child_link, xml);
    xml.append("</body>");
  }
}

struct Engine {
  struct Free {
    void operator()(mjModel* m) const { mj_deleteModel(m); }
    void operator()(mjData* d) const { mj_deleteData(d); }
  };
  std::unique_ptr<mjModel, Free> model;
  std::unique_ptr<mjData, Free> data;

  int id(int kind, const std::string& name) const {
    const int found = mj_name2id(model.get(), kind, name.c_str());
    EXPECT_GE(found, 0) << name;
    return found;
  }
  int body(const std::string& link) const { return id(mjOBJ_BODY, "its " + link); }
};

void set_quaternion(const Eigen::Matrix3d& rotation, mjtNum* to) {
  const Eigen::Quaterniond q = Eigen::Quaterniond(rotation).normalized();
  to[0] = q.w();
  to[1] = q.x();
  to[2] = q.y();
  to[3] = q.z();
}

/// The inertia as described, whatever it is: MuJoCo's own reader refuses bodies without mass and
/// those whose principal moments no body can have.
void set_inertia(const control::LinkInertia& link, int body, mjModel& model) {
  const Eigen::SelfAdjointEigenSolver<Eigen::Matrix3d> principal(link.inertia_kg_m2);
  Eigen::Matrix3d axes = principal.eigenvectors();
  axes.col(2) = axes.col(0).cross(axes.col(1));
  model.body_mass[body] = link.mass_kg;
  Eigen::Map<Eigen::Vector3d>(model.body_ipos + 3 * body) = link.com_m;
  Eigen::Map<Eigen::Vector3d>(model.body_inertia + 3 * body) = principal.eigenvalues();
  set_quaternion(axes, model.body_iquat + 4 * body);
  model.body_sameframe[body] = 0;
  model.body_simple[body] = 0;
}

Engine engine_of(const Subject& subject, const Eigen::Vector3d& gravity) {
  const control::TreeDescription& tree = subject.tree;
  const bool floating = subject.base == control::Base::kFloating;
  mju_user_warning = [](const char*) {};  // small pivots, which nothing here divides by
  std::string xml = "<mujoco><compiler inertiafromgeom='false'/><worldbody>";
  if (floating) {
    xml.append("<body name='its ").append(tree.root_link).append("'><freejoint/>");
    xml.append("<inertial pos='1 2 3' quat='1 2 3 4' mass='1' diaginertia='1 1 1'/>");
  }
  write(tree, tree.root_link, xml);
  xml.append(floating ? "</body>" : "").append("</worldbody></mujoco>");
  auto files = std::make_unique<mjVFS>();
  mj_defaultVFS(files.get());
  mj_makeEmptyFileVFS(files.get(), "robot.xml", static_cast<int>(xml.size()));
  std::memcpy(files->filedata[0], xml.data(), xml.size());
  char error[1000] = "";
  Engine engine;
  engine.model.reset(mj_loadXML("robot.xml", files.get(), error, sizeof error));
  mj_deleteVFS(files.get());
  if (engine.model == nullptr) {
    ADD_FAILURE() << error;
    return engine;
  }
  mjModel& model = *engine.model;
  Eigen::Map<Eigen::Vector3d>(model.opt.gravity) = gravity;
  model.opt.enableflags |= mjENBL_ENERGY;
  for (const control::LinkDescription& link : tree.links) {
    if (floating || link.name != tree.root_link) {
      set_inertia(link.inertia, engine.body(link.name), model);
    }
  }
  for (const JointDescription& joint : tree.joints) {
    const int body = engine.body(joint.child_link);
    Eigen::Map<Eigen::Vector3d>(model.body_pos + 3 * body) = joint.parent_from_joint.translation();
    set_quaternion(joint.parent_from_joint.linear(), model.body_quat + 4 * body);
    for (const Part& part : parts(joint)) {
      const int number = engine.id(mjOBJ_JOINT, part.name);
      Eigen::Map<Eigen::Vector3d>(model.jnt_axis + 3 * number) = part.axis;
    }
  }
  std::fill_n(model.dof_simplenum, model.nv, 0);
  std::copy_n(model.body_mass, model.nbody, model.body_subtreemass);
  for (int body = model.nbody - 1; body > 0; --body) {
    model.body_subtreemass[model.body_parentid[body]] += model.body_subtreemass[body];
  }
  engine.data.reset(mj_makeData(&model));
  return engine;
}

/// A mechanism, MuJoCo's model of it, and how the coordinates of the two belong together.
struct Pair {
  Subject subject;
  control::Mechanism mechanism;
  control::Workspace workspace;
  Engine engine;
  MatrixXd velocity;  ///< MuJoCo's qvel from our v; set by move()
  VectorXd drift;     ///< its rate of change, times v

  explicit Pair(const Subject& given)
      : subject(given),
        mechanism(subject.tree, {1.2, -2.3, -9.0}, {subject.base, {}}),
        workspace(mechanism),
        engine(engine_of(subject, mechanism.gravity())) {}

  const control::Factor& factor(const std::string& name) const {
    return *std::find_if(mechanism.factors().begin(), mechanism.factors().end(),
                         [&](const control::Factor& each) { return each.name == name; });
  }

  /// Our quaternion at q[at] is x y z w, MuJoCo's w x y z.
  static Eigen::Matrix3d turn(const VectorXd& q, int at, mjtNum* to) {
    const Eigen::Quaterniond quaternion(q[at + 3], q[at], q[at + 1], q[at + 2]);
    set_quaternion(quaternion.normalized().toRotationMatrix(), to);
    return quaternion.normalized().toRotationMatrix();
  }

  /// A free motion: MuJoCo takes the origin's velocity along the axes it moves in and the angular
  /// velocity along the body's own; ours are both along the body's own.
  void set_free(const control::Factor& own, int address, int dof, const VectorXd& q,
                const VectorXd& v) {
    const Eigen::Matrix3d rotation = turn(q, own.q + 3, engine.data->qpos + address + 3);
    Eigen::Map<Eigen::Vector3d>(engine.data->qpos + address) = q.segment<3>(own.q);
    velocity.block<3, 3>(dof, own.v) = rotation;
    velocity.block<3, 3>(dof + 3, own.v + 3).setIdentity();
    drift.segment<3>(dof) = rotation * v.segment<3>(own.v + 3).cross(v.segment<3>(own.v));
  }

  void set(const JointDescription& joint, const VectorXd& q, const VectorXd& v) {
    const control::Factor& own = factor(joint.mimic ? joint.mimic->joint : joint.name);
    const int number = engine.id(mjOBJ_JOINT, parts(joint).front().name);
    const int address = engine.model->jnt_qposadr[number];
    const int dof = engine.model->jnt_dofadr[number];
    if (joint.kind == JointKind::kFloating) {
      set_free(own, address, dof, q, v);
    } else if (joint.kind == JointKind::kSpherical) {
      turn(q, own.q, engine.data->qpos + address);
      velocity.block<3, 3>(dof, own.v).setIdentity();
    } else {
      const double ratio = joint.mimic ? joint.mimic->multiplier : 1.0;
      for (int k = 0; k < own.nv; ++k) {
        engine.data->qpos[address + k] =
            ratio * q[own.q + k] + (joint.mimic ? joint.mimic->offset : 0.0);
        velocity(dof + k, own.v + k) = ratio;
      }
    }
  }

  /// MuJoCo at our state.
  void move(const VectorXd& q, const VectorXd& v, const VectorXd& a) {
    const int nv = engine.model->nv;
    velocity = MatrixXd::Zero(nv, mechanism.dof());
    drift = VectorXd::Zero(nv);
    if (mechanism.floating()) {
      set_free(factor(control::kBaseName), 0, 0, q, v);
    }
    for (const JointDescription& joint : subject.tree.joints) {
      if (joint.kind != JointKind::kFixed) {
        set(joint, q, v);
      }
    }
    Eigen::Map<VectorXd>(engine.data->qvel, nv) = velocity * v;
    Eigen::Map<VectorXd>(engine.data->qacc, nv) = velocity * a + drift;
    mj_inverse(engine.model.get(), engine.data.get());
  }

  VectorXd torque() const {
    return velocity.transpose() *
           Eigen::Map<const VectorXd>(engine.data->qfrc_inverse, engine.model->nv);
  }
};

class Mujoco : public testing::TestWithParam<Subject> {};

TEST_P(Mujoco, AgreesOnTheDynamics) {
  Pair pair(GetParam());
  ASSERT_NE(pair.engine.data, nullptr);
  const control::Mechanism& mechanism = pair.mechanism;
  control::Workspace& workspace = pair.workspace;
  const mjModel* model = pair.engine.model.get();
  mjData* data = pair.engine.data.get();
  const int n = mechanism.dof();
  const VectorXd zero = VectorXd::Zero(n);
  control::testing::RandomArm random(3);
  for (int state = 0; state < 10; ++state) {
    SCOPED_TRACE("state " + std::to_string(state));
    const VectorXd q = random.configuration(mechanism);
    const VectorXd v = random.vector(n, 2.0);
    const VectorXd a = random.vector(n, 2.0);
    pair.move(q, zero, zero);
    expect_same(control::gravity(mechanism, workspace, q), pair.torque(), kRounding, "gravity");
    pair.move(q, v, zero);
    expect_same(control::bias(mechanism, workspace, q, v), pair.torque(), kRounding, "bias");
    pair.move(q, v, a);
    expect_same(control::inverse_dynamics(mechanism, workspace, q, v, a), pair.torque(), kRounding,
                "inverse dynamics");
    using RowMajor = Eigen::Matrix<double, Eigen::Dynamic, Eigen::Dynamic, Eigen::RowMajor>;
    RowMajor mass(model->nv, model->nv);
    mj_fullM(model, mass.data(), data->qM);
    expect_same(control::metric(mechanism, workspace, q),
                pair.velocity.transpose() * mass * pair.velocity, kRounding, "M");
    EXPECT_NEAR(control::kinetic_energy(mechanism, workspace, q, v), data->energy[1],
                kRounding * (1.0 + data->energy[1]));
    for (int link = 1; link < static_cast<int>(mechanism.links().size()); link += 4) {
      const int body = pair.engine.body(mechanism.links()[std::size_t(link)].name);
      RowMajor jacobian(6, model->nv);
      mj_jacBody(model, data, jacobian.data(), jacobian.data() + 3 * model->nv, body);
      expect_same(control::jacobian(mechanism, workspace, q, link), jacobian * pair.velocity,
                  kRounding, "Jacobian of a link");
      expect_same(control::link_pose(mechanism, q, link).translation,
                  Eigen::Map<const Eigen::Vector3d>(data->xpos + 3 * body), kRounding, "origin");
    }
  }
}

TEST_P(Mujoco, AgreesOnMomentum) {
  Subject subject = GetParam();
  subject.base = control::Base::kFloating;  // all of it moves, so that the subtree is the whole
  Pair pair(subject);
  ASSERT_NE(pair.engine.data, nullptr);
  const int n = pair.mechanism.dof();
  control::testing::RandomArm random(4);
  for (int state = 0; state < 5; ++state) {
    const VectorXd q = random.configuration(pair.mechanism);
    const VectorXd v = random.vector(n, 2.0);
    pair.move(q, v, VectorXd::Zero(n));
    mj_subtreeVel(pair.engine.model.get(), pair.engine.data.get());
    const auto ours = control::centroidal_momentum(pair.mechanism, pair.workspace, q, v);
    const mjData& data = *pair.engine.data;
    const auto theirs = [](const mjtNum* all) {
      return Eigen::Map<const Eigen::Vector3d>(all + 3);
    };
    expect_same(ours.centre_of_mass, theirs(data.subtree_com), kRounding, "centre of mass");
    expect_same(ours.velocity, theirs(data.subtree_linvel), kRounding, "its velocity");
    expect_same(ours.angular, theirs(data.subtree_angmom), kRounding, "angular momentum");
    const double potential = control::potential_energy(pair.mechanism, pair.workspace, q);
    EXPECT_NEAR(potential, data.energy[0], kRounding * (1.0 + std::abs(potential)));
  }
}

INSTANTIATE_TEST_SUITE_P(Robots, Mujoco, testing::ValuesIn(subjects()), [](const auto& each) {
  return each.param.name + (each.param.base == control::Base::kFloating ? "Floating" : "");
});

}  // namespace
}  // namespace geodesic::cross
