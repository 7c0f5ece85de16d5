// Interning and nesting; see the header.
#include "tools/derive/shared_graph.hpp"

#include <algorithm>
#include <utility>

namespace geodesic::tools::derive {

using Kind = SharedGraph::Content::Kind;

Node SharedGraph::intern(Content content) {
  const auto [place, fresh] = known_.try_emplace(content, static_cast<Node>(nodes_.size()));
  if (fresh) nodes_.push_back(std::move(content));
  return place->second;
}

Node SharedGraph::number(double value) {
  return intern({Kind::kNumber, value, "", {}});
}

Node SharedGraph::leaf(const std::string& text) {
  return intern({Kind::kLeaf, 0.0, text, {}});
}

Node SharedGraph::sum(std::vector<Node> parts) {
  std::erase(parts, number(0.0));
  if (parts.empty()) return number(0.0);
  if (parts.size() == 1) return parts.front();
  std::sort(parts.begin(), parts.end());
  return intern({Kind::kSum, 0.0, "", std::move(parts)});
}

Node SharedGraph::product(std::vector<Node> parts) {
  double value = 1.0;
  std::vector<Node> rest;
  for (const Node part : parts) {
    const Content& content = (*this)[part];
    if (content.kind == Kind::kNumber) {
      value *= content.value;
    } else if (content.kind == Kind::kProduct) {
      for (const Node inner : content.parts) {
        if ((*this)[inner].kind == Kind::kNumber) {
          value *= (*this)[inner].value;
        } else {
          rest.push_back(inner);
        }
      }
    } else {
      rest.push_back(part);
    }
  }
  if (value == 0.0 || rest.empty()) return number(value);
  std::sort(rest.begin(), rest.end());
  if (value != 1.0) rest.insert(rest.begin(), number(value));
  if (rest.size() == 1) return rest.front();
  return intern({Kind::kProduct, 0.0, "", std::move(rest)});
}

Node SharedGraph::nested(std::vector<FlatTerm> terms) {
  std::vector<Node> sum_parts;
  while (!terms.empty()) {
    std::map<Node, int> count;
    for (const FlatTerm& term : terms) {
      Node last = -1;
      for (const Node leaf : term.leaves) {
        if (leaf != last) ++count[leaf];
        last = leaf;
      }
    }
    const auto most =
        std::max_element(count.begin(), count.end(),
                         [](const auto& a, const auto& b) { return a.second < b.second; });
    if (most == count.end() || most->second < 2) break;
    const Node shared = most->first;
    std::vector<FlatTerm> with;
    std::vector<FlatTerm> without;
    for (FlatTerm& term : terms) {
      const auto at = std::find(term.leaves.begin(), term.leaves.end(), shared);
      if (at == term.leaves.end()) {
        without.push_back(std::move(term));
        continue;
      }
      term.leaves.erase(at);
      with.push_back(std::move(term));
    }
    sum_parts.push_back(product({shared, nested(std::move(with))}));
    terms = std::move(without);
  }
  for (const FlatTerm& term : terms) {
    std::vector<Node> factors = term.leaves;
    factors.push_back(number(term.value));
    sum_parts.push_back(product(factors));
  }
  return sum(sum_parts);
}

std::vector<int> SharedGraph::uses(const std::vector<Node>& outputs) const {
  std::vector<int> count(nodes_.size());
  for (const Node output : outputs) ++count[static_cast<std::size_t>(output)];
  // Parts have lower numbers than what they are parts of.
  for (std::size_t i = nodes_.size(); i-- > 0;) {
    if (count[i] == 0) continue;
    for (const Node part : nodes_[i].parts) ++count[static_cast<std::size_t>(part)];
  }
  return count;
}

}  // namespace geodesic::tools::derive
