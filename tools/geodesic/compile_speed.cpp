// Interleaved rounds; see compile_speed.hpp. tests/bench compares with other libraries.
#include "tools/geodesic/compile_speed.hpp"

#include <algorithm>
#include <chrono>
#include <limits>
#include <random>
#include <vector>

#include "control/mechanism/dynamics.hpp"

namespace geodesic::tools {
namespace {

constexpr std::size_t kStates = 32;
constexpr int kRounds = 60;
constexpr int kCalls = 320;

template <class Function>
void take(double& best, const Function& function) {
  const auto start = std::chrono::steady_clock::now();
  for (int i = 0; i < kCalls; ++i) function(static_cast<std::size_t>(i) % kStates);
  const std::chrono::duration<double, std::nano> spent = std::chrono::steady_clock::now() - start;
  best = std::min(best, spent.count() / kCalls);
}

}  // namespace

CompiledSpeed measure(const geodesic_compiled& model, const control::Mechanism& mechanism) {
  std::mt19937 dice(7);
  std::uniform_real_distribution<double> uniform(-1.5, 1.5);
  std::vector<Eigen::VectorXd> q(kStates);
  std::vector<Eigen::VectorXd> v(kStates);
  for (std::size_t i = 0; i < kStates; ++i) {
    q[i].resize(mechanism.nq());
    v[i].resize(mechanism.dof());
    for (double& x : q[i]) x = uniform(dice);
    for (double& x : v[i]) x = uniform(dice);
  }
  control::Workspace workspace(mechanism);
  Eigen::VectorXd out = Eigen::VectorXd::Zero(mechanism.dof());
  Eigen::VectorXd last = Eigen::VectorXd::Zero(mechanism.dof());
  Eigen::MatrixXd matrix(mechanism.dof(), mechanism.dof());
  Eigen::VectorXd moved(mechanism.nq());
  constexpr double kNever = std::numeric_limits<double>::infinity();
  CompiledSpeed speed{{kNever, kNever}, {kNever, kNever}, {kNever, kNever}, kNever};
  for (int round = 0; round < kRounds; ++round) {
    take(speed.bias.compiled_ns,
         [&](std::size_t i) { model.bias(q[i].data(), v[i].data(), out.data()); });
    take(speed.bias.plain_ns,
         [&](std::size_t i) { control::bias(mechanism, workspace, q[i], v[i]); });
    take(speed.gravity.compiled_ns, [&](std::size_t i) { model.gravity(q[i].data(), out.data()); });
    take(speed.gravity.plain_ns,
         [&](std::size_t i) { control::gravity(mechanism, workspace, q[i]); });
    take(speed.metric.compiled_ns,
         [&](std::size_t i) { model.metric(q[i].data(), matrix.data()); });
    take(speed.metric.plain_ns,
         [&](std::size_t i) { control::metric(mechanism, workspace, q[i]); });
    take(speed.bias_latency_ns, [&](std::size_t i) {
      // Too small to change a figure, but no compiler and no processor can know.
      moved = q[i];
      moved.tail(mechanism.dof()) += 1e-20 * last;
      model.bias(moved.data(), v[i].data(), last.data());
    });
  }
  return speed;
}

}  // namespace geodesic::tools
