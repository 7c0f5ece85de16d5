// Fuzz target: the host side of every drive family against its simulated drive, with forged,
// spoilt and missing frames, restarts, power cycles and commands that are no numbers.
#include <algorithm>
#include <array>
#include <cmath>
#include <cstring>

#include "drivers/bus/bit_timing.hpp"
#include "drivers/damiao/codec.hpp"
#include "drivers/families.hpp"
#include "rt/heap_counter.hpp"
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

DriveOptions options_from(Input& input, const Family& family) {
  DriveOptions options;
  options.family = family.name;
  options.id = 1 + static_cast<std::uint32_t>(input.below(0x20));
  options.reply_id = options.id + 0x10 + (input.below(8) == 0 ? 0x100U : 0U);
  options.fd = input.below(4) == 0;
  options.position_range_rad = 12.5;
  options.velocity_range_rad_s = 30.0;
  options.torque_range_nm = 10.0;
  options.watchdog_ns = 5'000'000 + 5'000'000 * static_cast<std::int64_t>(input.below(20));
  options.clear_errors = input.flag();
  return options;
}

/// A drive, its simulated counterpart, and what must hold between them at every step.
class Dialogue {
 public:
  Dialogue(const Family& family, const DriveOptions& options)
      : options_(options),
        damiao_(family.name == "damiao"),
        drive_(family.make_drive(options)),
        simulated_(family.make_simulated(options)),
        commanded_by_(drive_->command_ids()) {}

  void advance(std::int64_t ns) { now_ns_ += ns; }

