// Fuzz target: the drive side of every family: genuine, spoilt and forged frames, any shaft.
#include <algorithm>
#include <array>
#include <cmath>

#include "drivers/bus/bit_timing.hpp"
#include "drivers/families.hpp"
#include "tests/drivers/family_benches.hpp"
#include "tests/fuzz/family_frames.hpp"
#include "tests/fuzz/fuzz.hpp"

namespace geodesic::fuzz {
namespace {

using control::DriveMode;
using drivers::Drive;
using drivers::DriveOptions;
using drivers::Family;
using drivers::Frame;
using drivers::SimulatedDrive;

/// Physics moves shafts to places, not to infinity; how far is its affair.
double finite(Input& input, double scale) {
  const double value = input.real(scale);
  return std::abs(value) <= 1e6 ? value : 0.0;
}

class Side {
 public:
  Side(const Family& family, const DriveOptions& options)
      : family_(family),
        options_(options),
        host_(family.make_drive(options)),
        drive_(family.make_simulated(options)),
        commanded_by_(host_->command_ids()) {}

  SimulatedDrive& drive() { return *drive_; }
  void advance(std::int64_t ns) { now_ns_ += ns; }
  Frame forge(Input& input) const { return forged(input, commanded_by_, options_.fd); }

  /// What a host says in so many cycles, its last frame spoilt.
  void talk(std::size_t cycles, DriveMode mode, Bytes spoil) {
    for (std::size_t cycle = 0; cycle < cycles; ++cycle) {
      advance(1'000'000);
      std::array<Frame, Drive::kMaxFramesPerCycle> out;
      const std::size_t count = host_->transmit({.mode = mode, .torque_nm = 1.0}, now_ns_, out);
      for (std::size_t i = 0; i < count; ++i) {
        for (std::size_t at = 0; at < spoil.size() && cycle + 1 == cycles; ++at) {
          out[i].data[at] ^= spoil[at];
        }
        show(out[i]);
      }
      speak();
    }
  }

  void show(const Frame& frame) {
    expect_words(family_.decode(frame, options_));
    std::array<Frame, SimulatedDrive::kMaxReplies> reply;
    answer(reply, drive_->receive(frame, now_ns_, reply));
  }

  void speak() {
    std::array<Frame, SimulatedDrive::kMaxReplies> said;
    answer(said, drive_->speak(now_ns_, said));
  }

  void check() {
    const double torque_nm = drive_->torque_nm(now_ns_);
    expect(std::isfinite(torque_nm), "physics gets a torque that is a number");
    expect(drive_->enabled() || torque_nm == 0.0, "no torque from a drive that is not enabled");
  }

 private:
  void answer(std::span<const Frame> said, std::size_t count) {
    expect(count <= said.size(), "no more replies than there is room for");
    for (const Frame& frame : said.first(count)) {
      expect(frame.id <= (frame.extended ? 0x1FFFFFFFU : 0x7FFU) && !frame.error &&
                 (!frame.fd || options_.fd) && drivers::is_can_length(frame.length, frame.fd),
             "a reply is a frame that a bus can carry");
      expect_words(family_.decode(frame, options_));
      host_->receive({frame, now_ns_});
    }
  }

  const Family& family_;
  DriveOptions options_;
  std::unique_ptr<Drive> host_;
  std::unique_ptr<SimulatedDrive> drive_;
  std::vector<drivers::IdFilter> commanded_by_;
  std::int64_t now_ns_ = 1'000'000'000;
};

}  // namespace

void simulated(Bytes bytes) {
  static const std::vector<drivers::test::FamilyBench> benches = drivers::test::family_benches();
  Input input(bytes);
  const drivers::test::FamilyBench& bench = benches[input.below(benches.size())];
  Side side(bench.of(), bench.options);
  for (int steps = 0; !input.empty() && steps < 256; ++steps) {
    switch (input.below(8)) {
      case 0:
        side.drive().set_shaft(finite(input, 20.0), finite(input, 40.0));
        break;
      case 1:
        side.drive().set_temperature(finite(input, 200.0));
        break;
      case 2:
        input.flag() ? side.drive().power_cycle() : side.drive().inject_error(input.byte());
        break;
      case 3: {
        const std::size_t cycles = 1 + input.below(64);
        const DriveMode mode = input.flag() ? DriveMode::kEnable : DriveMode::kMonitor;
        side.talk(cycles, mode, input.take(input.below(9)));
        break;
      }
      case 4:
        side.advance(static_cast<std::int64_t>(input.integer(4)));
        side.speak();
        break;
      default:
        side.advance(static_cast<std::int64_t>(input.integer(3)));
        side.show(side.forge(input));
        break;
    }
    side.check();
    expect(bench.of().error_name(input.byte()) != nullptr, "every error code has words");
  }
}

}  // namespace geodesic::fuzz
