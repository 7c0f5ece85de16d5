// A thousand states of both; see agreement.hpp.
#include "tools/compile/agreement.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <limits>
#include <numbers>
#include <random>

#include "control/mechanism/gravity.hpp"
#include "control/mechanism/metric.hpp"
#include "control/mechanism/newton_euler.hpp"
#include "control/mechanism/workspace.hpp"
#include "tools/compile/fingerprint.hpp"

namespace geodesic::tools::compile {
namespace {

using Eigen::VectorXd;

constexpr double kNan = std::numeric_limits<double>::quiet_NaN();

/// Uniform, and the same from every standard library.
class Dice {
 public:
  double operator()(double low, double high) {
    return low + (high - low) * (static_cast<double>(engine_() >> 11) * 0x1p-53);
  }

 private:
  std::mt19937_64 engine_{20'260'401};
};

struct State {
  VectorXd q;
  VectorXd v;
  VectorXd a;
};

class States {
 public:
  explicit States(const control::Mechanism& m) : m_(m) {}

  State neutral() const {
    State state{VectorXd::Zero(m_.nq()), VectorXd::Zero(m_.dof()), VectorXd::Zero(m_.dof())};
    if (m_.floating()) state.q[6] = 1.0;
    return state;
  }

  /// One joint by a quarter turn (or a metre), or one speed of 1.
  State aligned(int number) const {
    State state = neutral();
    const int quarters = 3 * (m_.nq() - m_.first_joint_q());
    if (number < quarters) {
      state.q[m_.first_joint_q() + number / 3] = (number % 3 + 1) * 0.5 * std::numbers::pi;
      state.v.setOnes();
    } else {
      state.v[(number - quarters) % m_.dof()] = 1.0;
      state.a[(number - quarters) % m_.dof()] = 1.0;
    }
    return state;
  }
  int aligned_count() const { return 3 * (m_.nq() - m_.first_joint_q()) + m_.dof(); }

  State random(Dice& dice) const {
    State state = neutral();
    for (double& v : state.v) v = dice(-3.0, 3.0);
    for (double& a : state.a) a = dice(-10.0, 10.0);
    for (const control::Factor& factor : m_.factors()) {
      for (int k = 0; k < factor.nq; ++k) state.q[factor.q + k] = position(factor, dice);
      if (factor.nq > factor.nv) state.q.segment<4>(factor.q + factor.nq - 4).normalize();
    }
    return state;
  }

 private:
  double position(const control::Factor& factor, Dice& dice) const {
    constexpr double kTwoTurns = 4.0 * std::numbers::pi;
    if (factor.nv > 1) return dice(-1.0, 1.0);
    const auto joint = m_.find_joint(factor.name);
    const control::JointLimits limits =
        joint ? m_.joint_limits()[static_cast<std::size_t>(*joint)] : control::JointLimits{};
    if (!std::isfinite(limits.lower) || !std::isfinite(limits.upper)) {
      return factor.kind == control::JointKind::kPrismatic ? dice(-1.0, 1.0)
                                                           : dice(-kTwoTurns, kTwoTurns);
    }
    const double more = 0.2 * (limits.upper - limits.lower) + 0.01;
    return dice(limits.lower - more, limits.upper + more);
  }

  const control::Mechanism& m_;
};

constexpr std::array<const char*, 4> kFunctions = {"bias", "gravity", "metric", "inverse_dynamics"};

class Comparison {
 public:
  Comparison(const geodesic_compiled& model, const control::Mechanism& mechanism)
      : model_(model),
        mechanism_(mechanism),
        workspace_(mechanism),
        vector_(mechanism.dof()),
        matrix_(mechanism.dof(), mechanism.dof()) {}

  void visit(const State& state) {
    states_.push_back(state);
    model_.bias(state.q.data(), state.v.data(), vector_.data());
    note(0, vector_, control::bias(mechanism_, workspace_, state.q, state.v));
    model_.gravity(state.q.data(), vector_.data());
    note(1, vector_, control::gravity(mechanism_, workspace_, state.q));
    model_.metric(state.q.data(), matrix_.data());
    note(2, matrix_, control::metric(mechanism_, workspace_, state.q));
    model_.inverse_dynamics(state.q.data(), state.v.data(), state.a.data(), vector_.data());
    note(3, vector_, control::inverse_dynamics(mechanism_, workspace_, state.q, state.v, state.a));
  }

  /// What is no number must not be hidden.
  void spoil(const State& state) {
    const auto look = [&](const char* what, int index) {
      if (vector_.allFinite() && hides_.empty()) {
        hides_ = fmt::format("{}[{}] = NaN left every torque finite", what, index);
      }
    };
    for (int i = 0; i < mechanism_.nq(); ++i) {
      State bad = state;
      bad.q[i] = kNan;
      model_.bias(bad.q.data(), bad.v.data(), vector_.data());
      look("bias: q", i);
      model_.gravity(bad.q.data(), vector_.data());
      look("gravity: q", i);
    }
    for (int i = 0; i < mechanism_.dof(); ++i) {
      State bad = state;
      bad.v[i] = kNan;
      model_.bias(bad.q.data(), bad.v.data(), vector_.data());
      look("bias: v", i);
    }
  }

