// A mechanism's bodies with their constants as polynomials: numbers, or letters m1, l1, lc1, I1 of
// a textbook. Says which mechanisms have one chart; derives nothing.
#pragma once

#include <array>
#include <vector>

#include "control/mechanism/mechanism.hpp"
#include "tools/derive/exact.hpp"
#include "tools/derive/symbols.hpp"

namespace geodesic::tools::derive {

using Vector = std::array<Polynomial, 3>;
using Matrix = std::array<Vector, 3>;  ///< rows; symmetric ones hold all nine

/// One moving body in its own frame, whose z is the joint's axis.
struct SymbolicBody {
  int parent = control::kWorld;
  bool rotation = true;  ///< else a translation
  int dof = 0;
  long double ratio = 1.0L;
  Wave wave{};                  ///< of the joint's angle
  Polynomial shift;             ///< of the joint, if a translation [m]
  LongMatrix3 parent_rotation;  ///< parent from joint, at joint position 0
  Vector parent_translation;    ///< the same [m]
  Polynomial mass;
  Vector first_moment;  ///< [kg·m]
  Matrix inertia;       ///< about the frame's origin [kg·m²]
};

struct SymbolicTree {
  std::vector<SymbolicBody> bodies;  ///< parents first
  Vector gravity;                    ///< world [m/s²]
  std::vector<Polynomial> rotor;     ///< of each degree of freedom
  Symbols symbols;
};

/// @param letters  constants are letters; else numbers.
/// @throws std::invalid_argument naming the joint: where the base or a joint turns freely in space
///   (no chart covers its positions), or there are more joints that turn than kMaxAngles.
SymbolicTree symbolic_tree(const control::Mechanism& mechanism, bool letters);

}  // namespace geodesic::tools::derive
