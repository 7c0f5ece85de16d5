// A hash-consed graph of arithmetic on doubles: what is equal is there once, constants are folded,
// zeros and ones vanish, signs are carried by the edges. Knows no mechanism and writes no code.
#pragma once

#include <cstdint>
#include <string>
#include <unordered_map>
#include <vector>

namespace geodesic::tools::compile {

class Graph;

enum class Op : std::uint8_t {
  kConstant,    ///< `value`, > 0
  kInput,       ///< element `b` of array `a` (Array)
  kSine,        ///< of angle `a`
  kCosine,      ///< of angle `a`
  kAdd,         ///< a + b
  kSubtract,    ///< a - b
  kMultiply,    ///< a * b
  kReciprocal,  ///< 1 / a
};

/// The arrays a compiled function is given.
enum class Array : std::uint8_t { kQ, kV, kA, kTau };
const char* to_string(Array array) noexcept;

/// One operation on what nodes before it have given. Operands carry no sign: signs are on Number.
struct Node {
  Op op = Op::kConstant;
  int a = 0;
  int b = 0;
  double value = 0.0;
};

/// A number in the making: a constant, or plus or minus a node. Arithmetic on it grows the graph.
class Number {
 public:
  Number(double constant = 0.0) noexcept : value_(constant) {}  // NOLINT: numbers are numbers
  Number(Graph& graph, int node, bool negative) noexcept
      : graph_(&graph), node_(node), negative_(negative) {}

  bool is_constant() const noexcept { return graph_ == nullptr; }
  bool is_zero() const noexcept { return is_constant() && value_ == 0.0; }
  double value() const noexcept { return value_; }
  Graph* graph() const noexcept { return graph_; }
  int node() const noexcept { return node_; }
  bool negative() const noexcept { return negative_; }

  Number operator-() const noexcept;
  friend Number operator+(const Number& a, const Number& b);
  friend Number operator-(const Number& a, const Number& b) { return a + (-b); }
  friend Number operator*(const Number& a, const Number& b);
  Number& operator+=(const Number& other) { return *this = *this + other; }
  Number& operator-=(const Number& other) { return *this = *this - other; }

 private:
  Graph* graph_ = nullptr;
  double value_ = 0.0;
  int node_ = -1;
  bool negative_ = false;
};

/// 1 / a. `a` is no constant zero.
Number reciprocal(const Number& a);

/// An angle [rad]: the sum of joint angles, each rate * q[coordinate] + offset.
struct JointAngle {
  int coordinate = 0;
  double rate = 1.0;
  double offset = 0.0;
  bool operator==(const JointAngle&) const = default;
};
using Angle = std::vector<JointAngle>;

class Graph {
 public:
  Graph() = default;
  Graph(const Graph&) = delete;
  Graph& operator=(const Graph&) = delete;

  Number input(Array array, int index);
  Number sine(const Angle& angle);
  Number cosine(const Angle& angle);
  /// Nodes a reader meets under this name; the first name given stays. Constants take none.
  void name(const Number& number, const std::string& what);

  const std::vector<Node>& nodes() const noexcept { return nodes_; }
  const std::vector<Angle>& angles() const noexcept { return angles_; }
  const std::string& name_of(int node) const { return names_[static_cast<std::size_t>(node)]; }

 private:
  friend class Number;
  friend Number operator+(const Number& a, const Number& b);
  friend Number operator*(const Number& a, const Number& b);
  friend Number reciprocal(const Number& a);

  struct Key {
    Op op;
    int a;
    int b;
    std::uint64_t bits;
    bool operator==(const Key&) const = default;
  };
  struct KeyHash {
    std::size_t operator()(const Key& key) const noexcept;
  };

  int intern(const Node& node);
  int operand(const Number& number);
  Number scaled(double factor, const Number& number);
  /// Where `node` is constant * other: both.
  bool split(int node, double& factor, int& other) const;
  int angle(const Angle& angle);

  std::vector<Node> nodes_;
  std::vector<std::string> names_;
  std::vector<Angle> angles_;
  std::unordered_map<Key, int, KeyHash> known_;
};

/// What is left of a graph when only these outputs count.
struct Cost {
  int multiplications = 0;
  int additions = 0;
  int divisions = 0;
  int fused = 0;  ///< multiplications that a fused multiply-add takes along
  int angles = 0;
  int depth = 0;  ///< longest chain of operations behind the sines
  int instructions() const noexcept { return multiplications + additions + divisions - fused; }
};

/// Whether each node counts for one of the outputs.
std::vector<bool> live_nodes(const Graph& graph, const std::vector<Number>& outputs);
Cost cost_of(const Graph& graph, const std::vector<Number>& outputs);

}  // namespace geodesic::tools::compile