  Agreement verdict() const {
    Agreement agreement;
    agreement.states = static_cast<int>(states_.size());
    agreement.hides = hides_;
    agreement.function = kFunctions[0];
    std::size_t at = 0;
    for (std::size_t f = 0; f < kFunctions.size(); ++f) {
      double largest = 0.0;
      for (const Found& found : found_[f]) largest = std::max(largest, found.size);
      for (std::size_t i = 0; i < found_[f].size(); ++i) {
        const Found& found = found_[f][i];
        const double scale = std::max(found.size, 1e-3 * largest);
        double error = found.difference == 0.0 ? 0.0 : found.difference / scale;
        if (!(error >= 0.0)) error = std::numeric_limits<double>::infinity();  // no number at all
        if (error > agreement.worst) {
          agreement.worst = error;
          agreement.function = kFunctions[f];
          at = i;
        }
      }
    }
    agreement.q = states_[at].q;
    agreement.v = states_[at].v;
    return agreement;
  }

 private:
  struct Found {
    double difference;
    double size;
  };

  template <class A, class B>
  void note(std::size_t function, const A& found, const B& expected) {
    double difference = 0.0;
    double size = 0.0;
    for (Eigen::Index i = 0; i < expected.size(); ++i) {
      const double apart = std::abs(found.data()[i] - expected.data()[i]);
      difference = apart <= difference ? difference : apart;  // keeps NaN
      if (!(apart == apart)) difference = kNan;
      size = std::max(size, std::abs(expected.data()[i]));
    }
    found_[function].push_back({difference, size});
  }

  const geodesic_compiled& model_;
  const control::Mechanism& mechanism_;
  control::Workspace workspace_;
  VectorXd vector_;
  Eigen::MatrixXd matrix_;
  std::vector<State> states_;
  std::array<std::vector<Found>, kFunctions.size()> found_;
  std::string hides_;
};

std::string list(const VectorXd& v) {
  std::string text;
  for (const double x : v) text += fmt::format("{}{:.17g}", text.empty() ? "" : ", ", x);
  return text;
}

}  // namespace

std::string to_string(const Agreement& agreement) {
  std::string text =
      fmt::format("{} differs by {:.3g} of its largest entry at q = [{}], v = [{}]",
                  agreement.function, agreement.worst, list(agreement.q), list(agreement.v));
  if (!agreement.hides.empty()) text.append("; ").append(agreement.hides);
  return text;
}

Agreement compare(const geodesic_compiled& model, const control::Mechanism& mechanism) {
  Comparison comparison(model, mechanism);
  const States states(mechanism);
  Dice dice;
  comparison.visit(states.neutral());
  int count = 1;
  for (int i = 0; i < states.aligned_count() && count < kAgreementStates; ++i, ++count) {
    comparison.visit(states.aligned(i));
  }
  for (; count < kAgreementStates; ++count) comparison.visit(states.random(dice));
  comparison.spoil(states.random(dice));
  return comparison.verdict();
}

VerifiedModel::VerifiedModel(const std::filesystem::path& file, const control::Mechanism& mechanism,
                             const std::filesystem::path& robot)
    : library_(file, fmt::format("build it anew: geodesic compile {}", robot.string())),
      fingerprint_(compile::fingerprint(mechanism)) {
  const geodesic_compiled& model = library_.model();
  const std::string rebuild = fmt::format("geodesic compile {}", robot.string());
  if (fingerprint_ != model.fingerprint || model.nq != mechanism.nq() ||
      model.nv != mechanism.dof()) {
    throw CompiledModelError(fmt::format(
        "compiled model {}: was built for another mechanism ({}, fingerprint {}; this robot's is "
        "{}): inertias, frames, gravity or rotor inertias have changed since; build it anew: {}",
        file.string(), model.robot, model.fingerprint, fingerprint_, rebuild));
  }
  agreement_ = compare(model, mechanism);
  if (!agreement_.holds()) {
    throw CompiledModelError(fmt::format(
        "compiled model {}: disagrees with the model read from the robot's file: {}; allowed are "
        "{:g} in {} states; build it anew: {}",
        file.string(), to_string(agreement_), kAgreement, agreement_.states, rebuild));
  }
  functions_ = {model.bias, model.gravity, model.metric};
}

const control::CompiledModel* VerifiedModel::functions_for(
    const control::Mechanism& mechanism) const {
  return compile::fingerprint(mechanism) == fingerprint_ ? &functions_ : nullptr;
}

}  // namespace geodesic::tools::compile