  /// One cycle as the arm runs it. @param spoil  changes the drive's answer; empty: as it is.
  void cycle(const DriveCommand& command, Bytes spoil, bool lose) {
    advance(1'000'000);
    std::array<Frame, Drive::kMaxFramesPerCycle> out;
    const DriveCondition before = drive_->state().condition;
    const bool wanted = command.mode == DriveMode::kEnable;
    asked_to_enable_ = asked_to_enable_ && wanted;
    lost_ = lost_ && wanted;
    const std::uint64_t calls = rt::heap_calls();
    const std::size_t count = drive_->transmit(command, now_ns_, out);
    expect(rt::heap_calls() == calls, "transmit() never touches the heap");
    expect(count <= out.size(), "no more frames than there is room for");
    check_state();
    unwanted_cycles_ = wanted || lose || !spoil.empty() ? 0 : unwanted_cycles_ + 1;
    for (std::size_t i = 0; i < count; ++i) {
      check_sent(out[i], wanted && before == DriveCondition::kEnabled);
      std::array<Frame, 1> reply;
      if (lose || simulated_->receive(out[i], now_ns_ + 100'000, reply) == 0) continue;
      for (std::size_t at = 0; at < spoil.size() && at < 8; ++at) reply[0].data[at] ^= spoil[at];
      receive(reply[0], now_ns_ + 300'000);
    }
    const double torque_nm = simulated_->torque_nm(now_ns_ + 400'000);
    expect(std::isfinite(torque_nm) && std::abs(torque_nm) <= options_.torque_range_nm,
           "the drive's torque is finite and within its range");
    expect(unwanted_cycles_ < kTorqueGoneCycles || !simulated_->enabled(),
           "a drive whose torque nobody wants is soon disabled");
  }

  void receive(const Frame& frame, std::int64_t stamp_ns) {
    const DriveState before = drive_->state();
    const std::uint64_t calls = rt::heap_calls();
    const bool reported = drive_->receive({frame, stamp_ns});
    expect(rt::heap_calls() == calls, "receive() never touches the heap");
    const DriveState& after = drive_->state();
    const bool ours = !frame.error && !frame.extended && frame.id == options_.reply_id;
    expect(ours || (!reported && same(before, after)), "a foreign frame changes nothing");
    expect(!reported || after.stamp_ns == stamp_ns, "a report has the stamp of its frame");
    expect(reported || before.position_rad == after.position_rad,
           "only a report moves the position");
    check_state();
    const bool enabled_before = before.condition == DriveCondition::kEnabled;
    const bool enabled_after = after.condition == DriveCondition::kEnabled;
    lost_ = lost_ || (asked_to_enable_ && enabled_before && !enabled_after);
    expect(!refused_ || after.condition == DriveCondition::kRefused, "a refusal stays");
    refused_ = after.condition == DriveCondition::kRefused;
    expect(!refused_ || drive_->complaint().quantity != nullptr, "a refusal has its reason");
  }

  void restart() {
    const std::uint64_t calls = rt::heap_calls();
    drive_->restart();
    expect(rt::heap_calls() == calls, "restart() never touches the heap");
    refused_ = false;
    lost_ = lost_ || asked_to_enable_;
    unwanted_cycles_ = 0;
    check_state();
  }

  drivers::SimulatedDrive& simulated() {
    unwanted_cycles_ = 0;
    return *simulated_;
  }

  std::int64_t now_ns() const { return now_ns_; }

 private:
  /// A start-up that was lied to asks for eight registers, each up to 25 times in 20 ms, before it
  /// looks at the drive's state again.
  static constexpr int kTorqueGoneCycles = 5000;

  static bool same(const DriveState& a, const DriveState& b) {
    return a.position_rad == b.position_rad && a.velocity_rad_s == b.velocity_rad_s &&
           a.torque_nm == b.torque_nm && a.temperature_c == b.temperature_c &&
           a.stamp_ns == b.stamp_ns && a.condition == b.condition && a.error == b.error;
  }

  void check_state() const {
    const DriveState& state = drive_->state();
    const auto within = [](double value, double range) {
      return std::isfinite(value) && std::abs(value) <= range * (1.0 + 1e-9);
    };
    expect(std::isfinite(state.position_rad) &&  // counted on beyond the range
               within(state.velocity_rad_s, options_.velocity_range_rad_s) &&
               within(state.torque_nm, options_.torque_range_nm) &&
               within(state.temperature_c, 255.0),
           "a drive's state is finite and in range");
    expect(state.error == 0 || state.condition != DriveCondition::kEnabled,
           "a drive in error is not enabled");
  }

  void check_sent(const Frame& frame, bool torque_allowed) {
    expect(!frame.error && !frame.extended && frame.fd == options_.fd &&
               drivers::is_can_length(frame.length, frame.fd),
           "a frame of the kind the bus carries");
    const bool to_us = std::any_of(
        commanded_by_.begin(), commanded_by_.end(),
        [&frame](const drivers::IdFilter& id) { return id.id == frame.id && !id.extended; });
    expect(to_us, "sent to an identifier that the drive is commanded by");
    if (!damiao_ || frame.id != options_.id) return;
    const auto mit = drivers::damiao::decode_mit(
        frame,
        {options_.position_range_rad, options_.velocity_range_rad_s, options_.torque_range_nm});
    expect(!mit || (torque_allowed && !lost_) ||
               (std::abs(mit->torque_nm) < options_.torque_range_nm / 4000.0 &&
                mit->stiffness_nm_rad == 0.0),
           "torque leaves only for a drive that is enabled and wanted to be");
    if (drivers::damiao::decode_special(frame) == drivers::damiao::Special::kEnable) {
      expect(!lost_, "torque never comes back by itself");
      asked_to_enable_ = true;
    }
  }

  DriveOptions options_;
  bool damiao_;
  std::unique_ptr<Drive> drive_;
  std::unique_ptr<drivers::SimulatedDrive> simulated_;
  std::vector<drivers::IdFilter> commanded_by_;
  std::int64_t now_ns_ = 1'000'000'000;
  bool asked_to_enable_ = false;  ///< since the mode was last another than kEnable
  bool lost_ = false;             ///< and after that it left enabled, or was restarted
  bool refused_ = false;
  int unwanted_cycles_ = 0;
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

Frame frame_from(Input& input, const DriveOptions& options) {
  Frame frame;
  const std::size_t kind = input.below(8);
  frame.id = kind == 0 ? static_cast<std::uint32_t>(input.integer(2)) : options.reply_id;
  frame.extended = kind == 1;
  frame.error = kind == 2;
  frame.fd = options.fd;
  frame.length = static_cast<std::uint8_t>(kind == 3 ? input.below(65) : 8);
  const Bytes data = input.take(frame.length);
  std::copy(data.begin(), data.end(), frame.data.begin());
  return frame;
}

void shake(Input& input, drivers::SimulatedDrive& simulated) {
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
  Input input(bytes);
  const Family& family = drivers::families()[input.below(drivers::families().size())];
  const DriveOptions options = options_from(input, family);
  expect(family.check(options).empty(), "the options of this target are good ones");
  Dialogue dialogue(family, options);
  for (int steps = 0; !input.empty() && steps < 64; ++steps) {
    switch (input.below(8)) {
      case 0:
        dialogue.cycle(command_from(input), {}, true);
        break;
      case 1:
        dialogue.receive(frame_from(input, options), dialogue.now_ns());
        break;
      case 2:
        dialogue.cycle(command_from(input), input.take(8), false);
        break;
      case 3:
        shake(input, dialogue.simulated());
        break;
      case 4:
        input.below(4) == 0 ? dialogue.restart()
                            : dialogue.advance(static_cast<std::int64_t>(input.integer(4)));
        break;
      default: {
        const std::size_t cycles = 1 + input.below(40);
        const DriveCommand command = command_from(input);
        for (std::size_t i = 0; i < cycles; ++i) dialogue.cycle(command, {}, false);
        break;
      }
    }
  }
}

}  // namespace geodesic::fuzz
