// A moteus driver and a simulated drive on a bus that exists in memory only, stepped by hand.
#pragma once

#include <array>
#include <cstdint>
#include <numbers>
#include <vector>

#include "drivers/moteus/codec.hpp"
#include "drivers/moteus/driver.hpp"
#include "drivers/moteus/settings.hpp"
#include "drivers/moteus/simulated.hpp"

namespace geodesic::drivers::moteus::test {

inline constexpr double kTurn = 2.0 * std::numbers::pi;

inline DriveOptions bench_options() {
  DriveOptions options;
  options.family = "moteus";
  options.id = 5;
  options.fd = true;
  options.velocity_range_rad_s = 40.0;
  options.torque_range_nm = 10.0;
  options.watchdog_ns = 50'000'000;
  return options;
}

inline DriveOptions with(Setting which, double value, DriveOptions options = bench_options()) {
  options.settings.values[which] = value;
  return options;
}

/// What is written to a register in `frame`; nothing if it is not.
inline std::optional<double> written(const Frame& frame, Register number) {
  Reader reader(frame);
  for (Entry entry; reader.next(entry);) {
    if (entry.kind == opcode::kWrite && entry.number == static_cast<std::uint32_t>(number)) {
      return entry.value;
    }
  }
  return std::nullopt;
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

  std::size_t sent_mode(Mode mode) const {
    std::size_t count = 0;
    for (const Frame& frame : sent) {
      count += written(frame, Register::kMode) == static_cast<double>(mode) ? 1U : 0U;
    }
    return count;
  }

  double torque() { return drive.torque_nm(now_ns + 200'000); }

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

}  // namespace geodesic::drivers::moteus::test
