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
  bool floating = false;
  mjtNum base[9]{};  ///< world_from_base at the last place(), row-major
  std::vector<mjtNum> unit;
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

/// Principal moments of the bodies in the order in which MuJoCo numbers them, as they are given:
/// its reader refuses what no rigid body can have, which published files contain.
using Moments = std::vector<Eigen::Vector3d>;

void write_body(const PeerRobot& robot, int index, std::ostream& out, Moments& moments) {
  moments.emplace_back(0.0, 0.0, 0.0);
  const PeerBody& body = robot.body[index];
  mjtNum quaternion[4];
  mju_mat2Quat(quaternion, body.rotation);
  out << "<body pos='" << Numbers(body.translation, 3) << "' quat='" << Numbers(quaternion, 4)
      << "'>";
  if (body.kind == PeerBody::kFree) {
    out << "<freejoint/>";
  } else if (body.kind != PeerBody::kFixed) {
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
    moments.back() = principal.eigenvalues();
    const Eigen::Vector3d accepted = Eigen::Vector3d::Constant(moments.back().maxCoeff());
    const Eigen::Quaterniond turn(axes);
    const double turned[4] = {turn.w(), turn.x(), turn.y(), turn.z()};
    out << "<inertial pos='" << Numbers(body.com, 3) << "' mass='" << body.mass << "' quat='"
        << Numbers(turned, 4) << "' diaginertia='" << Numbers(accepted.data(), 3) << "'/>";
  }
  for (int child = index + 1; child < robot.bodies; ++child) {
    if (robot.body[child].parent == index) {
      write_body(robot, child, out, moments);
    }
  }
  out << "</body>";
}

