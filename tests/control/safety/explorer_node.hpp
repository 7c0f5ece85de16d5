// What the explorer's parts share: the abstract memory, its flags, and the checks on a transition.
#pragma once

#include <algorithm>
#include <array>
#include <cstdint>
#include <vector>

#include "control/safety/supervisor.hpp"
#include "tests/control/safety/explorer.hpp"

namespace geodesic::control::testing {

inline constexpr std::int64_t kNow = 1'000'000'000'000;
inline constexpr int kMostRest = 2;
inline constexpr int kMostDown = 12;

inline std::size_t at(Fault fault) {
  return static_cast<std::size_t>(fault);
}

/// What is told apart: the supervisor's own memory, and the checker's counters (g...), which know
/// nothing of it.
struct Node {
  std::uint8_t state = 0, start_done = 0, drives_only = 0, overruns = 0, age = 0, rest = 0;
  std::uint8_t authority = 0, lower_from = 0, worst = 0, failed = 0, damp_age = 0;
  std::array<std::uint8_t, 2> silent{}, answers{};
  std::array<std::uint8_t, 2> g_silent{}, g_answers{};
  std::uint8_t g_overruns = 0, g_age = 0, g_rest = 0, g_down = 0, g_fault = 0;

  std::uint64_t key() const {
    std::uint64_t key = 0;
    const auto add = [&key](unsigned value, int bits) { key = key << bits | value; };
    add(state, 3), add(start_done, 1), add(drives_only, 1), add(overruns, 2), add(age, 3);
    add(rest, 2), add(authority, 4), add(lower_from, 3), add(worst, 3), add(failed, 2);
    add(damp_age, 3);
    for (int i = 0; i < 2; ++i) {
      const auto k = static_cast<std::size_t>(i);
      add(silent[k], 2), add(answers[k], 2), add(g_silent[k], 2), add(g_answers[k], 2);
    }
    add(g_overruns, 2), add(g_age, 3), add(g_rest, 2), add(g_down, 4), add(g_fault, 1);
    return key;
  }
};

template <class T>
std::uint8_t capped(T value, int most) {
  return static_cast<std::uint8_t>(
      std::clamp<std::int64_t>(static_cast<std::int64_t>(value), 0, most));
}

/// A whole memory that stands for the node, at kNow.
SupervisorMemory concrete(const Node& node);
/// The supervisor's part of the node.
Node abstract(const SupervisorOptions& options, const SupervisorMemory& memory,
              std::int64_t now_ns);

std::vector<Flags> flags_of_one_joint();
std::vector<Flags> flags_of_two_joints();

/// The checker's counters after a step.
void count(const SupervisorOptions& options, const Node& before, Node& after, const Flags& flags);
/// What a transition breaks; null: nothing.
const char* broken(const SupervisorOptions& options, const Node& before, Node& after,
                   const Flags& flags, const SupervisorDecision& decision);

}  // namespace geodesic::control::testing
