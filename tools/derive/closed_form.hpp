// The closed forms of a tree: metric, potential, Christoffel symbols, gravity. GiNaC
// differentiates, polynomial.hpp keeps everything in normal form; printing is elsewhere.
#pragma once

#include <functional>
#include <stdexcept>
#include <string>
#include <vector>

#include "tools/derive/symbolic_tree.hpp"

namespace geodesic::tools::derive {

/// How far a derivation is. Called often; may throw to end it.
struct Progress {
  std::string stage;         ///< "M", "christoffel", ...
  double part = 0.0;         ///< of the stage, 0 to 1
  std::size_t terms = 0;     ///< found so far
  std::size_t expected = 0;  ///< terms that all that was asked for will have, an estimate
};
using OnProgress = std::function<void(const Progress&)>;

/// The answer would be longer than the limit.
class TooLong : public std::runtime_error {
 public:
  using std::runtime_error::runtime_error;
};

struct Wanted {
  bool christoffel = true;
  bool second_kind = false;
  /// Most terms of sines and cosines in all; beyond, TooLong is thrown, as soon as it is foreseen.
  std::size_t limit = 0;
};

struct ClosedForm {
  int n = 0;
  Symbols symbols;
  std::vector<std::vector<Polynomial>> metric;  ///< n x n, [kg·m², kg·m, kg]
  Polynomial potential;                         ///< V(q) [J]
  std::vector<Polynomial> gravity;              ///< dV/dq [N·m, N]
  /// [i][j][k], (dM_ij/dq_k + dM_ik/dq_j - dM_jk/dq_i) / 2; empty if not wanted.
  std::vector<std::vector<std::vector<Polynomial>>> christoffel;
  /// The second kind is numerator[i][j][k] / determinant; empty if not wanted.
  std::vector<std::vector<std::vector<Polynomial>>> second_kind;
  Polynomial determinant;  ///< of the metric, if the second kind is wanted
};

/// @throws TooLong, or what `on_progress` throws.
ClosedForm derive(SymbolicTree tree, const Wanted& wanted, const OnProgress& on_progress);

/// Terms of all that was derived.
std::size_t count_terms(const ClosedForm& form);

}  // namespace geodesic::tools::derive
