// What the robot file says of RobStride and CyberGear drives alone.
#pragma once

#include <array>
#include <cmath>
#include <cstddef>
#include <numbers>
#include <string_view>

#include "drivers/drive.hpp"
#include "drivers/drive_setting.hpp"
#include "drivers/robstride/codec.hpp"

namespace geodesic::drivers::robstride {

enum Setting : std::size_t {
  kVariant,
  kHostId,
  kStiffnessRange,
  kDampingRange,
  kTorqueLimit,
  kLeastFirmware,
};

inline constexpr std::array<std::string_view, 2> kVariants{"robstride", "cybergear"};

inline constexpr std::array kSettings = {
    DriveSetting{.key = "variant",
                 .doc = "RS00 to RS06 and EL05, or Xiaomi CyberGear",
                 .unit = "",
                 .choices = kVariants},
    DriveSetting{.key = "host_id",
                 .doc = "this host's id on the bus, 0 or 128 to 255",
                 .unit = "",
                 .lower = 0.0,
                 .upper = 255.0,
                 .value = 253.0},
    DriveSetting{.key = "stiffness_range_nm_rad",
                 .doc = "the drive's scaling of kp: 500 or 5000, see its manual",
                 .unit = "N·m/rad",
                 .lower = 1.0,
                 .upper = 1e6,
                 .required = true},
    DriveSetting{.key = "damping_range_nm_s_rad",
                 .doc = "the drive's scaling of kd: 5 or 100, see its manual",
                 .unit = "N·m·s/rad",
                 .lower = 0.01,
                 .upper = 1e6,
                 .required = true},
    DriveSetting{.key = "torque_limit_nm",
                 .doc = "written to limit_torque; 0: torque_range_nm",
                 .unit = "N·m",
                 .lower = 0.0,
                 .upper = 1e4},
    DriveSetting{.key = "least_firmware",
                 .doc = "refuse older: 0.0.2.6 is written 206; 0: any",
                 .unit = "",
                 .lower = 0.0,
                 .upper = 99'999'999.0},
};

inline bool is_cybergear(const DriveOptions& options) noexcept {
  return options.settings.get(kSettings, kVariant) != 0.0;
}

inline Link link_of(const DriveOptions& options) noexcept {
  return {.motor = static_cast<std::uint8_t>(options.id),
          .host = static_cast<std::uint8_t>(options.settings.get(kSettings, kHostId))};
}

inline Ranges ranges_of(const DriveOptions& options) noexcept {
  return {.position_rad = options.position_range_rad,
          .velocity_rad_s = options.velocity_range_rad_s,
          .torque_nm = options.torque_range_nm,
          .stiffness_nm_rad = options.settings.get(kSettings, kStiffnessRange),
          .damping_nm_s_rad = options.settings.get(kSettings, kDampingRange)};
}

inline double torque_limit_nm(const DriveOptions& options) noexcept {
  const double limit = options.settings.get(kSettings, kTorqueLimit);
  return limit > 0.0 ? limit : options.torque_range_nm;
}

/// Firmware that scales to 4 pi counts around and around in it; older ends at +-12.5.
inline bool wraps(double position_range_rad) noexcept {
  return std::abs(position_range_rad - 4.0 * std::numbers::pi) < 0.02;
}
inline constexpr double kWrapRad = 8.0 * std::numbers::pi;

}  // namespace geodesic::drivers::robstride
