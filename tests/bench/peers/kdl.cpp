// Orocos KDL as a peer: its chain solvers, the ones its users use. What hangs off the chain on
// fixed joints is added to the segment that carries it, since a KDL chain would drop it.
#include <kdl/config.h>
#include <kdl/chain.hpp>
#include <kdl/chaindynparam.hpp>
#include <kdl/chainfdsolver_recursive_newton_euler.hpp>
#include <kdl/chainidsolver_recursive_newton_euler.hpp>
#include <vector>

#include "tests/bench/peers/peer.hpp"

namespace {

using namespace geodesic::bench;

struct Model {
  Model(const KDL::Chain& chain_in, const KDL::Vector& gravity)
      : chain(chain_in),
        id(chain, gravity),
        fd(chain, gravity),
        parameters(chain, gravity),
        no_wrench(chain.getNrOfSegments(), KDL::Wrench::Zero()),
        q(chain.getNrOfJoints()),
        v(chain.getNrOfJoints()),
        x(chain.getNrOfJoints()),
        result(chain.getNrOfJoints()),
        zero(chain.getNrOfJoints()),
        mass(static_cast<int>(chain.getNrOfJoints())) {}

  KDL::Chain chain;
  KDL::ChainIdSolver_RNE id;
  KDL::ChainFdSolver_RNE fd;
  KDL::ChainDynParam parameters;
  KDL::Wrenches no_wrench;
  KDL::JntArray q, v, x, result, zero;
  KDL::JntSpaceInertiaMatrix mass;
};

void read(const double* from, KDL::JntArray& to) {
  for (unsigned i = 0; i < to.rows(); ++i) {
    to(i) = from[i];
  }
}

void write(const KDL::JntArray& from, double* to) {
  for (unsigned i = 0; i < from.rows(); ++i) {
    to[i] = from(i);
  }
}

KDL::Frame frame(const PeerBody& body) {
  const double* r = body.rotation;
  return {KDL::Rotation(r[0], r[1], r[2], r[3], r[4], r[5], r[6], r[7], r[8]),
          KDL::Vector(body.translation[0], body.translation[1], body.translation[2])};
}

KDL::RigidBodyInertia inertia(const PeerBody& body) {
  const double* i = body.inertia;
  return KDL::RigidBodyInertia(body.mass, KDL::Vector(body.com[0], body.com[1], body.com[2]),
                               KDL::RotationalInertia(i[0], i[4], i[8], i[1], i[2], i[5]));
}

/// As kdl_parser makes it of a URDF: one segment a joint.
KDL::Segment segment(const PeerBody& body, const KDL::RigidBodyInertia& carried) {
  const KDL::Frame parent_from_joint = frame(body);
  const KDL::Vector axis =
      parent_from_joint.M * KDL::Vector(body.axis[0], body.axis[1], body.axis[2]);
  KDL::Joint joint("fixed", KDL::Joint::None);
  if (body.kind != PeerBody::kFixed) {
    joint =
        KDL::Joint("moving", parent_from_joint.p, axis,
                   body.kind == PeerBody::kRevolute ? KDL::Joint::RotAxis : KDL::Joint::TransAxis);
  }
  return KDL::Segment("segment", joint, parent_from_joint, carried);
}

void* make(const PeerRobot* robot, const char** why) {
  const auto n = static_cast<std::size_t>(robot->bodies);
  std::vector<bool> on_path(n, false);
  int tip = -1;
  for (int i = 0; i < robot->bodies; ++i) {
    if (robot->body[i].kind == PeerBody::kFree) {
      *why = "its dynamics solvers know fixed bases only";
      return nullptr;
    }
    tip = robot->body[i].kind != PeerBody::kFixed ? i : tip;
  }
  for (int i = tip; i >= 0; i = robot->body[i].parent) {
    on_path[static_cast<std::size_t>(i)] = true;
  }
  std::vector<KDL::RigidBodyInertia> carried(n);
  for (std::size_t i = n; i-- > 0;) {
    const PeerBody& body = robot->body[i];
    carried[i] = carried[i] + inertia(body);
    if (on_path[i]) {
      continue;
    }
    if (body.kind != PeerBody::kFixed) {
      *why = "not a chain: joints move on a side branch";
      return nullptr;
    }
    if (body.parent >= 0) {
      const auto parent = static_cast<std::size_t>(body.parent);
      carried[parent] = carried[parent] + frame(body) * carried[i];
    }
  }
  KDL::Chain chain;
  for (std::size_t i = 0; i < n; ++i) {
    if (on_path[i]) {
      chain.addSegment(segment(robot->body[i], carried[i]));
    }
  }
  const double* g = robot->gravity;
  return new Model(chain, KDL::Vector(g[0], g[1], g[2]));
}

Model& of(void* model) {
  return *static_cast<Model*>(model);
}

void destroy(void* model) {
  delete &of(model);
}

void bias(void* model, const double* q, const double* v, const double*, double* out) {
  Model& m = of(model);
  read(q, m.q);
  read(v, m.v);
  m.id.CartToJnt(m.q, m.v, m.zero, m.no_wrench, m.result);
  write(m.result, out);
}

void gravity(void* model, const double* q, const double*, const double*, double* out) {
  Model& m = of(model);
  read(q, m.q);
  m.parameters.JntToGravity(m.q, m.result);
  write(m.result, out);
}

void inverse_dynamics(void* model, const double* q, const double* v, const double* a, double* out) {
  Model& m = of(model);
  read(q, m.q);
  read(v, m.v);
  read(a, m.x);
  m.id.CartToJnt(m.q, m.v, m.x, m.no_wrench, m.result);
  write(m.result, out);
}

void mass_matrix(void* model, const double* q, const double*, const double*, double* out) {
  Model& m = of(model);
  read(q, m.q);
  m.parameters.JntToMass(m.q, m.mass);
  const unsigned n = m.q.rows();
  for (unsigned i = 0; i < n; ++i) {
    for (unsigned j = 0; j < n; ++j) {
      out[i * n + j] = m.mass(i, j);
    }
  }
}

void forward_dynamics(void* model, const double* q, const double* v, const double* tau,
                      double* out) {
  Model& m = of(model);
  read(q, m.q);
  read(v, m.v);
  read(tau, m.x);
  m.fd.CartToJnt(m.q, m.v, m.x, m.no_wrench, m.result);
  write(m.result, out);
}

constexpr Peer kPeer{
    "KDL",   KDL_VERSION_STRING,
    1e-9,    make,
    destroy, {bias, gravity, inverse_dynamics, mass_matrix, forward_dynamics, nullptr, nullptr}};

}  // namespace

extern "C" const geodesic::bench::Peer* geodesic_bench_peer() {
  return &kPeer;
}
