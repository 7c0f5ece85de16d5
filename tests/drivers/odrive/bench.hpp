// A driver and a simulated ODrive on a bus that exists in memory only, stepped by hand.
#pragma once

#include <array>
#include <cstdint>
#include <vector>

#include "drivers/odrive/codec.hpp"
#include "drivers/odrive/driver.hpp"
#include "drivers/odrive/simulated.hpp"

namespace geodesic::drivers::odrive::test {

constexpr std::uint32_t kNode = 5;

inline void set(DriveOptions& options, Key key, double value) {
  options.settings.values[static_cast<std::size_t>(key)] = value;
}
inline void set_endpoint(DriveOptions& options, Parameter parameter, double id) {
  options.settings
      .values[static_cast<std::size_t>(Key::kFirstEndpoint) + static_cast<std::size_t>(parameter)] =
      id;
}

/// Firmware 0.6, reports by the drive's timer, watchdog proved by silence.
inline DriveOptions bench_options() {
  DriveOptions options;
  options.family = "odrive";
  options.id = kNode;
  options.velocity_range_rad_s = 60.0;
  options.torque_range_nm = 2.0;
  options.watchdog_ns = 50'000'000;
  set(options, Key::kTorqueConstant, 0.1);
  set(options, Key::kCurrentLimit, 25.0);
  return options;
}

/// Firmware 0.5, positions asked for in every cycle.
inline DriveOptions old_options() {
  DriveOptions options = bench_options();
  set(options, Key::kFirmware, 1.0);
  set(options, Key::kFeedback, 1.0);
  return options;
}

/// Firmware 0.6.9 whose endpoints are known.
inline DriveOptions endpoint_options() {
  DriveOptions options = bench_options();
  set(options, Key::kRevision, 9.0);
  for (std::size_t i = 0; i < kParameterCount; ++i) {
    set_endpoint(options, static_cast<Parameter>(i), 201.0 + static_cast<double>(i));
  }
  return options;
}

struct Bench {
  explicit Bench(const DriveOptions& with = bench_options())
      : options(with), driver(with), drive(with) {
    sent.reserve(100'000);
  }

  static constexpr std::int64_t kPeriodNs = 1'000'000;

  void hear(std::size_t count, std::int64_t stamp_ns) {
    for (std::size_t i = 0; i < count && !deaf; ++i) {
      if (said[i].id != (kNode << 5U | muted)) {
        reported = driver.receive({said[i], stamp_ns}) || reported;
      }
    }
  }

  /// One cycle: what the driver sends reaches the drive, and its answers the driver; then the
  /// drive's timers speak.
  void cycle(const DriveCommand& command = {}) {
    now_ns += kPeriodNs;
    reported = false;
    frames = driver.transmit(command, now_ns, out);
    for (std::size_t i = 0; i < frames; ++i) {
      sent.push_back(out[i]);
      if (!cut) {
        hear(drive.receive(out[i], now_ns + 100'000, said), now_ns + 300'000);
      }
    }
    hear(drive.speak(now_ns + 500'000, said), now_ns + 600'000);
  }

  void run(int cycles, const DriveCommand& command = {}) {
    for (int i = 0; i < cycles; ++i) {
      cycle(command);
    }
  }

  /// Cycles until the driver reports `condition`. @return cycles taken, or -1.
  int run_until(control::DriveCondition condition, const DriveCommand& command = {},
                int at_most = 4000) {
    for (int i = 1; i <= at_most; ++i) {
      cycle(command);
      if (driver.state().condition == condition) {
        return i;
      }
    }
    return -1;
  }

  std::size_t sent_commands(Command command) const {
    std::size_t count = 0;
    for (const Frame& frame : sent) {
      count += !frame.remote && command_of(frame) == command ? 1U : 0U;
    }
    return count;
  }

  std::size_t sent_states(std::uint8_t state) const {
    std::size_t count = 0;
    for (const Frame& frame : sent) {
      count += command_of(frame) == Command::kAxisState && frame.data[0] == state ? 1U : 0U;
    }
    return count;
  }

  double torque() { return drive.torque_nm(now_ns + 500'000); }

  /// What somebody else on the bus tells the drive.
  void tell(const Frame& frame) { drive.receive(frame, now_ns + 700'000, said); }

  DriveOptions options;
  Driver driver;
  Simulated drive;
  std::int64_t now_ns = 1'000'000'000;
  bool cut = false;             ///< nothing reaches the drive
  bool deaf = false;            ///< nothing reaches the driver
  std::uint32_t muted = 0xFFF;  ///< command whose reports do not reach the driver
  std::size_t frames = 0;
  bool reported = false;
  std::array<Frame, Drive::kMaxFramesPerCycle> out;
  std::array<Frame, SimulatedDrive::kMaxReplies> said;
  std::vector<Frame> sent;
};

inline DriveCommand enable(double torque_nm = 0.0) {
  return {.mode = control::DriveMode::kEnable, .torque_nm = torque_nm};
}
inline DriveCommand disable() {
  return {.mode = control::DriveMode::kDisable};
}

}  // namespace geodesic::drivers::odrive::test
