// Sums and products as a graph in which equal parts are one node, for code that computes nothing
// twice. Knows no programming language.
#pragma once

#include <map>
#include <string>
#include <vector>

namespace geodesic::tools::derive {

/// A number in a graph.
using Node = int;

/// value * product of leaves (a leaf as often as its exponent says).
struct FlatTerm {
  double value = 0.0;
  std::vector<Node> leaves;
};

class SharedGraph {
 public:
  struct Content {
    enum class Kind : std::uint8_t { kNumber, kLeaf, kSum, kProduct } kind = Kind::kNumber;
    double value = 0.0;
    std::string text;         ///< of a leaf: how it is written
    std::vector<Node> parts;  ///< of a sum or product
    // NOLINTNEXTLINE(modernize-use-nullptr): the compiler compares with 0
    auto operator<=>(const Content&) const = default;
  };

  Node number(double value);
  Node leaf(const std::string& text);
  Node sum(std::vector<Node> parts);
  Node product(std::vector<Node> parts);

  /// The sum of the terms, nested by Horner's rule: the leaf that most terms share is taken out,
  /// and so on inside and outside of its bracket.
  Node nested(std::vector<FlatTerm> terms);

  const Content& operator[](Node node) const { return nodes_[static_cast<std::size_t>(node)]; }
  int size() const noexcept { return static_cast<int>(nodes_.size()); }

  /// How often each node is needed to compute `outputs`, each node computed once.
  std::vector<int> uses(const std::vector<Node>& outputs) const;

 private:
  Node intern(Content content);
  std::vector<Content> nodes_;
  std::map<Content, Node> known_;
};

}  // namespace geodesic::tools::derive
