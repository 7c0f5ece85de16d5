// The abstract memory to the whole one and back, and the flags it is explored with.
#include "tests/control/safety/explorer_node.hpp"

namespace geodesic::control::testing {
namespace {

using enum SupervisorState;

/// Beyond it, no option tells ages apart.
int most_age(SupervisorState state) {
  return state == kConnecting ? 4 : state == kStopping || state == kLowering ? 3 : 2;
}

Flags flags_of(unsigned requests, unsigned present) {
  Flags flags;
  flags.law_requested = (requests & 1U) != 0;
  flags.stop_requested = (requests & 2U) != 0;
  flags.overran = (requests & 4U) != 0;
  flags.present[at(Fault::kVelocityLimit)] = (present & 1U) != 0 ? bit(0) : 0;
  flags.present[at(Fault::kEncoderJump)] = (present & 2U) != 0 ? bit(0) : 0;
  flags.present[at(Fault::kContact)] = (present & 4U) != 0 ? bit(0) : 0;
  return flags;
}

void add_condition(Flags& flags, std::size_t joint, unsigned condition) {
  const std::array<BitSet*, 4> sets{&flags.disabled, &flags.enabled, &flags.error, &flags.refused};
  if (condition < sets.size()) {
    *sets[condition] |= bit(joint);
  }
}

}  // namespace

SupervisorMemory concrete(const Node& node) {
  SupervisorMemory memory;
  memory.state = static_cast<SupervisorState>(node.state);
  memory.start_done = node.start_done != 0;
  memory.drives_only = node.drives_only != 0;
  memory.overruns = node.overruns;
  memory.since_ns = kNow - node.age * kStepNs;
  memory.rest_since_ns = kNow - node.rest * kStepNs;
  memory.authority = node.authority / 8.0;
  memory.lower_from = node.lower_from / 4.0;
  memory.ramp_s = 1.0;
  for (std::size_t i = 0; i < 2; ++i) {
    memory.silent[i] = node.silent[i];
    memory.answers[i] = node.answers[i];
  }
  const auto latch = [&memory](Fault fault, BitSet set) { memory.latched[at(fault)] = set; };
  switch (static_cast<Action>(node.worst)) {
    case Action::kDamp:
      latch(Fault::kContact, bit(0));
      break;
    case Action::kControlledStop:
      latch(Fault::kVelocityLimit, bit(0));
      break;
    case Action::kDriveDamping:
      latch(Fault::kEncoderJump, bit(0));
      break;
    case Action::kTorqueOff:
      latch(Fault::kDriveRefused, bit(0));
      break;
    default:
      break;
  }
  latch(Fault::kDriveError, node.failed);
  memory.seen_ns[at(Fault::kContact)] = kNow - node.damp_age * kStepNs;
  memory.reported = memory.latched;
  return memory;
}

/// The supervisor's part of the node.
Node abstract(const SupervisorOptions& options, const SupervisorMemory& memory,
              std::int64_t now_ns) {
  Node node;
  node.state = static_cast<std::uint8_t>(memory.state);
  node.start_done = memory.start_done ? 1 : 0;
  node.authority = capped(memory.authority * 8.0 + 0.5, 15);
  if (memory.state == kOff || memory.state == kFault) {
    return node;  // a start forgets all else
  }
  // What a state does not read, or forgets on the way out of it, is not told apart.
  const SupervisorState state = memory.state;
  const bool active = state == kActive;
  const bool lowering = state == kLowering;
  const bool rests = state == kReady || state == kStopping || (lowering && !memory.drives_only);
  node.drives_only = memory.drives_only ? 1 : 0;
  node.overruns = lowering ? 0 : capped(memory.overruns, options.safety.overrun_cycles);
  node.age = state == kReady ? 0 : capped((now_ns - memory.since_ns) / kStepNs, most_age(state));
  node.rest = rests ? capped((now_ns - memory.rest_since_ns) / kStepNs, 2) : 0;
  node.lower_from = lowering ? capped(memory.lower_from * 4.0 + 0.5, 7) : 0;
  for (std::size_t i = 0; i < 2; ++i) {
    const bool is = has(options.joints, i);
    node.silent[i] = is ? capped(memory.silent[i], options.safety.silent_cycles) : 0;
    node.answers[i] = is && state == kConnecting ? capped(memory.answers[i], 3) : 3;
  }
  const Action worst = worst_action(options, memory);
  const bool counts = worst >= Action::kControlledStop || (active && worst == Action::kDamp);
  node.worst = counts ? static_cast<std::uint8_t>(worst) : 0;
  node.failed = static_cast<std::uint8_t>(failed_drives(memory) & options.joints);
  if (active && worst == Action::kDamp) {
    node.damp_age = capped((now_ns - memory.seen_ns[at(Fault::kContact)]) / kStepNs, 3);
  }
  return node;
}

/// One joint: every combination there is, with every subset of three faults that stand for their
/// actions; and every other fault of the table by itself. `moving` and `unrested` go together: a
/// state reads one of them alone.
std::vector<Flags> flags_of_one_joint() {
  std::vector<Flags> all;
  for (unsigned i = 0; i < 8U * 8 * 2 * 5 * 4; ++i) {
    unsigned rest = i;
    const auto take = [&rest](unsigned of) {
      const unsigned value = rest % of;
      rest /= of;
      return value;
    };
    const unsigned requests = take(8);
    Flags flags = flags_of(requests, take(8));
    flags.fresh = take(2);
    add_condition(flags, 0, take(5));
    flags.moving = take(2);
    flags.unrested = flags.moving;
    flags.outside = take(2);
    all.push_back(flags);
  }
  for (std::size_t fault = 0; fault < kFaults; ++fault) {
    for (unsigned i = 0; i < 4U * 2; ++i) {
      Flags flags = flags_of(i % 4, 0);
      flags.fresh = 1;
      add_condition(flags, 0, i / 4);
      flags.present[fault] = 1;
      all.push_back(flags);
    }
  }
  return all;
}

/// Two joints, each good for `disabled` or for `enabled`, or wrong in one way; in either order.
std::vector<Flags> flags_of_two_joints() {
  std::vector<Flags> all;
  constexpr unsigned kLetters = 6;
  const auto add = [](Flags& flags, std::size_t joint, unsigned letter) {
    flags.fresh |= letter == 2 ? 0 : bit(joint);
    add_condition(flags, joint, letter == 0 ? 0 : letter == 5 ? 2 : 1);
    flags.moving |= letter == 3 ? bit(joint) : 0;
    flags.unrested |= letter == 3 ? bit(joint) : 0;
    flags.outside |= letter == 4 ? bit(joint) : 0;
  };
  for (unsigned i = 0; i < 4 * 2 * kLetters * kLetters; ++i) {
    Flags flags = flags_of(i % 4, i / 4 % 2);
    add(flags, 0, i / 8 % kLetters);
    add(flags, 1, i / 8 / kLetters);
    all.push_back(flags);
  }
  return all;
}

}  // namespace geodesic::control::testing
