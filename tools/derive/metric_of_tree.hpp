// The metric and the potential of a symbolic tree, by composite bodies. Derivatives are taken in
// closed_form.cpp.
#pragma once

#include <vector>

#include "tools/derive/closed_form.hpp"

namespace geodesic::tools::derive {

struct MetricOfTree {
  std::vector<std::vector<Polynomial>> metric;
  Polynomial potential;
};

/// T = v' M v / 2 and V of the tree; M is the Hessian of T in v. Each composite body is carried to
/// its parent by one joint's sine and cosine, so that no product is longer than its result.
/// Source: Featherstone 2008, table 6.2. @param limit  most terms, 0: none. @throws TooLong
MetricOfTree metric_of_tree(SymbolicTree& tree, std::size_t limit, const OnProgress& on_progress);

}  // namespace geodesic::tools::derive
