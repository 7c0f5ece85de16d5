// The options that CubeMars drives alone have, and what follows from them. Their place in the
// configuration is [joint.drive].
#pragma once

#include <array>
#include <cstddef>
#include <cstdint>
#include <numbers>
#include <string_view>

#include "drivers/drive.hpp"
#include "drivers/drive_setting.hpp"

namespace geodesic::drivers::cubemars {

enum Setting : std::size_t {
  kMode,
  kGearRatio,
  kEncoder,
  kTemperatureOffset,
  kTorqueConstant,
  kPolePairs,
  kPositionOf,
  kVelocityCheck,
};

inline constexpr std::array<std::string_view, 2> kModes = {"mit", "servo"};
inline constexpr std::array<std::string_view, 2> kEncoders = {"motor", "output"};
inline constexpr std::array<std::string_view, 2> kSides = {"output", "motor"};
inline constexpr std::array<std::string_view, 2> kOffOn = {"off", "on"};

inline constexpr std::array<DriveSetting, 8> kSettings = {{
    {.key = "mode",
     .doc = "CubeMars: the mode stored in the drive by the vendor's tool: mit or servo.",
     .unit = "",
     .choices = kModes},
    {.key = "gear_ratio",
     .doc = "CubeMars: motor turns per output turn (AK80-9: 9); which turn the drive is in when it "
            "is switched on hangs on it, in servo mode speed and torque too.",
     .unit = "",
     .lower = 1.0,
     .upper = 1000.0,
     .required = true},
    {.key = "encoder",
     .doc = "CubeMars: what the drive knows when it is switched on: the angle of the motor, or "
            "with a second encoder that of the output.",
     .unit = "",
     .choices = kEncoders},
    {.key = "temperature_offset_c",
     .doc = "CubeMars, MIT mode: added to the temperature byte; sources disagree (-40 or 0).",
     .unit = "°C",
     .lower = -100.0,
     .upper = 100.0,
     .value = -40.0},
    {.key = "torque_constant_nm_a",
     .doc = "CubeMars, servo mode, required there: motor torque per ampere, before the gear.",
     .unit = "N·m/A",
     .lower = 0.0,
     .upper = 100.0},
    {.key = "pole_pairs",
     .doc = "CubeMars, servo mode: pole pairs of the motor.",
     .unit = "",
     .lower = 1.0,
     .upper = 200.0,
     .value = 21.0},
    {.key = "position_of",
     .doc = "CubeMars, servo mode: whose angle the status report holds: the output's or the "
            "motor's.",
     .unit = "",
     .choices = kSides},
    {.key = "velocity_check",
     .doc = "CubeMars: refuse the drive when reported velocity and change of position contradict "
            "each other, as they do with a wrong velocity range.",
     .unit = "",
     .value = 1.0,
     .choices = kOffOn},
}};

/// What the settings come to.
struct Facts {
  explicit Facts(const DriveOptions& options) noexcept
      : servo(get(options, kMode) == 1.0),
        gear(get(options, kGearRatio)),
        output_encoder(get(options, kEncoder) == 1.0),
        temperature_offset_c(get(options, kTemperatureOffset)),
        torque_per_ampere_nm(get(options, kTorqueConstant) * gear),
        radians_per_degree(std::numbers::pi / 180.0 /
                           (get(options, kPositionOf) == 1.0 ? gear : 1.0)),
        rad_s_per_erpm(2.0 * std::numbers::pi / 60.0 / (get(options, kPolePairs) * gear)),
        velocity_check(get(options, kVelocityCheck) == 1.0) {}

  static double get(const DriveOptions& options, Setting setting) noexcept {
    return options.settings.get(kSettings, setting);
  }

  bool servo;
  double gear;
  bool output_encoder;
  double temperature_offset_c;
  double torque_per_ampere_nm;  ///< at the output
  double radians_per_degree;    ///< of the output, per degree that the status reports
  double rad_s_per_erpm;        ///< of the output
  bool velocity_check;
};

/// Power-on loses whole multiples of this [rad at the output].
inline double position_period_rad(const DriveOptions& options) noexcept {
  const Facts facts(options);
  const double turn = 2.0 * std::numbers::pi;
  return facts.output_encoder || !(facts.gear >= 1.0) ? turn : turn / facts.gear;
}

}  // namespace geodesic::drivers::cubemars
