// The simulated arm's mechanics by MuJoCo; see the header.
#include "tools/sim/physics.hpp"

#include <fmt/format.h>
#include <mujoco/mujoco.h>

#include <Eigen/Cholesky>
#include <algorithm>
#include <array>
#include <cmath>
#include <cstring>
#include <stdexcept>

#include "tools/sim/mjcf.hpp"

namespace geodesic::tools {
namespace {

struct FreeModel {
  void operator()(mjModel* model) const noexcept { mj_deleteModel(model); }
};
struct FreeData {
  void operator()(mjData* data) const noexcept { mj_deleteData(data); }
};
using ModelPtr = std::unique_ptr<mjModel, FreeModel>;
using DataPtr = std::unique_ptr<mjData, FreeData>;

struct FreeFiles {
  void operator()(mjVFS* files) const noexcept {
    mj_deleteVFS(files);
    delete files;
  }
};

// MuJoCo compiles files only; this one lives in memory.
ModelPtr compile(const std::string& xml) {
  constexpr const char* kName = "robot.xml";
  const std::unique_ptr<mjVFS, FreeFiles> files(new mjVFS);
  mj_defaultVFS(files.get());
  if (mj_makeEmptyFileVFS(files.get(), kName, static_cast<int>(xml.size()) + 1) != 0) {
    throw std::runtime_error("MuJoCo has no room for the model's text");
  }
  std::memcpy(files->filedata[mj_findFileVFS(files.get(), kName)], xml.c_str(), xml.size() + 1);
  std::array<char, 1000> error{};
  ModelPtr model(mj_loadXML(kName, files.get(), error.data(), static_cast<int>(error.size())));
  if (!model) throw std::runtime_error(fmt::format("MuJoCo refuses the model: {}", error.data()));
  return model;
}

// A joint's place in MuJoCo's vectors, and who follows it.
struct Dof {
  int position = 0;  // index into qpos
  int velocity = 0;  // index into qvel
};
struct Follower {
  Dof dof;
  std::size_t leader = 0;  // in order of v
  double multiplier = 1.0;
  double offset = 0.0;
};

}  // namespace

struct Physics::Impl {
  ModelPtr model;
  DataPtr data;
  std::vector<Dof> dof;
  std::vector<Follower> follower;
  std::vector<std::string> link_name;
  std::vector<int> link_body;
  std::vector<std::string> warnings;
  std::vector<double> torque;

  void find_joints(const control::TreeDescription& tree, const std::vector<std::string>& order) {
    dof.resize(order.size());
    std::vector<bool> found(order.size(), false);
    for (std::size_t i = 0; i < tree.joints.size(); ++i) {
      const control::JointDescription& joint = tree.joints[i];
      if (joint.kind == control::JointKind::kFixed) continue;
      const int id = mj_name2id(model.get(), mjOBJ_JOINT, fmt::format("j{}", i).c_str());
      const Dof place{model->jnt_qposadr[id], model->jnt_dofadr[id]};
      if (joint.mimic) {
        follow(tree, joint, place, order);
        continue;
      }
      const auto known = std::find(order.begin(), order.end(), joint.name);
      if (known == order.end()) {
        throw std::invalid_argument("joint '" + joint.name + "' moves but has no drive");
      }
      const auto index = static_cast<std::size_t>(known - order.begin());
      dof[index] = place;
      found[index] = true;
    }
    for (std::size_t i = 0; i < order.size(); ++i) {
      if (!found[i]) throw std::invalid_argument("joint '" + order[i] + "' is not in the tree");
    }
  }

  // write_mjcf() has refused mimics that lead nowhere.
  void follow(const control::TreeDescription& tree, const control::JointDescription& joint,
              Dof place, const std::vector<std::string>& order) {
    Follower result{place, 0, 1.0, 0.0};
    const control::JointDescription* leader = &joint;
    while (leader->mimic) {
      result.offset += result.multiplier * leader->mimic->offset;
      result.multiplier *= leader->mimic->multiplier;
      leader = &*std::find_if(tree.joints.begin(), tree.joints.end(), [&](const auto& other) {
        return other.name == leader->mimic->joint;
      });
    }
    const auto known = std::find(order.begin(), order.end(), leader->name);
    if (known == order.end()) {
      throw std::invalid_argument("joint '" + joint.name + "' mimics '" + leader->name +
                                  "', which has no drive");
    }
    result.leader = static_cast<std::size_t>(known - order.begin());
    follower.push_back(result);
  }

