// The search.
#include "tests/control/safety/explorer.hpp"

#include <algorithm>
#include <random>
#include <unordered_map>

#include "tests/control/safety/explorer_node.hpp"

namespace geodesic::control::testing {
namespace {

using enum SupervisorState;

constexpr std::size_t kMostViolations = 5;

/// States from which none of `ends` can be reached.
std::size_t stuck(const std::vector<Node>& nodes, const std::vector<std::vector<std::size_t>>& next,
                  const std::vector<SupervisorState>& ends) {
  std::vector<std::vector<std::size_t>> back(nodes.size());
  std::vector<std::size_t> queue;
  std::vector<char> seen(nodes.size(), 0);
  for (std::size_t i = 0; i < nodes.size(); ++i) {
    for (const std::size_t to : next[i]) {
      back[to].push_back(i);
    }
    if (std::find(ends.begin(), ends.end(), static_cast<SupervisorState>(nodes[i].state)) !=
        ends.end()) {
      seen[i] = 1;
      queue.push_back(i);
    }
  }
  for (std::size_t k = 0; k < queue.size(); ++k) {
    for (const std::size_t i : back[queue[k]]) {
      if (seen[i] == 0) {
        seen[i] = 1;
        queue.push_back(i);
      }
    }
  }
  return nodes.size() - queue.size();
}

}  // namespace

SupervisorOptions explored_options(std::size_t joints) {
  SupervisorOptions options;
  options.joints = first(joints);
  options.buses = first(1);
  options.safety.silent_cycles = 2;
  options.safety.overrun_cycles = 2;
  options.safety.start_ramp_s = 1.0;
  options.safety.stop_rest_s = 1.0;
  options.safety.stop_timeout_s = 1.5;
  options.safety.lower_s = 1.0;
  options.safety.settle_timeout_s = 0.5;
  options.safety.connect_timeout_s = 2.0;
  options.safety.enable_timeout_s = 1.0;
  options.safety.contact = ContactReaction::kDamp;
  return options;
}

Exploration explore(Supervise supervise, std::size_t joints, std::size_t every) {
  const SupervisorOptions options = explored_options(joints);
  std::vector<Flags> alphabet;
  const std::vector<Flags> whole = joints == 1 ? flags_of_one_joint() : flags_of_two_joints();
  for (std::size_t i = 0; i < whole.size(); i += every) {
    alphabet.push_back(whole[i]);
  }
  Exploration result;
  std::vector<Node> nodes(1);
  std::vector<std::vector<std::size_t>> next;
  std::unordered_map<std::uint64_t, std::size_t> index{{nodes[0].key(), 0}};
  for (std::size_t i = 0; i < nodes.size(); ++i) {
    const Node before = nodes[i];
    const SupervisorMemory memory = concrete(before);
    std::vector<std::size_t>& successors = next.emplace_back();
    for (const Flags& flags : alphabet) {
      const SupervisorDecision decision = supervise(options, memory, flags, kNow + kStepNs);
      Node after = abstract(options, decision.memory, kNow + kStepNs);
      count(options, before, after, flags);
      ++result.transitions;
      if (const char* what = broken(options, before, after, flags, decision)) {
        result.violations.push_back(std::string(to_string(SupervisorState{before.state})) + " -> " +
                                    to_string(SupervisorState{after.state}) + ": " + what);
        if (result.violations.size() >= kMostViolations) {
          result.states = nodes.size();
          return result;
        }
        continue;
      }
      const auto [known, is_new] = index.try_emplace(after.key(), nodes.size());
      if (is_new) {
        nodes.push_back(after);
      }
      if (successors.empty() || successors.back() != known->second) {
        successors.push_back(known->second);
      }
    }
    std::sort(successors.begin(), successors.end());
    successors.erase(std::unique(successors.begin(), successors.end()), successors.end());
  }
  result.states = nodes.size();
  if (stuck(nodes, next, {kOff, kFault}) != 0) {
    result.violations.emplace_back("a state from which neither off nor fault can be reached");
  }
  if (stuck(nodes, next, {kActive}) != 0) {
    result.violations.emplace_back("a state from which active can never be reached again");
  }
  return result;
}

std::string abstraction_holds(unsigned seed, int steps) {
  const SupervisorOptions options = explored_options(2);
  const std::vector<Flags> alphabet = flags_of_two_joints();
  std::mt19937 random(seed);
  SupervisorMemory memory;
  std::int64_t now_ns = 2 * kNow;
  for (int i = 0; i < steps; ++i) {
    Flags flags = alphabet[random() % alphabet.size()];
    if (random() % 4 != 0) {  // mostly a robot that works, so that every state is reached
      const bool enable = memory.state == kEnabling || makes_torque(memory.state);
      flags = Flags{};
      flags.fresh = options.joints;
      (enable ? flags.enabled : flags.disabled) = options.joints;
      flags.law_requested = random() % 2 == 0;
    }
    if (random() % 16 == 0) {
      flags.present[random() % kFaults] = options.joints;
    }
    now_ns += kStepNs;
    const Node before = abstract(options, memory, now_ns - kStepNs);
    memory = supervise(options, memory, flags, now_ns).memory;
    const Node whole = abstract(options, memory, now_ns);
    const Node small =
        abstract(options, supervise(options, concrete(before), flags, kNow + kStepNs).memory,
                 kNow + kStepNs);
    if (whole.key() != small.key()) {
      return "step " + std::to_string(i) + " from " + to_string(SupervisorState{before.state});
    }
  }
  return {};
}

}  // namespace geodesic::control::testing
