// The CiA 402 family: checks of options, frames of a cycle, its line in the table. Frames in words
// are in words.cpp.
#include "drivers/cia402/family.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <memory>
#include <numbers>

#include "drivers/cia402/driver.hpp"
#include "drivers/cia402/errors.hpp"
#include "drivers/cia402/scanner.hpp"
#include "drivers/cia402/settings.hpp"
#include "drivers/cia402/simulated.hpp"
#include "drivers/cia402/zeroing.hpp"

namespace geodesic::drivers::cia402 {

namespace {

constexpr std::int64_t kMostWatchdogNs = 10'000'000'000;
constexpr double kMostPermille = 32767.0;
constexpr double kMostCount = 4294967295.0;

void check_settings(const DriveOptions& options, std::vector<std::string>& wrong) {
  const std::span<const DriveSetting> table = settings();
  for (std::size_t i = 0; i < table.size(); ++i) {
    const double value = options.settings.get(table, i);
    const double upper = table[i].choices.empty()
                             ? std::min(table[i].upper, kMostCount)
                             : static_cast<double>(table[i].choices.size() - 1);
    const double lower = table[i].choices.empty() ? table[i].lower : 0.0;
    if (!(value >= lower && value <= upper) || value != std::floor(value)) {
      wrong.push_back(
          fmt::format("the drive's {} is {}; it must be a whole number between {} and {}",
                      table[i].key, value, lower, upper));
    }
  }
}

void check_torque(const DriveOptions& options, std::vector<std::string>& wrong) {
  if (!std::isfinite(options.torque_range_nm) || options.torque_range_nm <= 0.0) {
    wrong.push_back(fmt::format(
        "the drive's torque range is {} N·m; it must be the most ever asked for at its output, "
        "above 0: the drive is set to it (0x6072)",
        options.torque_range_nm));
    return;
  }
  const double permille = options.torque_range_nm / Units(options).rated_nm * 1e3;
  if (permille < 1.0 || permille > kMostPermille) {
    wrong.push_back(fmt::format(
        "the drive's torque range of {} N·m is {:.4g} per mille of its rated torque of {:.4g} N·m "
        "at the output; 0x6072 holds 1 to 32767: correct rated_torque_mnm or the gear",
        options.torque_range_nm, permille, Units(options).rated_nm));
  }
}

}  // namespace

std::vector<std::string> check(const DriveOptions& options) {
  std::vector<std::string> wrong;
  check_settings(options, wrong);
  if (!wrong.empty()) {
    return wrong;
  }
  if (options.id < 1 || options.id > kLastNode) {
    wrong.push_back(fmt::format(
        "the drive's id (its CANopen node) is {}; it must be between 1 and 127", options.id));
  }
  if (options.id == integer(options, Setting::kHostNode)) {
    wrong.push_back(fmt::format(
        "the drive's node {} is also host_node: give this host another one, since both send a "
        "heartbeat",
        options.id));
  }
  if (options.fd) {
    wrong.emplace_back("CANopen is classic CAN: fd must be false");
  }
  check_torque(options, wrong);
  if (!std::isfinite(options.velocity_range_rad_s) || options.velocity_range_rad_s <= 0.0) {
    wrong.push_back(
        fmt::format("the drive's velocity range is {} rad/s; it must be above 0: velocities asked "
                    "for are held within it",
                    options.velocity_range_rad_s));
  }
  if (options.watchdog_ns < kLeastWatchdogNs || options.watchdog_ns > kMostWatchdogNs) {
    wrong.push_back(fmt::format(
        "the drive's watchdog time is {} ms; it must be between 30 ms, since this host's heartbeat "
        "comes every 10 ms, and 10 s",
        static_cast<double>(options.watchdog_ns) * 1e-6));
  }
  return wrong;
}

std::vector<CyclicFrame> cyclic_frames(const DriveOptions& options, double rate_hz) {
  const auto share = [rate_hz](double per_second) {
    return rate_hz > 0.0 ? std::min(per_second / rate_hz, 1.0) : 1.0;
  };
  const std::uint32_t node = options.id;
  std::vector<CyclicFrame> frames = {
      {.what = "torque", .id = cob::kReceive1 + node, .bytes = 4},
      {.what = "host's heartbeat",
       .id = cob::kHeartbeat + integer(options, Setting::kHostNode),
       .bytes = 1,
       .once_a_bus = true,
       .share = share(1e9 / static_cast<double>(kHostHeartbeatNs))},
      {.what = "SYNC", .id = cob::kSync, .bytes = 0, .once_a_bus = true},
      {.what = "state", .id = cob::kTransmit1 + node, .bytes = 8, .reply = true}};
  if (Units(options).rad_s_per_velocity > 0.0) {
    frames.push_back({.what = "velocity", .id = cob::kTransmit2 + node, .bytes = 4, .reply = true});
  }
  frames.push_back({.what = "heartbeat",
                    .id = cob::kHeartbeat + node,
                    .bytes = 1,
                    .reply = true,
                    .share = share(1e3 / number(options, Setting::kHeartbeat)),
                    .unasked = true});
  return frames;
}

Family family() {
  return {
      .name = "cia402",
      .summary = "CANopen drives (CiA 301, CiA 402) in cyclic synchronous torque, CAN",
      .make_drive = [](const DriveOptions& options) -> std::unique_ptr<Drive> {
        return std::make_unique<Driver>(options);
      },
      .make_simulated = [](const DriveOptions& options) -> std::unique_ptr<SimulatedDrive> {
        return std::make_unique<Simulated>(options);
      },
      .decode = decode,
      .check = check,
      .error_name = error_name,
      .settings = settings(),
      .cyclic_frames = cyclic_frames,
      .position_period_rad =
          [](const DriveOptions& options) {
            if (choice<Turns>(options, Setting::kEncoderTurns) == Turns::kKept) {
              return 0.0;
            }
            return choice<Side>(options, Setting::kEncoderAt) == Side::kMotor
                       ? 2.0 * std::numbers::pi / Units(options).gear
                       : 2.0 * std::numbers::pi;
          },
      .make_scanner = [](bool fd) -> std::unique_ptr<Scanner> {
        return fd ? nullptr : std::make_unique<CanopenScanner>();
      },
      .make_zeroing = [](const DriveOptions& options) -> std::unique_ptr<Zeroing> {
        return std::make_unique<CanopenZeroing>(options);
      },
  };
}

}  // namespace geodesic::drivers::cia402
