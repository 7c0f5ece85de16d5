// Composite bodies in normal form; see the header.
#include "tools/derive/metric_of_tree.hpp"

#include <fmt/format.h>

#include <utility>

namespace geodesic::tools::derive {
namespace {

struct Composite {
  Polynomial mass;
  Vector first_moment;
  Matrix inertia;
};

struct SymbolicWrench {
  Vector force;
  Vector moment;
};

class Recursion {
 public:
  Recursion(SymbolicTree& tree, std::size_t limit, const OnProgress& on_progress)
      : tree_(tree), table_(tree.symbols.monomials), limit_(limit), on_progress_(on_progress) {
    const std::size_t n = tree.symbols.coordinates.size();
    result_.metric.assign(n, std::vector<Polynomial>(n));
    for (const SymbolicBody& body : tree.bodies) {
      composites_.push_back({body.mass, body.first_moment, body.inertia});
    }
  }

  MetricOfTree run() {
    for (std::size_t i = tree_.bodies.size(); i-- > 0;) {
      report(i);
      add_column(i);
      hand_on(i);
    }
    auto& metric = result_.metric;
    for (std::size_t i = 0; i < metric.size(); ++i) {
      metric[i][i] += tree_.rotor[i];
      for (std::size_t j = 0; j < i; ++j) metric[i][j] = metric[j][i];
    }
    for (std::size_t axis = 0; axis < 3; ++axis) {
      result_.potential -= times(tree_.gravity[axis], world_moment_[axis]);
    }
    return std::move(result_);
  }

 private:
  Polynomial times(const Polynomial& a, const Polynomial& b) { return multiply(table_, a, b); }

  // Coordinates of the body to those of its parent, the origin kept.
  Vector turned(const SymbolicBody& body, const Vector& v) const {
    Vector in_joint = v;
    if (body.rotation) {
      in_joint[0] = turn(v[0], v[1], body.wave, -1.0L);
      in_joint[1] = turn(v[1], v[0], body.wave, 1.0L);
    }
    Vector result;
    for (std::size_t i = 0; i < 3; ++i) {
      for (std::size_t j = 0; j < 3; ++j) {
        const long double factor =
            body.parent_rotation(static_cast<Eigen::Index>(i), static_cast<Eigen::Index>(j));
        if (factor != 0.0L) result[i] += factor * in_joint[j];
      }
    }
    return result;
  }

  Vector origin_in_parent(const SymbolicBody& body) const {
    Vector origin = body.parent_translation;
    for (std::size_t i = 0; i < 3 && !body.rotation; ++i) {
      origin[i] += body.parent_rotation(static_cast<Eigen::Index>(i), 2) * body.shift;
    }
    return origin;
  }

  Vector cross(const Vector& a, const Vector& b) {
    Vector result;
    for (std::size_t i = 0; i < 3; ++i) {
      const std::size_t j = (i + 1) % 3;
      const std::size_t k = (i + 2) % 3;
      result[i] = times(a[j], b[k]) - times(a[k], b[j]);
    }
    return result;
  }

  Composite in_parent(const SymbolicBody& body, const Composite& own) {
    Matrix half;
    for (std::size_t i = 0; i < 3; ++i) half[i] = turned(body, own.inertia[i]);  // I R'
    Composite result{own.mass, turned(body, own.first_moment), {}};
    for (std::size_t j = 0; j < 3; ++j) {
      const Vector column = turned(body, {half[0][j], half[1][j], half[2][j]});
      for (std::size_t i = 0; i < 3; ++i) result.inertia[i][j] = column[i];
    }
    // The parallel-axis theorem, for a body whose centre of mass is not its origin.
    const Vector p = origin_in_parent(body);
    const Vector& h = result.first_moment;
    Vector both;
    for (std::size_t i = 0; i < 3; ++i) both[i] = h[i] + times(own.mass, p[i]);
    Matrix shift;
    for (std::size_t i = 0; i < 3; ++i) {
      for (std::size_t j = 0; j < 3; ++j) shift[i][j] = times(both[i], p[j]) + times(p[i], h[j]);
    }
    const Polynomial trace = shift[0][0] + shift[1][1] + shift[2][2];
    for (std::size_t i = 0; i < 3; ++i) {
      result.inertia[i][i] += trace;
      for (std::size_t j = 0; j < 3; ++j) result.inertia[i][j] -= shift[i][j];
    }
    result.first_moment = both;
    return result;
  }

