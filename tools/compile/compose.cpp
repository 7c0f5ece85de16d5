// Coordinate descent over the choices of each body; see compose.hpp.
#include "tools/compile/compose.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <numeric>
#include <stdexcept>

#include "tools/compile/fingerprint.hpp"

namespace geodesic::tools::compile {
namespace {

using Compose = Program (*)(const ReducedTree&);
using Choices = std::vector<Choice>;

/// Above as many bodies one round of trials has to do: a trial costs a whole graph.
constexpr std::size_t kLargeTree = 12;

/// Every way to spend one body's freedom that differs from `now` in one thing.
std::vector<Choice> neighbours(const Choice& now) {
  std::vector<Choice> list;
  using Slide = Choice::Slide;
  using Turn = Choice::Turn;
  for (const Slide slide : {Slide::kOwn, Slide::kChild, Slide::kMoment, Slide::kOther}) {
    list.push_back(now);
    list.back().slide = slide;
  }
  for (const Turn turn : {Turn::kNone, Turn::kFirstMoment, Turn::kSecondMoment}) {
    list.push_back(now);
    list.back().turn = turn;
  }
  for (int bit = 0; bit < 3; ++bit) {
    list.push_back(now);
    list.back().moment_form ^= 1 << bit;
  }
  list.push_back(now);
  list.back().tree_form ^= 1;
  list.push_back(now);
  list.back().sums = !now.sums;
  std::erase(list, now);
  return list;
}

class Search {
 public:
  Search(const control::Mechanism& mechanism, double snap, Compose function)
      : mechanism_(mechanism), snap_(snap), function_(function) {
    choices_.resize(mechanism.bodies().size());
    best_ = price(choices_);
  }

  Program run(const std::function<void(double)>& progress) {
    const std::size_t n = choices_.size();
    const int rounds = n > kLargeTree ? 1 : 3;
    for (int round = 0; round < rounds; ++round) {
      bool better = false;
      for (std::size_t i = 0; i < n; ++i) {
        if (progress) {
          progress((round + static_cast<double>(i) / static_cast<double>(n)) / rounds);
        }
        // From the tip: what a body slides to depends on its children.
        better |= improve(n - 1 - i);
      }
      if (!better) break;
    }
    return function_(reduce(mechanism_, choices_, snap_));
  }

 private:
  /// Instructions first; of equals, fewer operations, then the shorter chain.
  double price(const Choices& choices) const {
    const Cost cost = function_(reduce(mechanism_, choices, snap_)).cost();
    const int more_vectors = cost.angles > 8 ? (cost.angles - 1) / 8 : 0;
    return cost.instructions() + 0.1 * (cost.multiplications + cost.additions) + 0.01 * cost.depth +
           20.0 * more_vectors;
  }

  bool improve(std::size_t i) {
    bool better = false;
    for (const Choice& choice : neighbours(choices_[i])) {
      Choices tried = choices_;
      tried[i] = choice;
      const double found = price(tried);
      if (found < best_ - 1e-9) {
        best_ = found;
        choices_ = tried;
        better = true;
      }
    }
    return better;
  }

  const control::Mechanism& mechanism_;
  double snap_;
  Compose function_;
  Choices choices_;
  double best_ = 0.0;
};

/// Parts of the tree that share neither a body nor a degree of freedom, numbered.
void find_arms(const control::Mechanism& mechanism, Emission& emission) {
  const auto& bodies = mechanism.bodies();
  std::vector<int> arm(bodies.size());
  std::iota(arm.begin(), arm.end(), 0);
  const auto join = [&](int from, int to) {
    for (int& one : arm) one = one == from ? to : one;
  };
  for (std::size_t i = 0; i < bodies.size(); ++i) {
    if (bodies[i].parent >= 0) join(arm[i], arm[static_cast<std::size_t>(bodies[i].parent)]);
    for (std::size_t j = 0; j < i; ++j) {
      if (bodies[j].dof == bodies[i].dof) join(arm[i], arm[j]);
    }
  }
  std::vector<int> number(bodies.size(), -1);
  int found = 0;
  emission.arm_of_q.assign(static_cast<std::size_t>(mechanism.nq()), 0);
  emission.arm_of_v.assign(static_cast<std::size_t>(mechanism.dof()), 0);
  for (std::size_t i = 0; i < bodies.size(); ++i) {
    int& mine = number[static_cast<std::size_t>(arm[i])];
    if (mine < 0) mine = found++;
    const bool free = bodies[i].motion == control::Motion::kFree;
    std::fill_n(emission.arm_of_q.begin() + bodies[i].coordinate, free ? 7 : 1, mine);
    std::fill_n(emission.arm_of_v.begin() + bodies[i].dof, free ? 6 : 1, mine);
  }
}

}  // namespace

Emission compose(const control::Mechanism& mechanism, double snap, const Progress& progress) {
  if (const std::string reason = uncompilable(mechanism); !reason.empty()) {
    throw std::invalid_argument(reason);
  }
  Emission emission;
  emission.robot = mechanism.name();
  emission.fingerprint = fingerprint(mechanism);
  emission.generator = "geodesic compile " GEODESIC_VERSION;
  emission.joint_names = mechanism.joint_names();
  emission.nq = mechanism.nq();
  emission.nv = mechanism.dof();
  find_arms(mechanism, emission);
  const std::pair<const char*, Compose> functions[] = {
      {"bias", bias_program},
      {"gravity", gravity_program},
      {"metric", metric_program},
      {"inverse dynamics", inverse_dynamics_program}};
  for (const auto& [name, function] : functions) {
    Search search(mechanism, snap, function);
    emission.programs.push_back(search.run([&, what = name](double part) {
      if (progress) progress(fmt::format("fewest operations for {}", what), part);
    }));
  }
  return emission;
}

}  // namespace geodesic::tools::compile
