// A MyActuator driver and a simulated drive on a bus that exists in memory only, stepped by hand.
#pragma once

#include <array>
#include <cstdint>
#include <vector>

#include "drivers/myactuator/codec.hpp"
#include "drivers/myactuator/driver.hpp"
#include "drivers/myactuator/settings.hpp"
#include "drivers/myactuator/simulated.hpp"

namespace geodesic::drivers::myactuator::test {

inline DriveOptions bench_options() {
  DriveOptions options;
  options.family = "myactuator";
  options.id = 3;
  options.velocity_range_rad_s = 20.0;
  options.torque_range_nm = 24.0;
  options.watchdog_ns = 50'000'000;
  options.settings.values[kTorqueConstant] = 2.0;
  return options;
}

inline DriveOptions motion_options() {
  DriveOptions options = bench_options();
  options.position_range_rad = 12.5;
  options.velocity_range_rad_s = 45.0;
  options.settings.values[kMode] = 1.0;
  options.settings.values[kTorqueConstant] = kNotSet;
  return options;
}

inline DriveOptions braked_options() {
  DriveOptions options = bench_options();
  options.settings.values[kBrake] = 1.0;
  return options;
}

inline constexpr Ranges kRanges{12.5, 45.0, 24.0, 500.0, 5.0};

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
    const std::size_t unasked = drive.speak(now_ns + 200'000, reply);
    hear(reply, cut ? 0 : unasked);
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

  std::size_t sent_requests(Command command) const {
    std::size_t count = 0;
    for (const Frame& frame : sent) {
      const bool request = frame.id == kRequestId + options.id;
      count += request && frame.data[0] == static_cast<std::uint8_t>(command) ? 1U : 0U;
    }
    return count;
  }

  /// Frames that make torque.
  std::size_t sent_torques() const {
    std::size_t count = sent_requests(Command::kTorque);
    for (const Frame& frame : sent) {
      count += frame.id == kMotionRequestId + options.id ? 1U : 0U;
    }
    return count;
  }

  DriveOptions options;
  Driver driver;
  Simulated drive;
  std::int64_t now_ns = 1'000'000'000;
  bool cut = false;   ///< nothing reaches the drive, nor comes from it
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

}  // namespace geodesic::drivers::myactuator::test
