// Folding, sharing, and counting; see graph.hpp.
#include "tools/compile/graph.hpp"

#include <algorithm>
#include <bit>
#include <cmath>
#include <utility>

namespace geodesic::tools::compile {

const char* to_string(Array array) noexcept {
  switch (array) {
    case Array::kQ:
      return "q";
    case Array::kV:
      return "v";
    case Array::kA:
      return "a";
    case Array::kTau:
      break;
  }
  return "tau";
}

std::size_t Graph::KeyHash::operator()(const Key& key) const noexcept {
  std::uint64_t h = key.bits + 0x9e3779b97f4a7c15ULL * (static_cast<std::uint64_t>(key.op) + 1);
  for (const int part : {key.a, key.b}) {
    h ^= static_cast<std::uint64_t>(part) + 0x9e3779b97f4a7c15ULL + (h << 6) + (h >> 2);
    h *= 0xff51afd7ed558ccdULL;
    h ^= h >> 32;
  }
  return static_cast<std::size_t>(h);
}

int Graph::intern(const Node& node) {
  const Key key{node.op, node.a, node.b, std::bit_cast<std::uint64_t>(node.value)};
  const auto [found, is_new] = known_.try_emplace(key, static_cast<int>(nodes_.size()));
  if (is_new) {
    nodes_.push_back(node);
    names_.emplace_back();
  }
  return found->second;
}

/// The number without its sign.
int Graph::operand(const Number& number) {
  if (!number.is_constant()) return number.node();
  return intern({Op::kConstant, 0, 0, std::abs(number.value())});
}

bool Graph::split(int node, double& factor, int& other) const {
  const Node& n = nodes_[static_cast<std::size_t>(node)];
  if (n.op != Op::kMultiply) return false;
  const Node& first = nodes_[static_cast<std::size_t>(n.a)];
  if (first.op != Op::kConstant) return false;  // multiplication puts constants first
  factor = first.value;
  other = n.b;
  return true;
}

Number Graph::scaled(double factor, const Number& number) {
  double inner = 1.0;
  int other = number.node();
  if (split(number.node(), inner, other)) factor *= inner;
  bool negative = number.negative();
  if (factor < 0.0) {
    factor = -factor;
    negative = !negative;
  }
  if (factor == 0.0) return 0.0;
  if (factor == 1.0) return {*this, other, negative};
  const int constant = intern({Op::kConstant, 0, 0, factor});
  return {*this, intern({Op::kMultiply, constant, other, 0.0}), negative};
}

Number Graph::input(Array array, int index) {
  return {*this, intern({Op::kInput, static_cast<int>(array), index, 0.0}), false};
}

int Graph::angle(const Angle& angle) {
  const auto found = std::find(angles_.begin(), angles_.end(), angle);
  if (found != angles_.end()) return static_cast<int>(found - angles_.begin());
  angles_.push_back(angle);
  return static_cast<int>(angles_.size()) - 1;
}

Number Graph::sine(const Angle& of) {
  return {*this, intern({Op::kSine, angle(of), 0, 0.0}), false};
}

Number Graph::cosine(const Angle& of) {
  return {*this, intern({Op::kCosine, angle(of), 0, 0.0}), false};
}

void Graph::name(const Number& number, const std::string& what) {
  if (number.is_constant()) return;
  const Op op = nodes_[static_cast<std::size_t>(number.node())].op;
  if (op == Op::kConstant || op == Op::kInput) return;
  std::string& mine = names_[static_cast<std::size_t>(number.node())];
  if (mine.empty()) mine = what;
}

Number Number::operator-() const noexcept {
  return is_constant() ? Number(-value_) : Number(*graph_, node_, !negative_);
}

Number operator+(const Number& a, const Number& b) {
  if (a.is_constant() && b.is_constant()) return a.value() + b.value();
  if (a.is_zero()) return b;
  if (b.is_zero()) return a;
  Graph& graph = *(a.is_constant() ? b.graph() : a.graph());
  const auto sign_of = [](const Number& n) {
    return (n.is_constant() ? n.value() < 0.0 : n.negative()) ? -1.0 : 1.0;
  };
  int x = graph.operand(a);
  int y = graph.operand(b);
  double sx = sign_of(a);
  double sy = sign_of(b);
  // c1 * n + c2 * n = (c1 + c2) * n
  double fx = 1.0;
  double fy = 1.0;
  int nx = x;
  int ny = y;
  graph.split(x, fx, nx);
  graph.split(y, fy, ny);
  if (nx == ny) return graph.scaled(sx * fx + sy * fy, Number(graph, nx, false));
  if (x > y) {
    std::swap(x, y);
    std::swap(sx, sy);
  }
  const Op op = sx == sy ? Op::kAdd : Op::kSubtract;
  return {graph, graph.intern({op, x, y, 0.0}), sx < 0.0};
}

Number operator*(const Number& a, const Number& b) {
  if (a.is_constant() && b.is_constant()) return a.value() * b.value();
  if (a.is_zero() || b.is_zero()) return 0.0;  // what is not finite is caught at the entry
  if (a.is_constant()) return b.graph()->scaled(a.value(), b);
  if (b.is_constant()) return a.graph()->scaled(b.value(), a);
  Graph& graph = *a.graph();
  // Constants go to the front of a product, where they meet others.
  double fa = 1.0;
  double fb = 1.0;
  int x = a.node();
  int y = b.node();
  const bool from_a = graph.split(x, fa, x);
  const bool from_b = graph.split(y, fb, y);
  if (from_a && from_b) {
    const Number product = Number(graph, x, a.negative()) * Number(graph, y, b.negative());
    return graph.scaled(fa * fb, product);
  }
  x = a.node();
  y = b.node();
  if (x > y) std::swap(x, y);
  return {graph, graph.intern({Op::kMultiply, x, y, 0.0}), a.negative() != b.negative()};
}

Number reciprocal(const Number& a) {
  if (a.is_constant()) return 1.0 / a.value();
  Graph& graph = *a.graph();
  return {graph, graph.intern({Op::kReciprocal, a.node(), 0, 0.0}), a.negative()};
}

std::vector<bool> live_nodes(const Graph& graph, const std::vector<Number>& outputs) {
  std::vector<bool> live(graph.nodes().size(), false);
  for (const Number& output : outputs) {
    if (!output.is_constant()) live[static_cast<std::size_t>(output.node())] = true;
  }
  for (std::size_t i = live.size(); i-- > 0;) {
    const Node& node = graph.nodes()[i];
    if (!live[i] || node.op < Op::kAdd) continue;
    live[static_cast<std::size_t>(node.a)] = true;
    if (node.op != Op::kReciprocal) live[static_cast<std::size_t>(node.b)] = true;
  }
  return live;
}

Cost cost_of(const Graph& graph, const std::vector<Number>& outputs) {
  const std::vector<bool> live = live_nodes(graph, outputs);
  const std::vector<Node>& nodes = graph.nodes();
  std::vector<int> uses(nodes.size(), 0);
  std::vector<int> depth(nodes.size(), 0);
  for (const Number& output : outputs) {
    if (!output.is_constant()) ++uses[static_cast<std::size_t>(output.node())];
  }
  Cost cost;
  std::vector<bool> angle(graph.angles().size(), false);
  for (std::size_t i = 0; i < nodes.size(); ++i) {
    const Node& node = nodes[i];
    if (!live[i]) continue;
    if (node.op == Op::kSine || node.op == Op::kCosine) {
      cost.angles += angle[static_cast<std::size_t>(node.a)] ? 0 : 1;
      angle[static_cast<std::size_t>(node.a)] = true;
    }
    if (node.op < Op::kAdd) continue;
    cost.multiplications += node.op == Op::kMultiply ? 1 : 0;
    cost.additions += node.op == Op::kAdd || node.op == Op::kSubtract ? 1 : 0;
    cost.divisions += node.op == Op::kReciprocal ? 1 : 0;
    const auto a = static_cast<std::size_t>(node.a);
    const auto b = static_cast<std::size_t>(node.op == Op::kReciprocal ? node.a : node.b);
    ++uses[a];
    if (node.op != Op::kReciprocal) ++uses[b];
    depth[i] = 1 + std::max(depth[a], depth[b]);
    cost.depth = std::max(cost.depth, depth[i]);
  }
  for (std::size_t i = 0; i < nodes.size(); ++i) {
    const Node& node = nodes[i];
    if (!live[i] || (node.op != Op::kAdd && node.op != Op::kSubtract)) continue;
    const auto fuses = [&](int operand) {
      const auto at = static_cast<std::size_t>(operand);
      return nodes[at].op == Op::kMultiply && uses[at] == 1;
    };
    cost.fused += fuses(node.a) || fuses(node.b) ? 1 : 0;
  }
  return cost;
}

}  // namespace geodesic::tools::compile
