// The metric on expressions: composite bodies from tip to root; see recursions.hpp.
#include "tools/compile/recursions.hpp"

namespace geodesic::tools::compile {
namespace {

using control::kWorld;
using control::Motion;

/// A symmetric matrix.
struct Symmetric {
  Number xx, yy, zz, xy, xz, yz;
};

/// Rz(angle) S Rz(-angle).
Symmetric turned(const Symmetric& s, const Number& sine, const Number& cosine, bool double_angle) {
  Symmetric r;
  r.zz = s.zz;
  r.xz = cosine * s.xz - sine * s.yz;
  r.yz = sine * s.xz + cosine * s.yz;
  if (double_angle) {
    // Half the sum of xx and yy stays, half their difference and xy turn by the double angle.
    const Number sine2 = 2.0 * sine * cosine;
    const Number cosine2 = 1.0 - 2.0 * sine * sine;
    const Number half_sum = 0.5 * (s.xx + s.yy);
    const Number half = 0.5 * (s.xx - s.yy);
    const Number turned_half = cosine2 * half - sine2 * s.xy;
    r.xx = half_sum + turned_half;
    r.yy = half_sum - turned_half;
    r.xy = sine2 * half + cosine2 * s.xy;
  } else {
    const Number x = cosine * s.xx - sine * s.xy;
    const Number y = cosine * s.xy - sine * s.yy;
    r.xx = cosine * x - sine * y;
    r.xy = sine * x + cosine * y;
    // By constants (a tilt) some products vanish; else the trace says what is left.
    r.yy = sine.is_constant()
               ? sine * (sine * s.xx + cosine * s.xy) + cosine * (sine * s.xy + cosine * s.yy)
               : s.xx + s.yy - r.xx;
  }
  return r;
}

/// Rx(tilt) S Rx(-tilt), then Rz(turn) likewise, by constants.
Symmetric tilted(const Symmetric& s, const ReducedBody& body) {
  const Symmetric cyclic{s.yy, s.zz, s.xx, s.yz, s.xy, s.xz};  // x, y, z -> z, x, y
  const Symmetric r = turned(cyclic, body.tilt_sine, body.tilt_cosine, false);
  const Symmetric back{r.zz, r.xx, r.yy, r.xz, r.yz, r.xy};
  return turned(back, body.turn_sine, body.turn_cosine, false);
}

/// A body and all that hangs on it, in its own axes about its own origin.
struct Composite {
  Number mass;
  Triple first;
  Symmetric second;
};

void add(Composite& to, const Composite& more) {
  to.mass += more.mass;
  to.first = to.first + more.first;
  to.second.xx += more.second.xx;
  to.second.yy += more.second.yy;
  to.second.zz += more.second.zz;
  to.second.xy += more.second.xy;
  to.second.xz += more.second.xz;
  to.second.yz += more.second.yz;
}

/// Seen from an origin from which its own is at p.
Composite shifted(const Composite& c, const Triple& p) {
  const auto& h = c.first;
  const Triple whole{h.x + 0.5 * c.mass * p.x, h.y + 0.5 * c.mass * p.y, h.z + 0.5 * c.mass * p.z};
  Composite r;
  r.mass = c.mass;
  r.first = h + c.mass * p;
  r.second = {c.second.xx + 2.0 * p.x * whole.x,
              c.second.yy + 2.0 * p.y * whole.y,
              c.second.zz + 2.0 * p.z * whole.z,
              c.second.xy + (p.x * whole.y + p.y * whole.x),
              c.second.xz + (p.x * whole.z + p.z * whole.x),
              c.second.yz + (p.y * whole.z + p.z * whole.y)};
  return r;
}

class CompositeBodies {
 public:
  CompositeBodies(const ReducedTree& tree, Graph& graph) : frames_(tree, graph), nv_(tree.nv) {}

  std::vector<Number> run() {
    const auto nv = static_cast<std::size_t>(nv_);
    metric_.assign(nv * nv, 0.0);
    for (int i = 0; i < nv_; ++i) entry(i, i) = frames_.tree().rotor_inertia[i];
    composite_.resize(static_cast<std::size_t>(frames_.size()));
    for (int i = frames_.size() - 1; i >= 0; --i) visit(i);
    return metric_;
  }

 private:
  Number& entry(int i, int j) {
    return metric_[static_cast<std::size_t>(i) * static_cast<std::size_t>(nv_) +
                   static_cast<std::size_t>(j)];
  }

