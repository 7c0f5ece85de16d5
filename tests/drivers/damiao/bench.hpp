// A driver and a simulated drive on a bus that exists in memory only, stepped by hand.
#pragma once

#include <array>
#include <bit>
#include <cstdint>
#include <vector>

#include "drivers/damiao/codec.hpp"
#include "drivers/damiao/driver.hpp"
#include "drivers/damiao/simulated.hpp"

namespace geodesic::drivers::damiao::test {

inline DriveOptions bench_options() {
  DriveOptions options;
  options.family = "damiao";
  options.id = 0x05;
  options.reply_id = 0x15;
  options.position_range_rad = 12.5;
  options.velocity_range_rad_s = 30.0;
  options.torque_range_nm = 10.0;
  options.watchdog_ns = 50'000'000;
  return options;
}

struct Bench {
  explicit Bench(const DriveOptions& with = bench_options())
      : options(with), driver(with), drive(with) {}

  static constexpr std::int64_t kPeriodNs = 1'000'000;

  /// One cycle: what the driver sends reaches the drive, and its answer the driver.
  void cycle(const DriveCommand& command = {}) {
    now_ns += kPeriodNs;
    std::array<Frame, Drive::kMaxFramesPerCycle> out;
    frames = driver.transmit(command, now_ns, out);
    for (std::size_t i = 0; i < frames; ++i) {
      sent.push_back(out[i]);
      std::array<Frame, 1> reply;
      if (!cut && drive.receive(out[i], now_ns + 100'000, reply) == 1 && !deaf) {
        reported = driver.receive({reply[0], now_ns + 300'000});
      }
    }
  }

  void run(int cycles, const DriveCommand& command = {}) {
    for (int i = 0; i < cycles; ++i) {
      cycle(command);
    }
  }

  /// Cycles until the driver reports `condition`. @return cycles taken, or -1.
  int run_until(control::DriveCondition condition, const DriveCommand& command = {},
                int at_most = 1000) {
    for (int i = 1; i <= at_most; ++i) {
      cycle(command);
      if (driver.state().condition == condition) {
        return i;
      }
    }
    return -1;
  }

  std::size_t sent_special(Special special) const {
    std::size_t count = 0;
    for (const Frame& frame : sent) {
      count += frame.id == options.id && decode_special(frame) == special ? 1U : 0U;
    }
    return count;
  }

  std::size_t sent_writes() const {
    std::size_t count = 0;
    for (const Frame& frame : sent) {
      count += frame.id == kRegisterId && frame.data[2] == 0x55 ? 1U : 0U;
    }
    return count;
  }

  static std::uint32_t raw(double value) {
    return std::bit_cast<std::uint32_t>(static_cast<float>(value));
  }

  DriveOptions options;
  Driver driver;
  Simulated drive;
  std::int64_t now_ns = 1'000'000'000;
  bool cut = false;   ///< nothing reaches the drive
  bool deaf = false;  ///< nothing reaches the driver
  std::size_t frames = 0;
  bool reported = false;
  std::vector<Frame> sent;
};

inline DriveCommand enable(double torque_nm = 0.0) {
  return {.mode = control::DriveMode::kEnable, .torque_nm = torque_nm};
}
inline DriveCommand disable() {
  return {.mode = control::DriveMode::kDisable};
}

}  // namespace geodesic::drivers::damiao::test