  // Momentum of the composite per unit of its joint's rate, and what it is at every joint inwards.
  void add_column(std::size_t index) {
    const SymbolicBody& body = tree_.bodies[index];
    const Composite& composite = composites_[index];
    const Vector& h = composite.first_moment;
    SymbolicWrench momentum;
    if (body.rotation) {
      momentum.force = {-1.0L * h[1], h[0], Polynomial()};
      for (std::size_t i = 0; i < 3; ++i) momentum.moment[i] = composite.inertia[i][2];
    } else {
      momentum.force[2] = composite.mass;
      momentum.moment = {h[1], -1.0L * h[0], Polynomial()};
    }
    for (std::size_t at = index;;) {
      const SymbolicBody& joint = tree_.bodies[at];
      Polynomial entry = joint.rotation ? momentum.moment[2] : momentum.force[2];
      entry *= body.ratio * joint.ratio;
      if (at != index && joint.dof == body.dof) entry *= 2.0L;  // both orders of the pair
      const auto row = static_cast<std::size_t>(std::min(joint.dof, body.dof));
      const auto column = static_cast<std::size_t>(std::max(joint.dof, body.dof));
      result_.metric[row][column] += entry;
      if (joint.parent == control::kWorld) break;
      const Vector force = turned(joint, momentum.force);
      Vector moment = turned(joint, momentum.moment);
      const Vector lever = cross(origin_in_parent(joint), force);
      for (std::size_t i = 0; i < 3; ++i) moment[i] += lever[i];
      momentum = {force, moment};
      at = static_cast<std::size_t>(joint.parent);
    }
  }

  void hand_on(std::size_t index) {
    const SymbolicBody& body = tree_.bodies[index];
    if (body.parent == control::kWorld) {
      // Of what stands in the world only the height counts.
      const Vector moment = turned(body, composites_[index].first_moment);
      const Vector origin = origin_in_parent(body);
      for (std::size_t i = 0; i < 3; ++i) {
        world_moment_[i] += moment[i] + times(composites_[index].mass, origin[i]);
      }
      return;
    }
    Composite& parent = composites_[static_cast<std::size_t>(body.parent)];
    const Composite moved = in_parent(body, composites_[index]);
    parent.mass += moved.mass;
    for (std::size_t i = 0; i < 3; ++i) {
      parent.first_moment[i] += moved.first_moment[i];
      for (std::size_t j = 0; j < 3; ++j) parent.inertia[i][j] += moved.inertia[i][j];
    }
    composites_[index] = {};
  }

  void report(std::size_t left) const {
    std::size_t terms = 0;
    std::size_t largest = 0;
    for (const auto& row : result_.metric) {
      for (const Polynomial& entry : row) terms += entry.terms().size();
    }
    for (const Composite& composite : composites_) {
      std::size_t of_body = 0;
      for (const Vector& row : composite.inertia) {
        for (const Polynomial& entry : row) of_body += entry.terms().size();
      }
      largest = std::max(largest, of_body);
      terms += of_body;
    }
    if (limit_ > 0 && terms > limit_) {
      throw TooLong(fmt::format(
          "the metric of this robot has more than {} terms of sines and cosines ({} at body {} of "
          "{}, "
          "counted from the tips; each further joint multiplies them by 3 to 5), so a closed form "
          "is "
          "out of reach; `geodesic model` evaluates it, `geodesic compile` makes code of it. Fewer "
          "joints (`lock` in the robot's file), or numbers in place of letters, may do",
          limit_, terms, tree_.bodies.size() - left, tree_.bodies.size()));
    }
    if (!on_progress_) return;
    const auto all = static_cast<double>(tree_.bodies.size());
    on_progress_({"metric", 1.0 - static_cast<double>(left + 1) / all, terms, 0});
  }

  SymbolicTree& tree_;
  MonomialTable& table_;
  std::size_t limit_;
  const OnProgress& on_progress_;
  std::vector<Composite> composites_;
  Vector world_moment_;
  MetricOfTree result_;
};

}  // namespace

MetricOfTree metric_of_tree(SymbolicTree& tree, std::size_t limit, const OnProgress& on_progress) {
  return Recursion(tree, limit, on_progress).run();
}

}  // namespace geodesic::tools::derive
