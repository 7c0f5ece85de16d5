// MuJoCo as a peer: the stages of its forward pass that a quantity needs, and none more.
#include <mujoco/mujoco.h>

#include <Eigen/Eigenvalues>
#include <Eigen/Geometry>
#include <algorithm>
#include <cstring>
#include <memory>
#include <sstream>
#include <string>
#include <vector>

#include "tests/bench/peers/peer.hpp"

namespace {

using namespace geodesic::bench;

struct Model {
  mjModel* model = nullptr;
  mjData* data = nullptr;
};

/// Numbers as MJCF wants them, all digits.
class Numbers {
 public:
  Numbers(const double* values, int count) : values_(values), count_(count) {}
  friend std::ostream& operator<<(std::ostream& out, const Numbers& numbers) {
    for (int i = 0; i < numbers.count_; ++i) {
      out << (i > 0 ? " " : "") << numbers.values_[i];
    }
    return out;
  }

 private:
  const double* values_;
  int count_;
};

void write_body(const PeerRobot& robot, int index, std::ostream& out) {
  const PeerBody& body = robot.body[index];
  mjtNum quaternion[4];
  mju_mat2Quat(quaternion, body.rotation);
  out << "<body pos='" << Numbers(body.translation, 3) << "' quat='" << Numbers(quaternion, 4)
      << "'>";
  if (body.kind != PeerBody::kFixed) {
    out << "<joint type='" << (body.kind == PeerBody::kRevolute ? "hinge" : "slide") << "' axis='"
        << Numbers(body.axis, 3) << "'/>";
  }
  if (body.mass > 0.0) {
    // Principal axes found here: MuJoCo's own search for them stops a few 1e-6 rad short.
    using RowMajor = Eigen::Matrix<double, 3, 3, Eigen::RowMajor>;
    const Eigen::SelfAdjointEigenSolver<Eigen::Matrix3d> principal(
        Eigen::Map<const RowMajor>(body.inertia));
    Eigen::Matrix3d axes = principal.eigenvectors();
    axes.col(2) = axes.col(0).cross(axes.col(1));
    const Eigen::Quaterniond turn(axes);
    const double turned[4] = {turn.w(), turn.x(), turn.y(), turn.z()};
    out << "<inertial pos='" << Numbers(body.com, 3) << "' mass='" << body.mass << "' quat='"
        << Numbers(turned, 4) << "' diaginertia='" << Numbers(principal.eigenvalues().data(), 3)
        << "'/>";
  }
  for (int child = index + 1; child < robot.bodies; ++child) {
    if (robot.body[child].parent == index) {
      write_body(robot, child, out);
    }
  }
  out << "</body>";
}

void* make(const PeerRobot* robot, const char** why) {
  std::ostringstream xml;
  xml.precision(17);
  xml << "<mujoco><compiler angle='radian' inertiafromgeom='false'/><option gravity='"
      << Numbers(robot->gravity, 3) << "'/><worldbody>";
  for (int i = 0; i < robot->bodies; ++i) {
    if (robot->body[i].parent < 0) {
      write_body(*robot, i, xml);
    }
  }
  xml << "</worldbody></mujoco>";
  const std::string text = xml.str();
  auto files = std::make_unique<mjVFS>();
  mj_defaultVFS(files.get());
  mj_makeEmptyFileVFS(files.get(), "robot.xml", static_cast<int>(text.size()));
  std::memcpy(files->filedata[0], text.data(), text.size());
  static char error[1000];
  Model made;
  made.model = mj_loadXML("robot.xml", files.get(), error, sizeof error);
  mj_deleteVFS(files.get());
  if (made.model == nullptr) {
    *why = error;
    return nullptr;
  }
  made.data = mj_makeData(made.model);
  return new Model(made);
}

Model& of(void* model) {
  return *static_cast<Model*>(model);
}

void destroy(void* model) {
  mj_deleteData(of(model).data);
  mj_deleteModel(of(model).model);
  delete &of(model);
}

/// What everything else needs: where the bodies are.
void place(Model& m, const double* q) {
  std::copy_n(q, m.model->nq, m.data->qpos);
  mj_kinematics(m.model, m.data);
  mj_comPos(m.model, m.data);
}

void move(Model& m, const double* v) {
  std::copy_n(v, m.model->nv, m.data->qvel);
  mj_comVel(m.model, m.data);
}

void bias(void* model, const double* q, const double* v, const double*, double* out) {
  Model& m = of(model);
  place(m, q);
  move(m, v);
  mj_rne(m.model, m.data, 0, out);
}

void gravity(void* model, const double* q, const double*, const double*, double* out) {
  Model& m = of(model);
  place(m, q);
  std::fill_n(m.data->qvel, m.model->nv, 0.0);
  mj_comVel(m.model, m.data);
  mj_rne(m.model, m.data, 0, out);
}

void inverse_dynamics(void* model, const double* q, const double* v, const double* a, double* out) {
  Model& m = of(model);
  place(m, q);
  move(m, v);
  std::copy_n(a, m.model->nv, m.data->qacc);
  mj_rne(m.model, m.data, 1, out);
}

void mass_matrix(void* model, const double* q, const double*, const double*, double* out) {
  Model& m = of(model);
  place(m, q);
  mj_crb(m.model, m.data);
  mj_fullM(m.model, out, m.data->qM);
}

void forward_dynamics(void* model, const double* q, const double* v, const double* tau,
                      double* out) {
  Model& m = of(model);
  place(m, q);
  mj_crb(m.model, m.data);
  mj_factorM(m.model, m.data);
  move(m, v);
  mj_rne(m.model, m.data, 0, m.data->qfrc_bias);
  for (int i = 0; i < m.model->nv; ++i) {
    m.data->qfrc_smooth[i] = tau[i] - m.data->qfrc_bias[i];
  }
  mj_solveM(m.model, m.data, out, m.data->qfrc_smooth, 1);
}

constexpr Peer kPeer{"MuJoCo", "",
                     1e-9,     make,
                     destroy,  {bias, gravity, inverse_dynamics, mass_matrix, forward_dynamics}};

}  // namespace

extern "C" const geodesic::bench::Peer* geodesic_bench_peer() {
  static Peer peer = kPeer;
  peer.version = mj_versionString();
  return &peer;
}
