// The classical fourth-order step, for the problems of the course; the product's own integrators
// stay on the manifold and are elsewhere.
#pragma once

#include <Eigen/Core>

namespace geodesic::control::course {

/// Position and velocity in a chart.
template <int N>
struct State {
  Eigen::Matrix<double, N, 1> q, v;
};

/// The state after `steps` steps of h [s] with acceleration(q, v). Error O(h^4): Kutta 1901.
template <int N, class Acceleration>
State<N> integrate(const Acceleration& acceleration, State<N> at, double h, int steps) {
  using Vector = Eigen::Matrix<double, N, 1>;
  for (int i = 0; i < steps; ++i) {
    const auto& [q, v] = at;
    const Vector a1 = acceleration(q, v);
    const Vector v2 = v + 0.5 * h * a1;
    const Vector a2 = acceleration(Vector(q + 0.5 * h * v), v2);
    const Vector v3 = v + 0.5 * h * a2;
    const Vector a3 = acceleration(Vector(q + 0.5 * h * v2), v3);
    const Vector v4 = v + h * a3;
    const Vector a4 = acceleration(Vector(q + h * v3), v4);
    at = {q + h / 6.0 * (v + 2.0 * v2 + 2.0 * v3 + v4),
          v + h / 6.0 * (a1 + 2.0 * a2 + 2.0 * a3 + a4)};
  }
  return at;
}

}  // namespace geodesic::control::course