  // All velocities of MuJoCo from those of the independent joints.
  Eigen::MatrixXd spread() const {
    const auto count = static_cast<Eigen::Index>(dof.size());
    Eigen::MatrixXd result = Eigen::MatrixXd::Zero(model->nv, count);
    for (Eigen::Index i = 0; i < count; ++i) {
      result(dof[static_cast<std::size_t>(i)].velocity, i) = 1.0;
    }
    for (const Follower& one : follower) {
      result(one.dof.velocity, static_cast<Eigen::Index>(one.leader)) = one.multiplier;
    }
    return result;
  }

  Eigen::VectorXd smooth_forces() const {
    const Eigen::Index all = model->nv;
    return Eigen::Map<const Eigen::VectorXd>(data->qfrc_applied, all) +
           Eigen::Map<const Eigen::VectorXd>(data->qfrc_passive, all) -
           Eigen::Map<const Eigen::VectorXd>(data->qfrc_bias, all);
  }

  // Geometry that is in the floor where the arm starts (its foot, as a rule) cannot touch it.
  void lift_feet(const control::TreeDescription& tree) {
    mj_forward(model.get(), data.get());
    for (int i = 0; i < data->ncon; ++i) {
      const mjContact& contact = data->contact[i];
      const int floor = mj_name2id(model.get(), mjOBJ_GEOM, "floor");
      const int geom = contact.geom1 == floor ? contact.geom2 : contact.geom1;
      if (model->geom_contype[geom] == 0) continue;
      model->geom_contype[geom] = 0;
      for (std::size_t link = 0; link < link_body.size(); ++link) {
        if (link_body[link] != model->geom_bodyid[geom]) continue;
        warnings.push_back(
            fmt::format("link '{}' reaches {:.1f} mm into the floor at the start pose: it will not "
                        "touch the floor",
                        tree.links[link].name, -1e3 * contact.dist));
      }
    }
  }
};

Physics::Physics(const config::Robot& robot, double timestep_s) : impl_(std::make_unique<Impl>()) {
  std::vector<std::string> order;
  order.reserve(robot.arm.joints.size());
  for (const auto& joint : robot.arm.joints) order.push_back(joint.name);
  Mjcf text = write_mjcf({robot.tree, order, robot.simulation, robot.gravity, timestep_s});
  impl_->warnings = std::move(text.warnings);
  impl_->model = compile(text.xml);
  impl_->data.reset(mj_makeData(impl_->model.get()));
  if (!impl_->data) throw std::runtime_error("MuJoCo has no memory for its state");
  impl_->find_joints(robot.tree, order);
  for (std::size_t i = 0; i < robot.tree.links.size(); ++i) {
    impl_->link_name.push_back(robot.tree.links[i].name);
    impl_->link_body.push_back(
        mj_name2id(impl_->model.get(), mjOBJ_BODY, fmt::format("b{}", i).c_str()));
  }
  impl_->torque.assign(order.size(), 0.0);
  const std::vector<double> rest(order.size(), 0.0);
  if (!robot.simulation.pose.empty() && robot.simulation.pose.size() != order.size()) {
    throw std::invalid_argument(fmt::format("the start pose has {} values, the robot {} joints",
                                            robot.simulation.pose.size(), order.size()));
  }
  set_state(robot.simulation.pose.empty() ? rest : robot.simulation.pose, rest);
  impl_->lift_feet(robot.tree);
  mj_forward(impl_->model.get(), impl_->data.get());
}

Physics::~Physics() = default;

std::size_t Physics::joints() const noexcept {
  return impl_->dof.size();
}
double Physics::timestep_s() const noexcept {
  return impl_->model->opt.timestep;
}
const std::vector<std::string>& Physics::warnings() const noexcept {
  return impl_->warnings;
}

void Physics::set_state(std::span<const double> position, std::span<const double> velocity) {
  if (position.size() != joints() || velocity.size() != joints()) {
    throw std::invalid_argument(
        fmt::format("a state of {} joints needs as many positions ({}) and "
                    "velocities ({})",
                    joints(), position.size(), velocity.size()));
  }
  for (std::size_t i = 0; i < joints(); ++i) {
    impl_->data->qpos[impl_->dof[i].position] = position[i];
    impl_->data->qvel[impl_->dof[i].velocity] = velocity[i];
  }
  for (const Follower& follower : impl_->follower) {
    impl_->data->qpos[follower.dof.position] =
        follower.multiplier * position[follower.leader] + follower.offset;
    impl_->data->qvel[follower.dof.velocity] = follower.multiplier * velocity[follower.leader];
  }
  mj_forward(impl_->model.get(), impl_->data.get());
}

double Physics::position(std::size_t joint) const noexcept {
  return impl_->data->qpos[impl_->dof[joint].position];
}
double Physics::velocity(std::size_t joint) const noexcept {
  return impl_->data->qvel[impl_->dof[joint].velocity];
}

void Physics::set_torque(std::size_t joint, double torque) noexcept {
  double& applied = impl_->data->qfrc_applied[impl_->dof[joint].velocity];
  applied += torque - impl_->torque[joint];
  impl_->torque[joint] = torque;
}

void Physics::clear_forces() noexcept {
  mju_zero(impl_->data->qfrc_applied, impl_->model->nv);
  for (std::size_t i = 0; i < joints(); ++i) {
    impl_->data->qfrc_applied[impl_->dof[i].velocity] = impl_->torque[i];
  }
}

void Physics::add_force(int link, const Eigen::Vector3d& force) noexcept {
  const int body = impl_->link_body[static_cast<std::size_t>(link)];
  const std::array<mjtNum, 3> none{};
  mj_applyFT(impl_->model.get(), impl_->data.get(), force.data(), none.data(),
             impl_->data->xpos + 3 * static_cast<std::ptrdiff_t>(body), body,
             impl_->data->qfrc_applied);
}

int Physics::find_link(const std::string& name) const noexcept {
  const auto found = std::find(impl_->link_name.begin(), impl_->link_name.end(), name);
  return found == impl_->link_name.end() ? -1 : static_cast<int>(found - impl_->link_name.begin());
}

void Physics::step() noexcept {
  mj_step(impl_->model.get(), impl_->data.get());
}

std::vector<double> Physics::accelerations() {
  mj_forward(impl_->model.get(), impl_->data.get());
  std::vector<double> result(joints());
  for (std::size_t i = 0; i < joints(); ++i) {
    result[i] = impl_->data->qacc[impl_->dof[i].velocity];
  }
  return result;
}

std::vector<double> Physics::free_accelerations() {
  mj_forward(impl_->model.get(), impl_->data.get());
  const Eigen::MatrixXd spread = impl_->spread();
  const Eigen::Index all = impl_->model->nv;
  Eigen::Matrix<double, Eigen::Dynamic, Eigen::Dynamic, Eigen::RowMajor> mass(all, all);
  mj_fullM(impl_->model.get(), mass.data(), impl_->data->qM);
  const Eigen::MatrixXd folded = spread.transpose() * mass * spread;
  const Eigen::VectorXd result = folded.ldlt().solve(spread.transpose() * impl_->smooth_forces());
  return {result.begin(), result.end()};
}

std::vector<double> Physics::unbalanced_torques() {
  mj_forward(impl_->model.get(), impl_->data.get());
  const Eigen::VectorXd result = impl_->spread().transpose() * impl_->smooth_forces();
  return {result.begin(), result.end()};
}

PhysicsEnergy Physics::energy() {
  mj_energyPos(impl_->model.get(), impl_->data.get());
  mj_energyVel(impl_->model.get(), impl_->data.get());
  return {impl_->data->energy[1], impl_->data->energy[0]};
}

double Physics::floor_force() const {
  double sum = 0.0;
  for (int i = 0; i < impl_->data->ncon; ++i) {
    std::array<mjtNum, 6> force{};
    mj_contactForce(impl_->model.get(), impl_->data.get(), i, force.data());
    sum += force[0];
  }
  return sum;
}

std::vector<double> Physics::contact_torques() const {
  const mjData& data = *impl_->data;
  std::vector<mjtNum> forces(data.efc_force, data.efc_force + data.nefc);
  for (int i = 0; i < data.nefc; ++i) {
    if (data.efc_type[i] < mjCNSTR_CONTACT_FRICTIONLESS) forces[static_cast<std::size_t>(i)] = 0.0;
  }
  Eigen::VectorXd all = Eigen::VectorXd::Zero(impl_->model->nv);
  if (data.nefc > 0) {
    mj_mulJacTVec(impl_->model.get(), impl_->data.get(), all.data(), forces.data());
  }
  const Eigen::VectorXd result = impl_->spread().transpose() * all;
  return {result.begin(), result.end()};
}

bool Physics::finite() const noexcept {
  for (std::size_t i = 0; i < joints(); ++i) {
    if (!std::isfinite(position(i)) || !std::isfinite(velocity(i))) return false;
  }
  return true;
}

}  // namespace geodesic::tools
