// The ODrive family for people: checks of options, the frames of a cycle. See family.hpp.
#include "drivers/odrive/family.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <memory>

#include "drivers/odrive/driver.hpp"
#include "drivers/odrive/errors.hpp"
#include "drivers/odrive/scanner.hpp"
#include "drivers/odrive/simulated.hpp"
#include "drivers/odrive/words.hpp"
#include "drivers/odrive/zeroing.hpp"

namespace geodesic::drivers::odrive {

namespace {

constexpr std::int64_t kLeastWatchdogNs = 5'000'000;
constexpr std::int64_t kMostWatchdogNs = 10'000'000'000;
constexpr double kSlowPeriodS = 0.1;

void check_endpoints(const Settings& settings, std::vector<std::string>& wrong) {
  const bool any = std::any_of(settings.endpoint.begin(), settings.endpoint.end(),
                               [](std::uint16_t id) { return id != 0; });
  if (any && settings.firmware == Firmware::k05) {
    wrong.emplace_back("endpoints are given, but firmware 0.5 has none on CAN: remove them");
  }
  if (any && settings.firmware == Firmware::k06 && settings.revision == 0) {
    wrong.emplace_back(
        "endpoints are given without endpoint_revision: their ids differ between firmware builds, "
        "so say which one they are of (9 for 0.6.9)");
  }
  if (settings.knows(Parameter::kWatchdogTimeout) != settings.knows(Parameter::kEnableWatchdog)) {
    wrong.emplace_back(
        "endpoint_watchdog_timeout and endpoint_enable_watchdog: found one, expected both or none");
  }
  for (std::size_t i = 0; i < settings.endpoint.size(); ++i) {
    for (std::size_t k = 0; k < i; ++k) {
      if (settings.endpoint[i] != 0 && settings.endpoint[i] == settings.endpoint[k]) {
        wrong.push_back(
            fmt::format("two endpoints have the id {}: look them up again", settings.endpoint[i]));
      }
    }
  }
}

}  // namespace

std::vector<std::string> check(const DriveOptions& options) {
  const Settings settings(options);
  std::vector<std::string> wrong;
  if (options.id > kLastNode) {
    wrong.push_back(fmt::format(
        "the drive's id (node_id) is {}; it must be between 0 and {} (63: not addressed yet)",
        options.id, kLastNode));
  }
  if (options.reply_id != 0) {
    wrong.push_back(fmt::format(
        "the drive's reply_id is 0x{:X}; an ODrive answers on its own node's identifiers: leave it "
        "out",
        options.reply_id));
  }
  if (options.fd && settings.firmware == Firmware::k05) {
    wrong.emplace_back(
        "the bus carries CAN FD, which the controller of an ODrive with firmware 0.5 takes for "
        "errors: use a classic bus");
  }
  const auto range = [&wrong](const char* what, double value, const char* unit) {
    if (!std::isfinite(value) || value <= 0.0) {
      wrong.push_back(
          fmt::format("the drive's {} is {} {}; it must be above 0", what, value, unit));
    }
  };
  range("velocity_range_rad_s", options.velocity_range_rad_s, "rad/s");
  range("torque_range_nm", options.torque_range_nm, "N·m");
  range("torque_constant_nm_a", settings.torque_constant_nm_a, "N·m/A");
  range("current_limit_a", settings.current_limit_a, "A");
  const double most_nm = settings.torque_constant_nm_a * settings.current_limit_a;
  if (options.torque_range_nm > most_nm * (1.0 + 1e-9)) {
    wrong.push_back(fmt::format(
        "torque_range_nm is {} N·m, but current_limit_a times torque_constant_nm_a is {:.6g} N·m: "
        "the drive would silently give less than it is asked for",
        options.torque_range_nm, most_nm));
  }
  if (settings.velocity_limit_rad_s < settings.least_velocity_limit_rad_s * (1.0 - 1e-9)) {
    wrong.push_back(fmt::format(
        "velocity_limit_rad_s is {} rad/s: at velocity_range_rad_s the drive would silently give "
        "less than torque_range_nm, since it bounds torque by velocity_gain_nm_s_rev times what is "
        "left to its limit; expected at least {:.6g} rad/s, or 0",
        settings.velocity_limit_rad_s, settings.least_velocity_limit_rad_s));
  }
  if (settings.firmware == Firmware::k05 && settings.torque_feedback == TorqueFeedback::kTorques) {
    wrong.emplace_back(
        "firmware 0.5 has no Get_Torques: torque_feedback can be \"iq\" or \"none\"");
  }
  if (options.watchdog_ns < kLeastWatchdogNs || options.watchdog_ns > kMostWatchdogNs) {
    wrong.push_back(
        fmt::format("the drive's watchdog time is {} ms; it must be between 5 ms and 10 s",
                    static_cast<double>(options.watchdog_ns) * 1e-6));
  }
  check_endpoints(settings, wrong);
  return wrong;
}

std::vector<CyclicFrame> cyclic_frames(const DriveOptions& options, double rate_hz) {
  const Settings settings(options);
  const auto id = [&options](Command command) { return frame_id(options.id, command); };
  const auto share = [rate_hz](double period_s) {
    return std::clamp(1.0 / (period_s * std::max(rate_hz, 1e-9)), 0.0, 1.0);
  };
  const Firmware firmware = settings.firmware;
  const Command seldom = firmware == Firmware::k06 ? Command::kTemperature : Command::kError;
  const double slow = share(kSlowPeriodS);
  std::vector<CyclicFrame> frames;
  const auto command = [&](std::string_view what, Command which, std::uint8_t bytes, double part) {
    frames.push_back(
        {.what = what, .id = id(which), .bytes = bytes, .share = part, .classic = true});
  };
  const auto report = [&](std::string_view what, Command which, bool unasked, double part) {
    frames.push_back({.what = what,
                      .id = id(which),
                      .reply = true,
                      .share = part,
                      .unasked = unasked,
                      .classic = true});
  };
  command("slow request", seldom, 0, slow);
  if (settings.requests_torque()) {
    command("measured torque request", settings.torque_command(), 0, 1.0);
  }
  if (settings.by_request) {
    command("state request", Command::kEstimates, 0, 1.0);
  }
  command("torque", Command::kInputTorque, kSetInputTorque.length, 1.0);
  report("slow report", seldom, false, slow);
  if (settings.torque_feedback != TorqueFeedback::kNone) {
    report("measured torque", settings.torque_command(), settings.cyclic_torque(), 1.0);
  }
  report("state", Command::kEstimates, !settings.by_request, 1.0);
  report("heartbeat", Command::kHeartbeat, true, share(settings.heartbeat_ms() * 1e-3));
  return frames;
}

Family family() {
  return {
      .name = "odrive",
      .summary = "ODrive by CANSimple, firmware 0.6 (Pro, S1, Micro) and 0.5 (v3), classic CAN",
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
      .cyclic_frames = cyclic_frames,
      .position_period_rad =
          [](const DriveOptions& options) { return Settings(options).position_period_rev * kTurn; },
      .make_scanner = [](bool fd) -> std::unique_ptr<Scanner> {
        return fd ? nullptr : std::make_unique<OdriveScanner>();
      },
      .make_zeroing = [](const DriveOptions& options) -> std::unique_ptr<Zeroing> {
        return std::make_unique<OdriveZeroing>(options);
      },
  };
}

}  // namespace geodesic::drivers::odrive
