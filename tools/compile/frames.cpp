// How bodies stand in their parents, as expressions; see recursions.hpp.
#include <fmt/format.h>

#include "tools/compile/recursions.hpp"

namespace geodesic::tools::compile {

using control::kWorld;
using control::Motion;

Frames::Frames(const ReducedTree& tree, Graph& graph) : tree_(tree), graph_(graph) {
  const std::size_t n = tree.bodies.size();
  sine_.resize(n);
  cosine_.assign(n, 1.0);
  sum_sine_.resize(n);
  sum_cosine_.assign(n, 1.0);
  head_.resize(n);
  sum_.resize(n);
  for (std::size_t i = 0; i < n; ++i) {
    const ReducedBody& body = tree.bodies[i];
    head_[i] = static_cast<int>(i);
    if (body.motion != Motion::kRotation) continue;
    const Angle own{body.angle};
    sine_[i] = graph.sine(own);
    cosine_[i] = graph.cosine(own);
    sum_[i] = own;
    const auto parent = static_cast<std::size_t>(std::max(body.parent, 0));
    if (body.parent != kWorld && body.parallel && body.choice.sums &&
        tree.bodies[parent].motion == Motion::kRotation) {
      head_[i] = head_[parent];
      sum_[i] = sum_[parent];
      sum_[i].push_back(body.angle);
    }
    sum_sine_[i] = graph.sine(sum_[i]);
    sum_cosine_[i] = graph.cosine(sum_[i]);
    graph.name(sine_[i], "sin" + body.label);
    graph.name(cosine_[i], "cos" + body.label);
    const std::string head = tree.bodies[static_cast<std::size_t>(head_[i])].label;
    graph.name(sum_sine_[i], fmt::format("sin{}to{}", head, body.label));
    graph.name(sum_cosine_[i], fmt::format("cos{}to{}", head, body.label));
  }
}

Triple Frames::translation(int i) {
  const ReducedBody& own = body(i);
  const Triple fixed = constant(own.translation);
  if (own.motion != Motion::kTranslation) return fixed;
  const Number way = own.rate * graph_.input(Array::kQ, own.coordinate) + own.slide;
  return fixed + way * constant(own.axis);
}

Triple Frames::tilted(int i, const Triple& v) const {
  const ReducedBody& own = body(i);
  const Number x = own.turn_cosine * v.x + own.turn_sine * v.y;
  const Number y = own.turn_cosine * v.y - own.turn_sine * v.x;
  return {x, own.tilt_cosine * y + own.tilt_sine * v.z, own.tilt_cosine * v.z - own.tilt_sine * y};
}

/// Rz(-angle).
Triple Frames::turn(const Number& sine, const Number& cosine, const Triple& v) const {
  return {cosine * v.x + sine * v.y, cosine * v.y - sine * v.x, v.z};
}

Triple Frames::to_body(int i, const Triple& in_parent) const {
  if (body(i).motion != Motion::kRotation) return in_parent;
  return turn(sine(i), cosine(i), tilted(i, in_parent));
}

Triple Frames::from_head(int i, const Triple& tilted_in_head) const {
  const auto at = static_cast<std::size_t>(i);
  return turn(sum_sine_[at], sum_cosine_[at], tilted_in_head);
}

Triple Frames::to_parent(int i, const Triple& in_body) const {
  const ReducedBody& own = body(i);
  if (own.motion != Motion::kRotation) return in_body;
  const Triple v = turn(-sine(i), cosine(i), in_body);
  const Number y = own.tilt_cosine * v.y - own.tilt_sine * v.z;
  const Number z = own.tilt_sine * v.y + own.tilt_cosine * v.z;
  return {own.turn_cosine * v.x - own.turn_sine * y, own.turn_sine * v.x + own.turn_cosine * y, z};
}

/// R(q)' g of a quaternion of any length: g + 2 / |q|^2 (w g x r + r x (r x g)), r = (x, y, z).
Triple Frames::gravity_of_base() {
  const int first = body(0).coordinate + 3;
  const Triple r{graph_.input(Array::kQ, first), graph_.input(Array::kQ, first + 1),
                 graph_.input(Array::kQ, first + 2)};
  const Number w = graph_.input(Array::kQ, first + 3);
  const Triple g = constant(tree_.gravity);
  const Number twice = 2.0 * reciprocal(dot(r, r) + w * w);
  return g + twice * (w * cross(g, r) + cross(r, cross(r, g)));
}

void Frames::name(const Triple& triple, const char* what, int i) {
  const std::string& label = body(i).label;
  graph_.name(triple.x, fmt::format("{}{}x", what, label));
  graph_.name(triple.y, fmt::format("{}{}y", what, label));
  graph_.name(triple.z, fmt::format("{}{}z", what, label));
}

}  // namespace geodesic::tools::compile
