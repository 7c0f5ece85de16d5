// The RobStride family for the table: checks of options, names of errors, frames of a cycle. See
// family.hpp; frames in words are in words.cpp.
#include "drivers/robstride/family.hpp"

#include <fmt/format.h>

#include <cmath>
#include <memory>
#include <numbers>

#include "drivers/robstride/driver.hpp"
#include "drivers/robstride/scanner.hpp"
#include "drivers/robstride/settings.hpp"
#include "drivers/robstride/simulated.hpp"
#include "drivers/robstride/zeroing.hpp"

namespace geodesic::drivers::robstride {

namespace {

constexpr std::int64_t kLeastWatchdogNs = 1'000'000;
constexpr std::int64_t kMostWatchdogNs = 10'000'000'000;

const char* reported_fault(unsigned bit) {
  switch (bit) {
    case 0:
      return "motor over-temperature (type 21, bit 0)";
    case 1:
      return "driver chip (type 21, bit 1)";
    case 2:
      return "under-voltage (type 21, bit 2)";
    case 3:
      return "over-voltage (type 21, bit 3)";
    case 4:
      return "phase B over-current (type 21, bit 4)";
    case 5:
      return "phase C over-current (type 21, bit 5)";
    case 7:
      return "encoder not calibrated (type 21, bit 7)";
    case 8:
      return "hardware identification (type 21, bit 8)";
    case 9:
      return "position initialisation (type 21, bit 9)";
    case 14:
      return "stall or overload (type 21, bit 14)";
    case 16:
      return "phase A over-current (type 21, bit 16)";
    default:
      return "a fault of a type 21 report that is not documented";
  }
}

}  // namespace

const char* error_name(std::uint8_t code) {
  switch (code) {
    case 1:
      return "under-voltage";
    case 2:
      return "over-current";
    case 3:
      return "over-temperature";
    case 4:
      return "magnetic encoder";
    case 5:
      return "stall or overload (CyberGear: Hall encoder)";
    case 6:
      return "not calibrated";
    case kRebooted:
      return "the drive was switched off and on (it told its identity unasked)";
    case kLeftRunMode:
      return "left run mode without a fault (its watchdog expired, or somebody stopped it)";
    default:
      return code >= kFirstReported && code < kFirstReported + 32
                 ? reported_fault(code - kFirstReported)
                 : "unknown error";
  }
}

std::vector<std::string> check(const DriveOptions& options) {
  std::vector<std::string> wrong;
  if (options.id < 1 || options.id > kLastMotor) {
    wrong.push_back(
        fmt::format("the drive's id is 0x{:X}; it must be between 1 and 0x7F", options.id));
  }
  if (options.reply_id != 0) {
    wrong.push_back(fmt::format(
        "the drive's reply id is 0x{:X}; RobStride drives need none: leave it out, and set host_id "
        "where this host is not 253",
        options.reply_id));
  }
  const double host = options.settings.get(kSettings, kHostId);
  if (!(host >= 0.0 && host <= 255.0) || host != std::floor(host) ||
      (host > 0.0 && host <= static_cast<double>(kLastMotor))) {
    wrong.push_back(fmt::format(
        "host_id is {}; it must be 0 or between 128 and 255, since 1 to 127 are motors", host));
  }
  if (options.fd) {
    wrong.emplace_back(
        "RobStride drives speak classic CAN and destroy CAN FD frames: set fd = false for this "
        "bus");
  }
  const auto range = [&wrong](const char* what, double value, const char* unit) {
    if (!std::isfinite(value) || value <= 0.0) {
      wrong.push_back(
          fmt::format("the drive's {} is {} {}; it must be the one of its manual (not of sample "
                      "code, which differs), above 0",
                      what, value, unit));
    }
  };
  const Ranges ranges = ranges_of(options);
  range("position range", ranges.position_rad, "rad");
  range("velocity range", ranges.velocity_rad_s, "rad/s");
  range("torque range", ranges.torque_nm, "N·m");
  range("stiffness_range_nm_rad", ranges.stiffness_nm_rad, "N·m/rad");
  range("damping_range_nm_s_rad", ranges.damping_nm_s_rad, "N·m·s/rad");
  const double limit = options.settings.get(kSettings, kTorqueLimit);
  if (!(limit >= 0.0 && limit <= ranges.torque_nm)) {
    wrong.push_back(
        fmt::format("torque_limit_nm is {} N·m; it must be between 0 and the torque range, {} N·m",
                    limit, ranges.torque_nm));
  }
  const double firmware = options.settings.get(kSettings, kLeastFirmware);
  if (!(firmware >= 0.0 && firmware <= 99'999'999.0)) {
    wrong.push_back(
        fmt::format("least_firmware is {}; it must be between 0 and 99999999", firmware));
  }
  if (options.watchdog_ns < kLeastWatchdogNs || options.watchdog_ns > kMostWatchdogNs) {
    wrong.push_back(
        fmt::format("the drive's watchdog time is {} ms; it must be between 1 ms and 10 s",
                    static_cast<double>(options.watchdog_ns) * 1e-6));
  }
  return wrong;
}

Family family() {
  return {
      .name = "robstride",
      .summary = "RobStride RS00 to RS06, EduLite EL05 and Xiaomi CyberGear, private protocol",
      .make_drive = [](const DriveOptions& options) -> std::unique_ptr<Drive> {
        return std::make_unique<Driver>(options);
      },
      .make_simulated = [](const DriveOptions& options) -> std::unique_ptr<SimulatedDrive> {
        return std::make_unique<Simulated>(options);
      },
      .decode = decode,
      .check = check,
      .error_name = error_name,
      .settings = kSettings,
      .cyclic_frames = [](const DriveOptions& options, double) -> std::vector<CyclicFrame> {
        const Link link = link_of(options);
        constexpr std::uint32_t kZeroTorque = 0x7FFF;
        const std::uint32_t running = static_cast<std::uint32_t>(Mode::kRun) << 14U;
        return {{.what = "torque",
                 .id = identifier(Type::kControl, kZeroTorque, link.motor),
                 .extended = true},
                {.what = "state",
                 .id = identifier(Type::kFeedback, running | link.motor, link.host),
                 .extended = true,
                 .reply = true}};
      },
      .position_period_rad = [](const DriveOptions&) { return 2.0 * std::numbers::pi; },
      .make_scanner = [](bool fd) -> std::unique_ptr<drivers::Scanner> {
        return fd ? nullptr : std::make_unique<Scanner>();
      },
      .make_zeroing = [](const DriveOptions& options) -> std::unique_ptr<drivers::Zeroing> {
        return std::make_unique<Zeroing>(options);
      },
  };
}

}  // namespace geodesic::drivers::robstride
