// The options that MyActuator drives alone have, and what follows from them. Their place in the
// configuration is [joint.drive].
#pragma once

#include <array>
#include <cstddef>
#include <cstdint>
#include <numbers>
#include <string_view>

#include "drivers/drive.hpp"
#include "drivers/drive_setting.hpp"

namespace geodesic::drivers::myactuator {

enum Setting : std::size_t {
  kMode,
  kTorqueConstant,
  kBrake,
  kStiffnessRange,
  kDampingRange,
  kPowerOnPeriod,
  kOldestFirmware,
};

inline constexpr std::array<std::string_view, 2> kModes = {"torque", "motion"};
inline constexpr std::array<std::string_view, 2> kNoYes = {"no", "yes"};

inline constexpr std::array<DriveSetting, 7> kSettings = {{
    {.key = "mode",
     .doc = "MyActuator: torque (0xA1 and 0x92, two frames a cycle) or motion (0x400, one frame).",
     .unit = "",
     .choices = kModes},
    {.key = "torque_constant_nm_a",
     .doc = "MyActuator, mode torque, required there: torque at the output per ampere.",
     .unit = "N·m/A",
     .lower = 0.0,
     .upper = 1000.0},
    {.key = "brake",
     .doc = "MyActuator: the motor has a brake, to be released when enabled and locked when not.",
     .unit = "",
     .choices = kNoYes},
    {.key = "stiffness_range_nm_rad",
     .doc = "MyActuator, mode motion: what the highest code of stiffness means (500 or 1000).",
     .unit = "N·m/rad",
     .lower = 1e-3,
     .upper = 1e6,
     .value = 500.0},
    {.key = "damping_range_nm_s_rad",
     .doc = "MyActuator, mode motion: what the highest code of damping means (5, or 50 in V4.4).",
     .unit = "N·m·s/rad",
     .lower = 1e-3,
     .upper = 1e6,
     .value = 5.0},
    {.key = "power_on_period_deg",
     .doc = "MyActuator: what the drive forgets whole multiples of at power-off; 0 where it saves "
            "its turns (function 4).",
     .unit = "deg",
     .lower = 0.0,
     .upper = 360.0,
     .value = 360.0},
    {.key = "firmware_at_least",
     .doc = "MyActuator: refuse a drive whose version date (0xB2, YYYYMMDD) is earlier.",
     .unit = "",
     .lower = 0.0,
     .upper = 99991231.0},
}};

/// What the settings come to.
struct Facts {
  explicit Facts(const DriveOptions& options) noexcept
      : motion(get(options, kMode) == 1.0),
        torque_per_ampere_nm(get(options, kTorqueConstant)),
        brake(get(options, kBrake) == 1.0),
        power_on_period_rad(get(options, kPowerOnPeriod) * std::numbers::pi / 180.0),
        oldest_firmware(static_cast<std::uint32_t>(get(options, kOldestFirmware))),
        // Rounded up: a drive that is told 0 ms has no watchdog.
        watchdog_ms(static_cast<std::uint32_t>((options.watchdog_ns + 999'999) / 1'000'000)) {}

  static double get(const DriveOptions& options, Setting setting) noexcept {
    return options.settings.get(kSettings, setting);
  }

  bool motion;
  double torque_per_ampere_nm;
  bool brake;
  double power_on_period_rad;
  std::uint32_t oldest_firmware;
  std::uint32_t watchdog_ms;
};

inline constexpr double kDegree = std::numbers::pi / 180.0;

}  // namespace geodesic::drivers::myactuator
