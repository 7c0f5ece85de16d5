// A CubeMars driver and a simulated drive on a bus that exists in memory only, stepped by hand.
#pragma once

#include <array>
#include <cstdint>
#include <vector>

#include "drivers/cubemars/codec.hpp"
#include "drivers/cubemars/driver.hpp"
#include "drivers/cubemars/settings.hpp"
#include "drivers/cubemars/simulated.hpp"

namespace geodesic::drivers::cubemars::test {

/// An AK80-9 in MIT mode that answers on the host's identifier 0.
inline DriveOptions bench_options() {
  DriveOptions options;
  options.family = "cubemars";
  options.id = 0x05;
  options.reply_id = 0;
  options.position_range_rad = 12.5;
  options.velocity_range_rad_s = 50.0;
  options.torque_range_nm = 18.0;
  options.watchdog_ns = 25'000'000;
  options.settings.values[kGearRatio] = 9.0;
  return options;
}

inline DriveOptions servo_options() {
  DriveOptions options = bench_options();
  options.position_range_rad = 0.0;
  options.watchdog_ns = 50'000'000;
  options.settings.values[kMode] = 1.0;
  options.settings.values[kEncoder] = 1.0;
  options.settings.values[kTorqueConstant] = 0.115;
  return options;
}

inline constexpr Ranges kRanges{12.5, 50.0, 18.0};

struct Bench {
  explicit Bench(const DriveOptions& with = bench_options())
      : options(with), driver(with), drive(with) {
    sent.reserve(20'000);
  }

  static constexpr std::int64_t kPeriodNs = 1'000'000;

  /// One cycle: what the driver sends reaches the drive, and its answers the driver.
  void cycle(const DriveCommand& command = {}) {
    now_ns += kPeriodNs;
    reported = false;
    std::array<Frame, Drive::kMaxFramesPerCycle> out;
    std::array<Frame, SimulatedDrive::kMaxReplies> reply;
    frames = driver.transmit(command, now_ns, out);
    for (std::size_t i = 0; i < frames; ++i) {
      sent.push_back(out[i]);
      if (!cut) {
        hear(reply, drive.receive(out[i], now_ns + 100'000, reply));
      }
    }
    hear(reply, drive.speak(now_ns + 200'000, reply));
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

  /// Moves the shaft at `speed` from where it is.
  void move(double speed, int cycles, const DriveCommand& command = {}) {
    for (int i = 0; i < cycles; ++i) {
      shaft += speed * 1e-3;
      drive.set_shaft(shaft, speed);
      cycle(command);
    }
  }

  std::size_t sent_special(Special special) const {
    std::size_t count = 0;
    for (const Frame& frame : sent) {
      count += frame.id == options.id && decode_special(frame) == special ? 1U : 0U;
    }
    return count;
  }

  DriveOptions options;
  Driver driver;
  Simulated drive;
  std::int64_t now_ns = 1'000'000'000;
  double shaft = 0.0;
  bool cut = false;   ///< nothing reaches the drive
  bool deaf = false;  ///< nothing reaches the driver
  std::size_t frames = 0;
  bool reported = false;
  std::vector<Frame> sent;

 private:
  void hear(const std::array<Frame, SimulatedDrive::kMaxReplies>& replies, std::size_t count) {
    for (std::size_t i = 0; i < count && !deaf; ++i) {
      reported = driver.receive({replies[i], now_ns + 300'000}) || reported;
    }
  }
};

inline DriveCommand enable(double torque_nm = 0.0) {
  return {.mode = control::DriveMode::kEnable, .torque_nm = torque_nm};
}
inline DriveCommand disable() {
  return {.mode = control::DriveMode::kDisable};
}

}  // namespace geodesic::drivers::cubemars::test
