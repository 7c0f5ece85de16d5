// Fuzz target: the host side of every drive family against its simulated drive, with forged,
// spoilt and missing frames, restarts, power cycles and commands that are no numbers.
#include <algorithm>
#include <array>
#include <cmath>

#include "drivers/bus/bit_timing.hpp"
#include "drivers/families.hpp"
#include "rt/heap_counter.hpp"
#include "tests/drivers/family_benches.hpp"
#include "tests/fuzz/family_frames.hpp"
#include "tests/fuzz/fuzz.hpp"

namespace geodesic::fuzz {
namespace {

using control::DriveCondition;
using control::DriveMode;
using drivers::Drive;
using drivers::DriveCommand;
using drivers::DriveOptions;
using drivers::DriveState;
using drivers::Family;
using drivers::Frame;
using drivers::SimulatedDrive;

DriveOptions options_from(Input& input, const drivers::test::FamilyBench& bench) {
  DriveOptions options = bench.options;
  const DriveOptions usual = options;
  options.watchdog_ns = 5'000'000 + 5'000'000 * static_cast<std::int64_t>(input.below(20));
  const std::uint8_t flags = input.byte();
  options.clear_errors = (flags & 1U) != 0;
  options.error_diffusion = (flags & 2U) != 0;
  if (!bench.of().check(options).empty()) options.watchdog_ns = usual.watchdog_ns;
  return options;
}

/// A drive, its simulated counterpart, and what must hold between them at every step.
class Dialogue {
 public:
  Dialogue(const drivers::test::FamilyBench& bench, const DriveOptions& options)
      : Dialogue(bench.of(), options,
                 bench.always_on || bench.commands_enable ? 2.0 * bench.step_nm : -1.0) {}

  Dialogue(const Family& family, const DriveOptions& options, double idle_nm)
      : options_(options),
        idle_nm_(idle_nm),
        drive_(family.make_drive(options)),
        simulated_(family.make_simulated(options)),
        answers_on_(drive_->reply_ids()),
        commanded_by_(drive_->command_ids()) {}

  void advance(std::int64_t ns) { now_ns_ += ns; }

