// Implements metric.hpp on compact bodies: where everything carried is light it has no mass either,
// and of a turning joint's momentum only four products of inertia are asked for.
#include "control/mechanism/metric.hpp"

#include <cassert>

#include "control/mechanism/compact_dispatch.hpp"
#include "control/mechanism/compact_motion.hpp"

namespace geodesic::control {
namespace {

using Carried = Workspace::Carried;
using Momentum = Workspace::Load;
using Second = Workspace::Second;

/// The second moment after a turn about z.
inline Second about_z(const Second& m, double s, double c) noexcept {
  const double to_x = c * m.xx - s * m.xy;
  const double to_y = c * m.xy - s * m.yy;
  const double xx = c * to_x - s * to_y;
  return {xx,  s * to_x + c * to_y, c * m.xz - s * m.yz, (m.xx + m.yy) - xx, s * m.xz + c * m.yz,
          m.zz};
}

/// The second moment after a turn about x.
inline Second about_x(const Second& m, double s, double c) noexcept {
  const double to_y = c * m.yy - s * m.yz;
  const double to_z = c * m.yz - s * m.zz;
  const double yy = c * to_y - s * to_z;
  return {m.xx, c * m.xy - s * m.xz, s * m.xy + c * m.xz,
          yy,   s * to_y + c * to_z, (m.yy + m.zz) - yy};
}

inline Second tilted(const NoTilt& /*tilt*/, const Second& m) noexcept {
  return m;
}
inline Second tilted(const QuarterTilt& /*tilt*/, const Second& m) noexcept {
  return {m.xx, -m.xz, m.xy, m.zz, -m.yz, m.yy};
}
inline Second tilted(const AnyTilt& tilt, const Second& m) noexcept {
  const CompactBody& body = tilt.body;
  const Second leaning = about_x(m, body.lean.sine, body.lean.cosine);
  return body.turned ? about_z(leaning, body.turn.sine, body.turn.cosine) : leaning;
}

/// Along the axes of the joint that the body is free against.
inline Second to_joint(const Axes& axes, const Second& m) noexcept {
  const auto half = [&m](const Triple& row) {
    return Triple{m.xx * row.x + m.xy * row.y + m.xz * row.z,
                  m.xy * row.x + m.yy * row.y + m.yz * row.z,
                  m.xz * row.x + m.yz * row.y + m.zz * row.z};
  };
  const auto dot = [](const Triple& a, const Triple& b) {
    return a.x * b.x + a.y * b.y + a.z * b.z;
  };
  const Triple x = half(axes.x);
  const Triple y = half(axes.y);
  return {dot(axes.x, x), dot(axes.x, y), dot(axes.z, x),
          dot(axes.y, y), dot(axes.z, y), dot(axes.z, half(axes.z))};
}

inline Carried operator+(const Carried& a, const Carried& b) noexcept {
  const Second& m = a.second;
  const Second& n = b.second;
  return {a.mass + b.mass,
          a.first + b.first,
          {m.xx + n.xx, m.xy + n.xy, m.xz + n.xz, m.yy + n.yy, m.yz + n.yz, m.zz + n.zz}};
}

/// About the parent's origin, p being where the body's is: the parallel-axis theorem.
inline void move_by(const Triple& p, Carried& carried) noexcept {
  const Triple h = carried.first + (0.5 * carried.mass) * p;
  Second& m = carried.second;
  m.xx += 2.0 * (h.x * p.x);
  m.xy += h.x * p.y + p.x * h.y;
  m.xz += h.x * p.z + p.x * h.z;
  m.yy += 2.0 * (h.y * p.y);
  m.yz += h.y * p.z + p.y * h.z;
  m.zz += 2.0 * (h.z * p.z);
  carried.first = carried.first + carried.mass * p;
}

/// What the body hands on to its parent of what it carries.
inline Carried to_parent(const CompactBody& body, const Workspace& workspace, std::size_t i,
                         const double* q, const Carried& own) noexcept {
  Carried carried = own;
  if (body.many) {
    const Axes& axes = workspace.axes[i];
    carried.first = to_joint(axes, carried.first);
    carried.second = to_joint(axes, carried.second);
  }
  const double s = workspace.sine[i];
  const double c = workspace.cosine[i];
  with_rotation(body, s, c, [&](const auto& rotation) {
    carried.first = rotation.to_parent(carried.first);
    carried.second = tilted(rotation.tilt, about_z(carried.second, s, c));
    if (body.reach == Reach::kInPlane && !body.pushes) {
      const Triple& h = carried.first;
      carried.second.xx += 2.0 * (h.x * body.x);
      carried.second.xy += h.x * body.y + body.x * h.y;
      carried.second.xz += body.x * h.z;
      carried.second.yy += 2.0 * (h.y * body.y);
      carried.second.yz += body.y * h.z;
    } else if (body.reach != Reach::kNone) {
      move_by(joint_translation(body, rotation, q), carried);
    }
  });
  return carried;
}

/// Momentum of what a joint carries when it moves along column k of its own.
inline Momentum momentum_of(const CompactBody& body, const Carried& carried, int k) noexcept {
  const Triple& h = carried.first;
  const Second& m = carried.second;
  const double mass = carried.mass;
  if (body.rotates) {
    return {{-(body.ratio * h.y), body.ratio * h.x, 0.0},
            {-(body.ratio * m.xz), -(body.ratio * m.yz), body.ratio * (m.xx + m.yy)}};
  }
  if (!body.many) {
    return {{0.0, 0.0, body.ratio * mass}, {body.ratio * h.y, -(body.ratio * h.x), 0.0}};
  }
  switch (k - angular_offset(body)) {
    case -3:
      return {{mass, 0.0, 0.0}, {0.0, h.z, -h.y}};
    case -2:
      return {{0.0, mass, 0.0}, {-h.z, 0.0, h.x}};
    case -1:
      return {{0.0, 0.0, mass}, {h.y, -h.x, 0.0}};
    case 0:
      return {{0.0, -h.z, h.y}, {m.yy + m.zz, -m.xy, -m.xz}};
    case 1:
      return {{h.z, 0.0, -h.x}, {-m.xy, m.xx + m.zz, -m.yz}};
    default:
      return {{-h.y, h.x, 0.0}, {-m.xz, -m.yz, m.xx + m.yy}};
  }
}

/// Of a body with more than one degree of freedom: what its column k feels of the momentum.
inline double along(const CompactBody& body, const Momentum& p, int k) noexcept {
  const double all[] = {p.force.x, p.force.y, p.force.z, p.moment.x, p.moment.y, p.moment.z};
  return all[k + 3 - angular_offset(body)];
}

/// The matrix by columns, nv x nv.
struct Table {
  double& operator()(int row, int column) const noexcept { return first[row + size * column]; }
  double* first;
  int size;
};

/// A column of joint `i`: the momentum felt along every joint on the way to the world.
[[gnu::always_inline]] inline void fill_column(const CompactBody* bodies,
                                               const Workspace& workspace, std::size_t i,
                                               int column, Momentum p, const double* q,
                                               const Table& m) noexcept {
  while (!bodies[i].at_base) {
    const CompactBody& body = bodies[i];
    const double s = workspace.sine[i];
    const double c = workspace.cosine[i];
    const bool done = with_step(body, s, c, [&](const auto& rotation, auto reaches) {
      p = {rotation.to_parent(p.force), rotation.to_parent(p.moment)};
      if constexpr (reaches()) {
        add_moment_in_plane(body, p.force, p.moment);
      }
    });
    if (!done && body.many) {
      p = {to_joint(workspace.axes[i], p.force), to_joint(workspace.axes[i], p.moment)};
    }
    if (!done) {
      with_rotation(body, s, c, [&](const auto& rotation) {
        p = {rotation.to_parent(p.force), rotation.to_parent(p.moment)};
        add_moment_of(body, rotation, q, p.force, p.moment);
      });
    }
    i = static_cast<std::size_t>(body.parent);
    const CompactBody& above = bodies[i];
    // Where two joints share a degree of freedom (mimic), both terms fall on the diagonal.
    if (above.many) {
      for (int j = 0; j < 3 + angular_offset(above); ++j) {
        const double entry = along(above, p, j);
        m(above.dof + j, column) += entry;
        m(column, above.dof + j) += entry;
      }
    } else {
      const double entry = above.ratio * (above.rotates ? p.moment.z : p.force.z);
      m(above.dof, column) += entry;
      m(column, above.dof) += entry;
    }
  }
}

/// The columns of a body with more than one degree of freedom.
void fill_columns(const CompactBody* bodies, const Workspace& workspace, std::size_t i,
                  const Carried& carried, const double* q, const Table& m) noexcept {
  const CompactBody& body = bodies[i];
  for (int k = 0; k < 3 + angular_offset(body); ++k) {
    const Momentum p = momentum_of(body, carried, k);
    m(body.dof + k, body.dof + k) += along(body, p, k);
    for (int j = 0; j < k; ++j) {
      m(body.dof + j, body.dof + k) = m(body.dof + k, body.dof + j) = along(body, p, j);
    }
    fill_column(bodies, workspace, i, body.dof + k, p, q, m);
  }
}

[[gnu::always_inline]] inline void composite_bodies(const CompactBody* bodies, std::size_t n,
                                                    Workspace& workspace, const double* q,
                                                    const Table& m) noexcept {
  for (std::size_t i = 0; i < n; ++i) {
    if (bodies[i].forks) {
      workspace.carried[i] = {};
    }
    if (bodies[i].many) {
      workspace.axes[i] = axes_at(q + bodies[i].coordinate + angular_offset(bodies[i]));
    }
  }
  Carried handed_on;  // by the body before, in a chain
  for (std::size_t i = n; i-- > 0;) {
    const CompactBody& body = bodies[i];
    Carried carried =
        handed_on + Carried{body.mass,
                            {body.h_x, body.h_y, body.h_z},
                            {body.s_xx, body.s_xy, body.s_xz, body.s_yy, body.s_yz, body.s_zz}};
    if (body.forks) {
      carried = carried + workspace.carried[i];
    }
    if (body.many) {
      fill_columns(bodies, workspace, i, carried, q, m);
    } else {
      const Momentum p = momentum_of(body, carried, 0);
      m(body.dof, body.dof) += body.ratio * (body.rotates ? p.moment.z : p.force.z);
      fill_column(bodies, workspace, i, body.dof, p, q, m);
    }
    handed_on = {};
    if (body.at_base) {
      continue;
    }
    handed_on = to_parent(body, workspace, i, q, carried);
    if (!body.chained) {
      Carried& parent = workspace.carried[static_cast<std::size_t>(body.parent)];
      parent = parent + handed_on;
      handed_on = {};
    }
  }
}

}  // namespace

const Eigen::MatrixXd& metric(const Mechanism& mechanism, Workspace& workspace,
                              const VectorIn& q) noexcept {
  assert(q.size() == mechanism.nq());
  const CompactTree& tree = mechanism.compact_tree();
  const CompactBody* bodies = tree.bodies.data();
  const std::size_t n = tree.bodies.size();
  const double* at = q.data();
  Eigen::MatrixXd& m = workspace.metric;
  m.setZero();
  m.diagonal() = mechanism.rotor_inertia();
  const Table table{m.data(), mechanism.dof()};
  run_with(workspace.registers, [&](auto lanes) noexcept {
    find_angles<lanes()>(tree, at, workspace);
    composite_bodies(bodies, n, workspace, at, table);
  });
  return m;
}

}  // namespace geodesic::control
