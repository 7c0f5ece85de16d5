// The family's options and what follows from them; see settings.hpp.
#include "drivers/cia402/settings.hpp"

#include <algorithm>
#include <cmath>
#include <numbers>
#include <string_view>

namespace geodesic::drivers::cia402 {

namespace {

constexpr std::array<std::string_view, 2> kSides = {"motor", "output"};
constexpr std::array<std::string_view, 2> kTurnsKept = {"lost", "kept"};
constexpr std::array<std::string_view, 2> kChecks = {"drive", "manual"};
constexpr std::array<std::string_view, 5> kVelocityUnits = {"from_position", "increments_per_s",
                                                            "rpm", "rpm_0.1", "rpm_0.001"};
constexpr std::array<std::string_view, 2> kReceiveTypes = {"sync", "at_once"};
constexpr std::array<std::string_view, 3> kReceiveTimers = {"if_there", "required", "off"};
constexpr std::array<std::string_view, 3> kReactions = {"fault", "disable_voltage", "quick_stop"};
constexpr std::array<std::string_view, 6> kQuickStops = {
    "disable", "slow_ramp", "quick_ramp", "current_limit", "voltage_limit", "as_it_is"};
constexpr std::array<std::string_view, 3> kResets = {"communication", "node", "none"};
constexpr double kMostCount = 4294967295.0;

constexpr std::array kSettings = {
    DriveSetting{.key = "host_node",
                 .doc = "CANopen node of this host: whose heartbeat the drive watches (0x1016).",
                 .lower = 1,
                 .upper = kLastNode,
                 .value = kLastNode},
    DriveSetting{.key = "encoder_increments",
                 .doc = "Increments of 0x6064 (0x608F:1), compared with the drive's.",
                 .lower = 1,
                 .upper = kMostCount,
                 .value = 65536,
                 .required = true},
    DriveSetting{.key = "encoder_revolutions",
                 .doc = "... in so many revolutions (0x608F:2).",
                 .lower = 1,
                 .upper = kMostCount,
                 .value = 1},
    DriveSetting{.key = "encoder_at",
                 .doc = "Whose revolutions 0x6064 and 0x606C count.",
                 .value = 0,
                 .choices = kSides},
    DriveSetting{.key = "encoder_turns",
                 .doc = "Whether the encoder's whole revolutions are kept over power-off.",
                 .value = 0,
                 .choices = kTurnsKept},
    DriveSetting{.key = "encoder_check",
                 .doc = "Where encoder_increments is from: 'manual' for a drive without 0x608F.",
                 .value = 0,
                 .choices = kChecks},
    DriveSetting{.key = "gear_motor_revolutions",
                 .doc = "Motor revolutions (0x6091:1), compared with the drive's.",
                 .lower = 1,
                 .upper = kMostCount,
                 .value = 1},
    DriveSetting{.key = "gear_shaft_revolutions",
                 .doc = "... for so many of the output shaft (0x6091:2).",
                 .lower = 1,
                 .upper = kMostCount,
                 .value = 1},
    DriveSetting{
        .key = "gear_check",
        .doc = "Where the gear is from: 'manual' for a drive whose 0x6091 is not its gear.",
        .value = 0,
        .choices = kChecks},
    DriveSetting{.key = "rated_torque_mnm",
                 .doc = "Rated torque (0x6076), compared with the drive's.",
                 .unit = "mN·m",
                 .lower = 1,
                 .upper = kMostCount,
                 .value = 10000,
                 .required = true},
    DriveSetting{.key = "rated_torque_at",
                 .doc = "On which side of the gear 0x6076 is meant.",
                 .value = 0,
                 .choices = kSides},
    DriveSetting{.key = "rated_torque_check",
                 .doc = "Where the rated torque is from: 'manual' for a drive without 0x6076.",
                 .value = 0,
                 .choices = kChecks},
    DriveSetting{.key = "velocity_unit",
                 .doc = "Unit of 0x606C; 'from_position': not read, velocity from positions.",
                 .value = 1,
                 .choices = kVelocityUnits},
    DriveSetting{.key = "torque_takes_effect",
                 .doc = "With the SYNC that follows (RPDO1 of type 1), or at once (type 255).",
                 .value = 0,
                 .choices = kReceiveTypes},
    DriveSetting{.key = "rpdo_timer",
                 .doc = "The drive's deadline for torque frames (0x1400:5), beside the heartbeat.",
                 .value = 0,
                 .choices = kReceiveTimers},
    DriveSetting{.key = "connection_lost",
                 .doc = "What the drive does when this host has gone silent (0x6007).",
                 .value = 0,
                 .choices = kReactions},
    DriveSetting{.key = "quick_stop",
                 .doc = "How the drive stops in a quick stop (0x605A).",
                 .value = 5,
                 .choices = kQuickStops},
    DriveSetting{.key = "heartbeat_ms",
                 .doc = "How often the drive says that it is alive (0x1017).",
                 .unit = "ms",
                 .lower = 5,
                 .upper = 1000,
                 .value = 20},
    DriveSetting{.key = "reset",
                 .doc = "How the start-up begins: which NMT reset, or none (pre-operational).",
                 .value = 0,
                 .choices = kResets},
    DriveSetting{.key = "vendor_id",
                 .doc = "0x1018:1 must be this; 0: any.",
                 .lower = 0,
                 .upper = kMostCount},
    DriveSetting{.key = "product_code",
                 .doc = "0x1018:2 must be this; 0: any.",
                 .lower = 0,
                 .upper = kMostCount},
    DriveSetting{.key = "least_revision",
                 .doc = "0x1018:3 must be at least this; 0: any.",
                 .lower = 0,
                 .upper = kMostCount},
};
static_assert(kSettings.size() <= kMaxDriveSettings);
static_assert(kSettings.size() == static_cast<std::size_t>(Setting::kLeastRevision) + 1);

constexpr double kTurn = 2.0 * std::numbers::pi;

}  // namespace

std::span<const DriveSetting> settings() noexcept {
  return kSettings;
}

Units::Units(const DriveOptions& options) noexcept {
  gear = number(options, Setting::kGearMotor) / number(options, Setting::kGearShaft);
  const double reduction = choice<Side>(options, Setting::kEncoderAt) == Side::kMotor ? gear : 1.0;
  rad_per_increment = kTurn * number(options, Setting::kEncoderRevolutions) /
                      number(options, Setting::kEncoderIncrements) / reduction;
  const double rpm = kTurn / 60.0 / reduction;
  switch (choice<VelocityUnit>(options, Setting::kVelocityUnit)) {
    case VelocityUnit::kFromPosition:
      break;
    case VelocityUnit::kIncrementsPerSecond:
      rad_s_per_velocity = rad_per_increment;
      break;
    case VelocityUnit::kRpm:
      rad_s_per_velocity = rpm;
      break;
    case VelocityUnit::kTenthRpm:
      rad_s_per_velocity = rpm * 0.1;
      break;
    case VelocityUnit::kMilliRpm:
      rad_s_per_velocity = rpm * 1e-3;
      break;
  }
  rated_nm = number(options, Setting::kRatedTorque) * 1e-3 *
             (choice<Side>(options, Setting::kRatedTorqueAt) == Side::kMotor ? gear : 1.0);
  max_torque_permille = static_cast<std::uint16_t>(
      std::clamp(std::round(options.torque_range_nm / rated_nm * 1e3), 1.0, 32767.0));
  watchdog_ms = static_cast<std::uint16_t>(
      std::clamp<std::int64_t>(options.watchdog_ns / 1'000'000, 1, 65535));
}

}  // namespace geodesic::drivers::cia402
