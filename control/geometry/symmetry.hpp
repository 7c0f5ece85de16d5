// Noether's theorem for a Lagrangian of one's own: a symmetry given by its infinitesimal generator,
// and the momentum that it conserves. The mechanism has its own momentum maps.
#pragma once

#include "control/geometry/lagrangian.hpp"

namespace geodesic::control {

/// The momentum map J(q, v) = <dL/dv, xi(q)> of the symmetry that moves the system along xi; free
/// motion conserves it if invariance_defect() is zero, and d/dt J = defect + <tau, xi> always
/// (Noether 1918). Source: Bullo, Lewis 2005, chapter 5.
/// @param generator  vector field, callable: q (N of any scalar S) -> N of S
template <int N, class L, class Generator>
double momentum_map(const Lagrangian<N, L>& system, const Generator& generator,
                    const ChartVector<N>& q, const ChartVector<N>& v) {
  const ChartVector<N> xi = generator(q);
  return system.momentum(q, v).dot(xi);
}

/// Rate of L along the generator lifted to velocities, (xi(q), dxi(q) v): zero for a symmetry [W
/// per unit of the generator].
template <int N, class L, class Generator>
double invariance_defect(const Lagrangian<N, L>& system, const Generator& generator,
                         const ChartVector<N>& q, const ChartVector<N>& v) {
  const ChartVector<N> xi = generator(q);
  const Eigen::Matrix<Jet<>, N, 1> carried = generator(along(q, v));
  return system(along(q, xi), along(v, rates(carried))).rate;
}

}  // namespace geodesic::control
