// The options that moteus drives alone have, in [joint.drive]: their table and their names in code.
#pragma once

#include <array>
#include <cstdint>
#include <string_view>

#include "drivers/drive.hpp"
#include "drivers/moteus/layout.hpp"

namespace geodesic::drivers::moteus {

enum Setting : std::size_t { kResolution, kHome, kRatio, kKp, kKd, kHostId, kPrefix };

inline constexpr std::array<std::string_view, 2> kResolutions = {"compact", "float"};
inline constexpr std::array<std::string_view, 2> kHomes = {"output", "rotor"};

inline constexpr std::array<DriveSetting, 7> kSettings = {
    DriveSetting{.key = "resolution",
                 .doc = "Registers as integers of 16 bits, wider where their range asks for it, or "
                        "as floats.",
                 .unit = "",
                 .value = 0,
                 .choices = kResolutions},
    DriveSetting{.key = "home",
                 .doc = "What the drive's position must be referenced to at power-on (register "
                        "0x00C): the output, or one turn of the rotor.",
                 .unit = "",
                 .value = 0,
                 .choices = kHomes},
    DriveSetting{
        .key = "rotor_to_output_ratio",
        .doc = "The drive's motor_position.rotor_to_output_ratio (1/6 for 6:1); read back.",
        .unit = "",
        .lower = 1e-4,
        .upper = 100.0,
        .value = 1.0},
    DriveSetting{.key = "kp_nm_rev",
                 .doc =
                     "The drive's servo.pid_position.kp, read back: stiffness up to it is made in "
                     "the drive, the rest from here. 0: all from here.",
                 .unit = "N·m/rev",
                 .lower = 0.0,
                 .upper = 1e5,
                 .value = 0.0},
    DriveSetting{.key = "kd_nm_s_rev",
                 .doc = "The drive's servo.pid_position.kd, read back: damping up to it is made in "
                        "the drive, the rest from here. 0: all from here.",
                 .unit = "N·m·s/rev",
                 .lower = 0.0,
                 .upper = 1e5,
                 .value = 0.0},
    DriveSetting{.key = "host_id",
                 .doc = "This host's own identifier among the drives.",
                 .unit = "",
                 .lower = 0.0,
                 .upper = kLastId,
                 .value = 0.0},
    DriveSetting{.key = "can_prefix",
                 .doc = "The drive's can.prefix, bits 28 to 16 of every identifier.",
                 .unit = "",
                 .lower = 0.0,
                 .upper = kLastPrefix,
                 .value = 0.0},
};

inline double setting(const DriveOptions& options, Setting which) noexcept {
  return options.settings.get(kSettings, which);
}

inline std::uint32_t whole_setting(const DriveOptions& options, Setting which) noexcept {
  return static_cast<std::uint32_t>(setting(options, which));
}

}  // namespace geodesic::drivers::moteus