  /// One cycle as the arm runs it. @param spoil  changes the drive's answer; empty: as it is.
  void cycle(const DriveCommand& command, Bytes spoil, bool lose) {
    advance(1'000'000);
    std::array<Frame, Drive::kMaxFramesPerCycle> out;
    const bool wanted = command.mode == DriveMode::kEnable;
    was_enabled_ = was_enabled_ && wanted;
    // One that is still being disabled leaves enabled because it was told to.
    seen_disabled_ = seen_disabled_ && wanted;
    lost_cycles_ = wanted ? lost_cycles_ + (lost_cycles_ > 0 ? 1 : 0) : 0;
    const std::uint64_t calls = rt::heap_calls();
    const std::size_t count = drive_->transmit(command, now_ns_, out);
    expect(rt::heap_calls() == calls, "transmit() never touches the heap");
    expect(count <= out.size(), "no more frames than there is room for");
    expect(drive_->speaks_unasked() ||
               drive_->answers_due(count) <= SimulatedDrive::kMaxReplies * count,
           "no more answers are due than can come");
    check_state();
    note(drive_->state().condition);
    unwanted_cycles_ = wanted || lose || !spoil.empty() ? 0 : unwanted_cycles_ + 1;
    since_wanted_ = wanted ? 0 : since_wanted_ + 1;
    std::array<Frame, SimulatedDrive::kMaxReplies> said;
    for (std::size_t i = 0; i < count; ++i) {
      check_sent(out[i]);
      if (lose) continue;
      deliver(said, simulated_->receive(out[i], now_ns_ + 100'000, said), spoil, 300'000);
      check_drive();
    }
    const std::size_t unasked = simulated_->speak(now_ns_ + 350'000, said);
    deliver(said, lose ? 0 : unasked, spoil, 350'000);
    const double torque_nm = simulated_->torque_nm(now_ns_ + 400'000);
    expect(std::isfinite(torque_nm), "the drive's torque is a number");
    check_drive();
    expect(unwanted_cycles_ < kTorqueGoneCycles || !active(),
           "a drive whose torque nobody wants is soon disabled");
  }

  /// As an arm would: only what carries an identifier of this drive.
  void receive(const Frame& frame, std::int64_t stamp_ns) {
    if (frame.error || !matches(answers_on_, frame) || !drive_->claims(frame)) return;
    const DriveState before = drive_->state();
    const std::uint64_t calls = rt::heap_calls();
    const bool reported = drive_->receive({frame, stamp_ns});
    expect(rt::heap_calls() == calls, "receive() never touches the heap");
    const DriveState& after = drive_->state();
    newest_ns_ = std::max(newest_ns_, stamp_ns);
    expect(!reported || after.stamp_ns <= newest_ns_, "a report is no newer than its frames");
    expect(reported || before.position_rad == after.position_rad,
           "only a report moves the position");
    check_state();
    note(after.condition);
    expect(!refused_ || after.condition == DriveCondition::kRefused, "a refusal stays");
    refused_ = after.condition == DriveCondition::kRefused;
    expect(!refused_ || drive_->complaint().quantity != nullptr, "a refusal has its reason");
  }

  void restart() {
    const std::uint64_t calls = rt::heap_calls();
    drive_->restart();
    expect(rt::heap_calls() == calls, "restart() never touches the heap");
    refused_ = false;
    note(DriveCondition::kUnknown);
    unwanted_cycles_ = 0;
    check_state();
  }

  SimulatedDrive& simulated() {
    unwanted_cycles_ = 0;
    return *simulated_;
  }

  Frame forge(Input& input) const { return forged(input, answers_on_, options_.fd); }
  std::int64_t now_ns() const { return now_ns_; }

 private:
  /// A start-up that was lied to asks for all it asks for, each many times, before it looks at the
  /// drive's state again.
  static constexpr int kTorqueGoneCycles = 10'000;
  /// What was asked for before may still take its course in the drive.
  static constexpr int kGraceCycles = 200;

  void deliver(std::span<Frame> said, std::size_t count, Bytes spoil, std::int64_t after_ns) {
    expect(count <= said.size(), "no more replies than there is room for");
    for (std::size_t i = 0; i < count; ++i) {
      for (std::size_t at = 0; at < spoil.size(); ++at) said[i].data[at] ^= spoil[at];
      receive(said[i], now_ns_ + after_ns);
    }
  }

  bool active() {
    return simulated_->enabled() && std::abs(simulated_->torque_nm(now_ns_ + 400'000)) > idle_nm_;
  }

  void note(DriveCondition condition) {
    const bool enabled = condition == DriveCondition::kEnabled;
    if (was_enabled_ && !enabled && lost_cycles_ == 0) lost_cycles_ = 1;
    seen_disabled_ = seen_disabled_ || !enabled;
    was_enabled_ = was_enabled_ || (enabled && seen_disabled_);
  }

  /// Torque never comes back by itself, nor without being asked for.
  void check_drive() {
    const bool enabled = active();
    if (enabled && !drive_was_enabled_) {
      expect(since_wanted_ < kGraceCycles, "a drive is enabled only where that is wanted");
      expect(lost_cycles_ < kGraceCycles, "torque never comes back by itself");
    }
    drive_was_enabled_ = enabled;
  }

  void check_state() const {
    const DriveState& state = drive_->state();
    expect(std::isfinite(state.position_rad) && std::isfinite(state.velocity_rad_s) &&
               std::isfinite(state.torque_nm) && std::isfinite(state.temperature_c),
           "a drive's state is finite");
    expect(state.error == 0 || state.condition != DriveCondition::kEnabled,
           "a drive in error is not enabled");
  }

  void check_sent(const Frame& frame) const {
    expect(!frame.error && (!frame.fd || options_.fd) &&
               frame.id <= (frame.extended ? 0x1FFFFFFFU : 0x7FFU) &&
               drivers::is_can_length(frame.length, frame.fd),
           "a frame of the kind the bus carries");
    // A remote frame carries the identifier of what it asks for.
    expect(
        matches(frame.remote ? answers_on_ : commanded_by_, frame) || matches(commanded_by_, frame),
        "sent to an identifier that the drive is commanded by");
  }

  DriveOptions options_;
  double idle_nm_;  ///< torque that is none, where being enabled says nothing; else below 0
  std::unique_ptr<Drive> drive_;
  std::unique_ptr<SimulatedDrive> simulated_;
  std::vector<drivers::IdFilter> answers_on_;
  std::vector<drivers::IdFilter> commanded_by_;
  std::int64_t now_ns_ = 1'000'000'000;
  std::int64_t newest_ns_ = 0;      ///< stamp of what it was shown
  bool was_enabled_ = false;        ///< as the host knows it, since the mode was last another one
  bool seen_disabled_ = false;      ///< and not enabled, since then
  int lost_cycles_ = 0;             ///< since it then left enabled, or was restarted; 0: it did not
  bool drive_was_enabled_ = false;  ///< as it is
  bool refused_ = false;
  int unwanted_cycles_ = 0;
  int since_wanted_ = kGraceCycles;
};

DriveCommand command_from(Input& input) {
  DriveCommand command;
  command.mode = std::array{DriveMode::kMonitor, DriveMode::kEnable, DriveMode::kDisable,
                            DriveMode::kEnable}[input.below(4)];
  if (input.flag()) {
    command.torque_nm = input.real(15.0);
    command.position_rad = input.real(15.0);
    command.velocity_rad_s = input.real(40.0);
    command.stiffness_nm_rad = input.real(100.0);
    command.damping_nm_s_rad = input.real(6.0);
  }
  return command;
}

void shake(Input& input, SimulatedDrive& simulated) {
  switch (input.below(4)) {
    case 0:
      return simulated.power_cycle();
    case 1:
      return simulated.inject_error(input.byte());
    case 2:
      return simulated.set_temperature(static_cast<double>(input.byte()));
    default:
      return simulated.set_shaft(static_cast<double>(input.byte()) - 128.0,
                                 static_cast<double>(input.byte()) - 128.0);
  }
}

}  // namespace

void drives(Bytes bytes) {
  static const std::vector<drivers::test::FamilyBench> benches = drivers::test::family_benches();
  Input input(bytes);
  const drivers::test::FamilyBench& bench = benches[input.below(benches.size())];
  const DriveOptions options = options_from(input, bench);
  expect(bench.of().check(options).empty(), "the options of this target are good ones");
  Dialogue dialogue(bench, options);
  for (int steps = 0; !input.empty() && steps < 64; ++steps) {
    switch (input.below(8)) {
      case 0:
        dialogue.cycle(command_from(input), {}, true);
        break;
      case 1:
        dialogue.receive(dialogue.forge(input), dialogue.now_ns());
        break;
      case 2: {
        const DriveCommand command = command_from(input);
        dialogue.cycle(command, input.take(8), false);
        break;
      }
      case 3:
        shake(input, dialogue.simulated());
        break;
      case 4:
        input.below(4) == 0 ? dialogue.restart()
                            : dialogue.advance(static_cast<std::int64_t>(input.integer(4)));
        break;
      default: {
        const std::size_t cycles = 1 + input.below(100);
        const DriveCommand command = command_from(input);
        for (std::size_t i = 0; i < cycles; ++i) dialogue.cycle(command, {}, false);
        break;
      }
    }
  }
}

}  // namespace geodesic::fuzz
