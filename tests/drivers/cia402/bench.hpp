// A driver and a simulated CiA 402 drive on a bus that exists in memory only, stepped by hand.
#pragma once

#include <array>
#include <cstdint>
#include <vector>

#include "drivers/cia402/codec.hpp"
#include "drivers/cia402/driver.hpp"
#include "drivers/cia402/settings.hpp"
#include "drivers/cia402/simulated.hpp"

namespace geodesic::drivers::cia402::test {

inline void put(DriveOptions& options, Setting setting, double value) {
  options.settings.values[static_cast<std::size_t>(setting)] = value;
}

/// Node 3 with a gear of 100 and 280 mN·m at the motor: 28 N·m rated at the output.
inline DriveOptions bench_options() {
  DriveOptions options;
  options.family = "cia402";
  options.id = 3;
  options.torque_range_nm = 42.0;
  options.velocity_range_rad_s = 6.0;
  options.watchdog_ns = 50'000'000;
  options.leader = true;
  put(options, Setting::kEncoderIncrements, 16384);
  put(options, Setting::kGearMotor, 100);
  put(options, Setting::kRatedTorque, 280);
  put(options, Setting::kEncoderTurns, static_cast<double>(Turns::kKept));
  return options;
}

struct Bench {
  explicit Bench(const DriveOptions& with = bench_options())
      : options(with), driver(with), drive(with) {}

  static constexpr std::int64_t kPeriodNs = 1'000'000;

  void deliver(const Frame& frame, std::int64_t stamp_ns) {
    if (!deaf) {
      reported = driver.receive({frame, stamp_ns}) || reported;
      ++heard;
    }
  }

  /// One cycle: what the driver sends reaches the drive, and its answers the driver.
  void cycle(const DriveCommand& command = {}) {
    now_ns += kPeriodNs;
    reported = false;
    heard = 0;
    std::array<Frame, Drive::kMaxFramesPerCycle> out;
    std::array<Frame, SimulatedDrive::kMaxReplies> reply;
    const std::size_t said = drive.speak(now_ns, reply);
    for (std::size_t i = 0; i < said && !cut; ++i) {
      deliver(reply[i], now_ns);
    }
    frames = driver.transmit(command, now_ns, out);
    due = driver.answers_due(frames);
    heard = 0;
    for (std::size_t i = 0; i < frames; ++i) {
      sent.push_back(out[i]);
      const std::size_t count = cut ? 0 : drive.receive(out[i], now_ns + 100'000, reply);
      for (std::size_t k = 0; k < count; ++k) {
        deliver(reply[k], now_ns + 300'000);
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
                int at_most = 3000) {
    for (int i = 1; i <= at_most; ++i) {
      cycle(command);
      if (driver.state().condition == condition) {
        return i;
      }
    }
    return -1;
  }

  std::vector<Frame> sent_on(std::uint32_t id) const {
    std::vector<Frame> found;
    for (const Frame& frame : sent) {
      if (frame.id == id) {
        found.push_back(frame);
      }
    }
    return found;
  }

  /// Torque frames with a controlword that has one of `bits`.
  std::size_t sent_controlwords(std::uint16_t bits) const {
    std::size_t count = 0;
    for (const Frame& frame : sent_on(cob::kReceive1 + options.id)) {
      count += (decode_torque(frame)->controlword & bits) != 0 ? 1U : 0U;
    }
    return count;
  }

  DriveOptions options;
  Driver driver;
  Simulated drive;
  std::int64_t now_ns = 1'000'000'000;
  bool cut = false;   ///< nothing reaches the drive, nor the driver
  bool deaf = false;  ///< nothing reaches the driver
  std::size_t frames = 0;
  std::size_t due = 0;    ///< answers to the last cycle's frames
  std::size_t heard = 0;  ///< that came
  bool reported = false;
  std::vector<Frame> sent;
};

inline DriveCommand enable(double torque_nm = 0.0) {
  return {.mode = control::DriveMode::kEnable, .torque_nm = torque_nm};
}
inline DriveCommand disable() {
  return {.mode = control::DriveMode::kDisable};
}

}  // namespace geodesic::drivers::cia402::test
