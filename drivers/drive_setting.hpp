// An option that one drive family alone has (torque constant, mode of operation, rated torque),
// declared once: the configuration reads it, the reference lists it, the drive uses it.
#pragma once

#include <array>
#include <cmath>
#include <cstddef>
#include <limits>
#include <span>
#include <string_view>

namespace geodesic::drivers {

/// One line of a family's table; its place in the table is its index in DriveSettings.
struct DriveSetting {
  std::string_view key;        ///< in [joint.drive], with its unit: "torque_constant_nm_a"
  std::string_view doc;        ///< one line
  std::string_view unit = {};  ///< empty: none
  double lower = -std::numeric_limits<double>::infinity();
  double upper = std::numeric_limits<double>::infinity();
  double value = 0.0;  ///< the default; with choices, the index of one
  bool required = false;
  std::span<const std::string_view> choices = {};  ///< what may be written instead of a number
};

inline constexpr std::size_t kMaxDriveSettings = 24;
inline constexpr double kNotSet = std::numeric_limits<double>::quiet_NaN();

/// Values in the order of the family's table; kNotSet: the default.
struct DriveSettings {
  std::array<double, kMaxDriveSettings> values = all_unset();

  double get(std::span<const DriveSetting> table, std::size_t index) const noexcept {
    return std::isnan(values[index]) ? table[index].value : values[index];
  }

  static constexpr std::array<double, kMaxDriveSettings> all_unset() {
    std::array<double, kMaxDriveSettings> unset{};
    unset.fill(kNotSet);
    return unset;
  }
};

}  // namespace geodesic::drivers
