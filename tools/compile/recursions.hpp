// The recursions of rigid-body dynamics, run on numbers that are expressions: each returns the
// graph of one function of a mechanism. The frames they run in are reduced_tree.hpp's.
#pragma once

#include <memory>
#include <string>
#include <vector>

#include "tools/compile/graph.hpp"
#include "tools/compile/reduced_tree.hpp"

namespace geodesic::tools::compile {

/// One function to be written as code: outputs in the order of its result array.
struct Program {
  std::string name;
  std::vector<Array> arguments;
  std::unique_ptr<Graph> graph = std::make_unique<Graph>();
  std::vector<Number> outputs;

  Cost cost() const { return cost_of(*graph, outputs); }
};

/// C v + g, size nv. Newton-Euler with U = hat(alpha) + hat(omega)^2 (Wittenburg 1977), as
/// control/mechanism/newton_euler.cpp.
Program bias_program(const ReducedTree& tree);
/// g, size nv: Featherstone 2008, table 5.1, moments only where bodies have no mass.
Program gravity_program(const ReducedTree& tree);
/// M, nv x nv, both triangles: composite bodies, Featherstone 2008, table 6.2.
Program metric_program(const ReducedTree& tree);
/// M a + C v + g.
Program inverse_dynamics_program(const ReducedTree& tree);

/// Three components.
struct Triple {
  Number x;
  Number y;
  Number z;
};

inline Triple constant(const Eigen::Vector3d& v) {
  return {v.x(), v.y(), v.z()};
}
inline Triple operator+(const Triple& a, const Triple& b) {
  return {a.x + b.x, a.y + b.y, a.z + b.z};
}
inline Triple operator-(const Triple& a) {
  return {-a.x, -a.y, -a.z};
}
inline Triple operator*(const Number& s, const Triple& a) {
  return {s * a.x, s * a.y, s * a.z};
}
inline Number dot(const Triple& a, const Triple& b) {
  return a.x * b.x + a.y * b.y + a.z * b.z;
}
inline Triple cross(const Triple& a, const Triple& b) {
  return {a.y * b.z - a.z * b.y, a.z * b.x - a.x * b.z, a.x * b.y - a.y * b.x};
}

/// What all recursions need of a tree's motion, as expressions.
class Frames {
 public:
  Frames(const ReducedTree& tree, Graph& graph);

  const ReducedTree& tree() const { return tree_; }
  Graph& graph() { return graph_; }
  const ReducedBody& body(int i) const { return tree_.bodies[static_cast<std::size_t>(i)]; }
  int size() const { return static_cast<int>(tree_.bodies.size()); }

  Number sine(int i) const { return sine_[static_cast<std::size_t>(i)]; }
  Number cosine(int i) const { return cosine_[static_cast<std::size_t>(i)]; }
  /// The origin of body i in its parent.
  Triple translation(int i);
  /// Components along the parent's axes, turned and tilted but not yet turned by the joint.
  Triple tilted(int i, const Triple& in_parent) const;
  Triple to_body(int i, const Triple& in_parent) const;
  Triple to_parent(int i, const Triple& in_body) const;

  /// The first of the bodies with parallel axes that `i` is one of, where it takes sums of angles.
  int head(int i) const { return head_[static_cast<std::size_t>(i)]; }
  /// A vector fixed in the head's tilted axes, along the axes of body i: the angles' sum at once.
  Triple from_head(int i, const Triple& tilted_in_head) const;

  /// Gravity along the axes of a free base, and of the world.
  Triple gravity_of_base();
  /// Puts a name on the components.
  void name(const Triple& triple, const char* what, int i);

 private:
  Triple turn(const Number& sine, const Number& cosine, const Triple& v) const;

  const ReducedTree& tree_;
  Graph& graph_;
  std::vector<Number> sine_;
  std::vector<Number> cosine_;
  std::vector<int> head_;
  std::vector<Angle> sum_;
  std::vector<Number> sum_sine_;
  std::vector<Number> sum_cosine_;
};

}  // namespace geodesic::tools::compile