void* make(const PeerRobot* robot, const char** why) {
  std::ostringstream xml;
  xml.precision(17);
  xml << "<mujoco><compiler angle='radian' inertiafromgeom='false'/><option gravity='"
      << Numbers(robot->gravity, 3) << "'/><worldbody>";
  Moments moments;
  for (int i = 0; i < robot->bodies; ++i) {
    if (robot->body[i].parent < 0) {
      write_body(*robot, i, xml, moments);
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
  for (std::size_t i = 0; i < moments.size(); ++i) {
    std::copy_n(moments[i].data(), 3, made.model->body_inertia + 3 * (i + 1));  // 0 is the world
  }
  made.data = mj_makeData(made.model);
  made.unit.resize(static_cast<std::size_t>(made.model->nv * made.model->nv));
  made.floating = robot->bodies > 0 && robot->body[0].kind == PeerBody::kFree;
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

// MuJoCo's base has its linear velocity along the world's axes; everybody else's here along its
// own. What turns between them is little beside the rest.

/// From the world's axes to the base's, or back.
void turn(const Model& m, double* vector, bool to_world) {
  mjtNum turned[3];
  if (to_world) {
    mju_rotVecMat(turned, vector, m.base);
  } else {
    mju_rotVecMatT(turned, vector, m.base);
  }
  std::copy_n(turned, 3, vector);
}

/// Rows and columns of the base's linear velocity, of a matrix that maps or takes velocities.
void turn_matrix(const Model& m, double* matrix) {
  const int n = m.model->nv;
  for (int i = 0; m.floating && i < n; ++i) {
    turn(m, matrix + i * n, false);
  }
  for (int j = 0; m.floating && j < n; ++j) {
    mjtNum column[3] = {matrix[j], matrix[n + j], matrix[2 * n + j]};
    turn(m, column, false);
    matrix[j] = column[0];
    matrix[n + j] = column[1];
    matrix[2 * n + j] = column[2];
  }
}

/// What everything else needs: where the bodies are.
void place(Model& m, const double* q) {
  std::copy_n(q, m.model->nq, m.data->qpos);
  if (m.floating) {
    m.data->qpos[3] = q[6];
    std::copy_n(q + 3, 3, m.data->qpos + 4);
    mju_quat2Mat(m.base, m.data->qpos + 3);
  }
  mj_kinematics(m.model, m.data);
  mj_comPos(m.model, m.data);
}

void move(Model& m, const double* v) {
  std::copy_n(v, m.model->nv, m.data->qvel);
  if (m.floating) {
    turn(m, m.data->qvel, true);
  }
  mj_comVel(m.model, m.data);
}

/// The rate of qvel for that of v, dv: the base's axes turn.
void accelerate(Model& m, const double* v, const double* dv) {
  const int n = m.model->nv;
  if (dv != nullptr) {
    std::copy_n(dv, n, m.data->qacc);
  } else {
    std::fill_n(m.data->qacc, n, 0.0);
  }
  if (m.floating) {
    mjtNum turning[3];
    mju_cross(turning, v + 3, v);
    mju_addTo3(m.data->qacc, turning);
    turn(m, m.data->qacc, true);
  }
}

void bias(void* model, const double* q, const double* v, const double*, double* out) {
  Model& m = of(model);
  place(m, q);
  move(m, v);
  if (m.floating) {
    accelerate(m, v, nullptr);
    mj_rne(m.model, m.data, 1, out);
    turn(m, out, false);
  } else {
    mj_rne(m.model, m.data, 0, out);
  }
}

void gravity(void* model, const double* q, const double*, const double*, double* out) {
  Model& m = of(model);
  place(m, q);
  std::fill_n(m.data->qvel, m.model->nv, 0.0);
  mj_comVel(m.model, m.data);
  mj_rne(m.model, m.data, 0, out);
  if (m.floating) {
    turn(m, out, false);
  }
}

void inverse_dynamics(void* model, const double* q, const double* v, const double* a, double* out) {
  Model& m = of(model);
  place(m, q);
  move(m, v);
  accelerate(m, v, a);
  mj_rne(m.model, m.data, 1, out);
  if (m.floating) {
    turn(m, out, false);
  }
}

void mass_matrix(void* model, const double* q, const double*, const double*, double* out) {
  Model& m = of(model);
  place(m, q);
  mj_crb(m.model, m.data);
  mj_fullM(m.model, out, m.data->qM);
  turn_matrix(m, out);
}

void metric_inverse(void* model, const double* q, const double*, const double*, double* out) {
  Model& m = of(model);
  place(m, q);
  mj_crb(m.model, m.data);
  mj_factorM(m.model, m.data);
  const int n = m.model->nv;
  std::fill_n(m.unit.begin(), m.unit.size(), 0.0);
  for (int i = 0; i < n; ++i) {
    m.unit[static_cast<std::size_t>(i * n + i)] = 1.0;
  }
  mj_solveM(m.model, m.data, out, m.unit.data(), n);
  turn_matrix(m, out);
}

void forward_dynamics(void* model, const double* q, const double* v, const double* tau,
                      double* out) {
  Model& m = of(model);
  place(m, q);
  mj_crb(m.model, m.data);
  mj_factorM(m.model, m.data);
  move(m, v);
  mj_rne(m.model, m.data, 0, m.data->qfrc_bias);
  std::copy_n(tau, m.model->nv, m.data->qfrc_smooth);
  if (m.floating) {
    turn(m, m.data->qfrc_smooth, true);
  }
  for (int i = 0; i < m.model->nv; ++i) {
    m.data->qfrc_smooth[i] -= m.data->qfrc_bias[i];
  }
  mj_solveM(m.model, m.data, out, m.data->qfrc_smooth, 1);
  if (m.floating) {
    turn(m, out, false);
    mjtNum turning[3];
    mju_cross(turning, v + 3, v);
    mju_subFrom3(out, turning);
  }
}

constexpr Peer kPeer{
    "MuJoCo",
    "",
    1e-9,
    make,
    destroy,
    {bias, gravity, inverse_dynamics, mass_matrix, forward_dynamics, nullptr, metric_inverse}};

}  // namespace

extern "C" const geodesic::bench::Peer* geodesic_bench_peer() {
  static Peer peer = kPeer;
  peer.version = mj_versionString();
  return &peer;
}
