// The door through which a dynamics library is asked: plain C data and functions, so that each
// library can live in a shared object of its own, built the way that library wants to be built.
#pragma once

namespace geodesic::bench {

/// A rigid body and the joint that carries it. Matrices row-major, SI units.
struct PeerBody {
  int parent;  ///< index, less than its own; -1: the world
  /// kFree: the root of a robot that floats, body 0.
  enum Kind : int { kFixed, kRevolute, kPrismatic, kFree } kind;
  double rotation[9];     ///< parent_from_joint at position 0
  double translation[3];  ///< [m]
  double axis[3];         ///< unit, joint frame, which is the body's too
  double mass;            ///< [kg]
  double com[3];          ///< [m]
  double inertia[9];      ///< about the centre of mass, along the body's axes [kg·m²]
};

/// q and v are the joints'; before them, where body 0 is free, position in the world and quaternion
/// x y z w in q, linear and angular velocity along the base's own axes in v. Accelerations are the
/// time derivatives of v's numbers, torques are dual to v.
struct PeerRobot {
  const PeerBody* body;  ///< degrees of freedom in the order of the moving bodies
  int bodies;
  int nq;
  int dof;
  double gravity[3];     ///< world [m/s²]
  const char* compiled;  ///< file of the robot's model compiled ahead, or null
};

enum PeerFunction : unsigned {
  kBias,             ///< (q, v) -> C v + g
  kGravity,          ///< (q) -> g
  kInverseDynamics,  ///< (q, v, x = a) -> M a + C v + g
  kMassMatrix,       ///< (q) -> M, dof x dof
  kForwardDynamics,  ///< (q, v, x = tau) -> a
  kCoriolisMatrix,   ///< (q, v) -> C, dof x dof, column-major
  kMetricInverse,    ///< (q) -> inverse of M, dof x dof
  kPeerFunctions,
};

/// `out` has dof numbers, or dof * dof of a matrix.
using PeerCall = void (*)(void* model, const double* q, const double* v, const double* x,
                          double* out);

struct Peer {
  const char* name;
  const char* version;
  /// How far its results may be from ours, relative to the largest entry, and still be right.
  double agreement;
  /// Null where the library cannot have such a robot; *why then says so, a literal.
  void* (*make)(const PeerRobot* robot, const char** why);
  void (*destroy)(void* model);
  PeerCall call[kPeerFunctions];  ///< null: the library has no such function
};

/// What each shared object exports.
using PeerEntry = const Peer* (*)();
inline constexpr const char* kPeerEntry = "geodesic_bench_peer";

}  // namespace geodesic::bench
