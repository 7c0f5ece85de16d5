// A driver and a simulated drive on a bus that exists in memory only, stepped by hand.
#pragma once

#include <algorithm>
#include <array>
#include <bit>
#include <cstdint>
#include <functional>
#include <vector>

#include "drivers/robstride/codec.hpp"
#include "drivers/robstride/driver.hpp"
#include "drivers/robstride/settings.hpp"
#include "drivers/robstride/simulated.hpp"

namespace geodesic::drivers::robstride::test {

inline constexpr Ranges kRanges{12.57, 44.0, 17.0, 500.0, 5.0};
inline constexpr Link kLink{.motor = 5, .host = 0xFD};

inline DriveOptions bench_options(bool cybergear = false) {
  DriveOptions options;
  options.family = "robstride";
  options.id = kLink.motor;
  options.position_range_rad = cybergear ? 12.5 : kRanges.position_rad;
  options.velocity_range_rad_s = kRanges.velocity_rad_s;
  options.torque_range_nm = kRanges.torque_nm;
  options.watchdog_ns = 50'000'000;
  options.settings.values[kVariant] = cybergear ? 1.0 : 0.0;
  options.settings.values[kStiffnessRange] = kRanges.stiffness_nm_rad;
  options.settings.values[kDampingRange] = kRanges.damping_nm_s_rad;
  return options;
}

inline std::uint16_t number(Index index) {
  return static_cast<std::uint16_t>(index);
}

struct Bench {
  explicit Bench(const DriveOptions& with = bench_options())
      : options(with), driver(with), drive(with) {}

  static constexpr std::int64_t kPeriodNs = 1'000'000;

  /// One cycle: what the driver sends reaches the drive, and its answers the driver.
  void cycle(const DriveCommand& command = {}) {
    now_ns += kPeriodNs;
    std::array<Frame, Drive::kMaxFramesPerCycle> out;
    frames = driver.transmit(command, now_ns, out);
    for (std::size_t i = 0; i < frames; ++i) {
      sent.push_back(out[i]);
      std::array<Frame, SimulatedDrive::kMaxReplies> reply;
      const std::size_t count = cut ? 0 : drive.receive(out[i], now_ns + 100'000, reply);
      take(reply, count);
    }
    std::array<Frame, SimulatedDrive::kMaxReplies> said;
    take(said, drive.speak(now_ns + 200'000, said));
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

  /// Straight to the drive, as somebody else would. @return the answer.
  std::optional<Frame> ask(const Frame& frame) {
    std::array<Frame, SimulatedDrive::kMaxReplies> reply;
    return drive.receive(frame, now_ns, reply) > 0 ? std::optional(reply[0]) : std::nullopt;
  }

  std::size_t count(const Frame& frame) const {
    return static_cast<std::size_t>(std::count(sent.begin(), sent.end(), frame));
  }

  std::size_t count(Type type) const {
    return static_cast<std::size_t>(
        std::count_if(sent.begin(), sent.end(),
                      [type](const Frame& frame) { return type_of(frame.id) == type; }));
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
  std::function<void(Frame&)> forge;  ///< changes what the drive says

 private:
  void take(std::span<Frame> said, std::size_t count) {
    for (std::size_t i = 0; i < count && !deaf; ++i) {
      if (forge) {
        forge(said[i]);
      }
      reported = driver.receive({said[i], now_ns + 300'000});
    }
  }
};

inline DriveCommand enable(double torque_nm = 0.0) {
  return {.mode = control::DriveMode::kEnable, .torque_nm = torque_nm};
}
inline DriveCommand disable() {
  return {.mode = control::DriveMode::kDisable};
}

}  // namespace geodesic::drivers::robstride::test