  void add_own(int i) {
    const ReducedBody& body = frames_.body(i);
    const auto& s = body.second_moment;
    add(composite_[static_cast<std::size_t>(i)],
        {body.mass,
         constant(body.first_moment),
         {s(0, 0), s(1, 1), s(2, 2), s(0, 1), s(0, 2), s(1, 2)}});
  }

  void visit(int i) {
    const auto at = static_cast<std::size_t>(i);
    const ReducedBody& body = frames_.body(i);
    add_own(i);
    const Composite& all = composite_[at];
    frames_.name(all.first, "h", i);
    if (body.motion == Motion::kFree) {
      add_base(all);
      return;
    }
    add_joint(i, all);
    if (body.parent == kWorld) return;
    Composite in_parent = all;
    if (body.motion == Motion::kRotation) {
      in_parent.first = frames_.to_parent(i, all.first);
      in_parent.second = tilted(
          turned(all.second, frames_.sine(i), frames_.cosine(i), body.choice.tree_form != 0), body);
    }
    add(composite_[static_cast<std::size_t>(body.parent)],
        shifted(in_parent, frames_.translation(i)));
  }

  /// Momentum that a unit of the joint's speed gives to all it carries, felt along every joint on
  /// the way to the root.
  void add_joint(int i, const Composite& all) {
    const ReducedBody& body = frames_.body(i);
    Triple force;
    Triple moment;
    if (body.motion == Motion::kRotation) {
      force = {-all.first.y, all.first.x, 0.0};
      moment = {-all.second.xz, -all.second.yz, all.second.xx + all.second.yy};
    } else {
      const Triple axis = constant(body.axis);
      force = all.mass * axis;
      moment = cross(all.first, axis);
    }
    const int column = body.dof;
    entry(column, column) += body.rate * body.rate * felt(i, force, moment);
    for (int at = i; frames_.body(at).parent != kWorld;) {
      const Triple on_parent = frames_.to_parent(at, force);
      moment = frames_.to_parent(at, moment) + cross(frames_.translation(at), on_parent);
      force = on_parent;
      at = frames_.body(at).parent;
      const ReducedBody& above = frames_.body(at);
      if (above.motion == Motion::kFree) {
        const Number six[] = {force.x, force.y, force.z, moment.x, moment.y, moment.z};
        for (int k = 0; k < 6; ++k) {
          const Number value = body.rate * six[k];
          entry(above.dof + k, column) += value;
          entry(column, above.dof + k) += value;
        }
      } else {
        // Where two joints share a degree of freedom (mimic), both terms fall on the diagonal.
        const Number value = body.rate * above.rate * felt(at, force, moment);
        entry(above.dof, column) += value;
        entry(column, above.dof) += value;
      }
    }
  }

  Number felt(int i, const Triple& force, const Triple& moment) const {
    const ReducedBody& body = frames_.body(i);
    return body.motion == Motion::kRotation ? moment.z : dot(constant(body.axis), force);
  }

  void add_base(const Composite& all) {
    const int first = frames_.body(0).dof;
    const Triple& h = all.first;
    const Symmetric& s = all.second;
    const Number hat[3][3] = {{0.0, -h.z, h.y}, {h.z, 0.0, -h.x}, {-h.y, h.x, 0.0}};
    const Number inertia[3][3] = {
        {s.yy + s.zz, -s.xy, -s.xz}, {-s.xy, s.xx + s.zz, -s.yz}, {-s.xz, -s.yz, s.xx + s.yy}};
    for (int i = 0; i < 3; ++i) {
      entry(first + i, first + i) += all.mass;
      for (int j = 0; j < 3; ++j) {
        entry(first + 3 + i, first + j) += hat[i][j];
        entry(first + j, first + 3 + i) += hat[i][j];
        entry(first + 3 + i, first + 3 + j) += inertia[i][j];
      }
    }
  }

  Frames frames_;
  int nv_;
  std::vector<Composite> composite_;
  std::vector<Number> metric_;
};

}  // namespace

Program metric_program(const ReducedTree& tree) {
  Program program{.name = "metric", .arguments = {Array::kQ}, .outputs = {}};
  program.outputs = CompositeBodies(tree, *program.graph).run();
  return program;
}

}  // namespace geodesic::tools::compile
