// For every drive family a drive as it may stand on a bench, in the one table that the rules for
// all families and the fuzz targets read. A new family adds its entries; one without any fails a
// test.
#pragma once

#include <cstdint>
#include <ostream>
#include <stdexcept>
#include <string>
#include <string_view>
#include <utility>
#include <vector>

#include "drivers/families.hpp"

namespace geodesic::drivers::test {

struct FamilyBench {
  std::string name;  ///< letters, digits and _
  std::string_view family;
  DriveOptions options = {};
  /// The family's own settings by key; of a choice, its index.
  std::vector<std::pair<std::string_view, double>> settings = {};
  double step_nm = 0.0;  ///< what a command's torque may be off by: half a code is due, one allowed
  std::uint8_t error = 0;        ///< one that the family can have
  bool always_on = false;        ///< it knows no enabling: commands are all there is to it
  bool commands_enable = false;  ///< any command does, one without torque too
  bool tells_its_state = true;   ///< its reports say whether it is enabled
  bool clears_errors = true;     ///< else only switching it off and on does
  /// What a drive may have otherwise than `options` say so that it is refused; null: it tells
  /// nothing of itself that could.
  void (*contradict)(DriveOptions&) = nullptr;

  const Family& of() const { return *find_family(family); }
  friend void PrintTo(const FamilyBench& bench, std::ostream* out) { *out << bench.name; }
};

inline void put_setting(DriveOptions& options, std::string_view key, double value) {
  const Family& family = *find_family(options.family);
  for (std::size_t i = 0; i < family.settings.size(); ++i) {
    if (family.settings[i].key == key) {
      options.settings.values[i] = value;
      return;
    }
  }
  throw std::logic_error("no setting " + std::string(key) + " in family " + options.family);
}

namespace benches {

/// Ranges in rad, rad/s, N·m.
inline DriveOptions options(std::uint32_t id, double position, double velocity, double torque) {
  DriveOptions made;
  made.id = id;
  made.position_range_rad = position;
  made.velocity_range_rad_s = velocity;
  made.torque_range_nm = torque;
  made.watchdog_ns = 50'000'000;
  made.leader = true;
  return made;
}

inline DriveOptions with(DriveOptions made, std::uint32_t reply_id, bool fd) {
  made.reply_id = reply_id;
  made.fd = fd;
  return made;
}

inline std::vector<FamilyBench> table() {
  const auto stronger = [](DriveOptions& drive) { drive.torque_range_nm *= 2.0; };
  const auto older = [](DriveOptions& drive) {
    put_setting(drive, "firmware_at_least", 20200101.0);
  };
  return {
      {.name = "damiao",
       .family = "damiao",
       .options = with(options(0x05, 12.5, 30.0, 10.0), 0x15, false),
       .step_nm = 20.0 / 4095.0,
       .error = 10,
       .contradict = stronger},
      {.name = "damiao_fd",
       .family = "damiao",
       .options = with(options(0x05, 12.5, 30.0, 10.0), 0x15, true),
       .step_nm = 20.0 / 4095.0,
       .error = 10,
       .contradict = stronger},
      {.name = "cubemars_mit",
       .family = "cubemars",
       .options = options(0x05, 12.5, 50.0, 18.0),
       .settings = {{"gear_ratio", 9.0}},
       .step_nm = 36.0 / 4095.0,
       .error = 1,
       .tells_its_state = false,
       .clears_errors = false},
      {.name = "cubemars_servo",
       .family = "cubemars",
       .options = options(0x05, 0.0, 50.0, 18.0),
       .settings =
           {{"gear_ratio", 9.0}, {"mode", 1.0}, {"encoder", 1.0}, {"torque_constant_nm_a", 0.115}},
       .step_nm = 0.115 * 9.0 * 0.001,
       .error = 1,
       .always_on = true,
       .tells_its_state = false,
       .clears_errors = false},
      {.name = "myactuator_current",
       .family = "myactuator",
       .options = options(0x03, 0.0, 45.0, 24.0),
       .settings = {{"torque_constant_nm_a", 2.0}, {"firmware_at_least", 20240315.0}},
       .step_nm = 2.0 * 0.01,
       .error = 5,
       .tells_its_state = false,
       .contradict = older},
      {.name = "myactuator_motion",
       .family = "myactuator",
       .options = options(0x03, 12.5, 45.0, 24.0),
       .settings = {{"mode", 1.0}, {"firmware_at_least", 20240315.0}},
       .step_nm = 48.0 / 4095.0,
       .error = 5,
       .commands_enable = true,
       .tells_its_state = false,
       .contradict = older},
      {.name = "robstride",
       .family = "robstride",
       .options = options(0x05, 12.57, 44.0, 17.0),
       .settings = {{"stiffness_range_nm_rad", 500.0}, {"damping_range_nm_s_rad", 5.0}},
       .step_nm = 34.0 / 65535.0,
       .error = 2,
       .contradict = stronger},
      {.name = "cybergear",
       .family = "robstride",
       .options = options(0x7F, 12.5, 30.0, 12.0),
       .settings = {{"variant", 1.0},
                    {"stiffness_range_nm_rad", 500.0},
                    {"damping_range_nm_s_rad", 5.0}},
       .step_nm = 24.0 / 65535.0,
       .error = 2,
       .contradict = stronger},
      {.name = "odrive",
       .family = "odrive",
       .options = options(0x05, 0.0, 60.0, 2.0),
       .settings = {{"torque_constant_nm_a", 0.1}, {"current_limit_a", 25.0}},
       .step_nm = 1e-6,
       .error = 1,
       .contradict = [](DriveOptions& drive) { put_setting(drive, "firmware", 1.0); }},
      {.name = "odrive_05",
       .family = "odrive",
       .options = options(0x05, 0.0, 60.0, 2.0),
       .settings = {{"torque_constant_nm_a", 0.1},
                    {"current_limit_a", 25.0},
                    {"firmware", 1.0},
                    {"feedback", 1.0}},
       .step_nm = 1e-6,
       .error = 1,
       .contradict = [](DriveOptions& drive) { put_setting(drive, "firmware", 0.0); }},
      {.name = "moteus",
       .family = "moteus",
       .options = with(options(0x05, 0.0, 40.0, 10.0), 0, true),
       .settings = {{"rotor_to_output_ratio", 1.0}},
       .step_nm = 0.01,
       .error = 34,
       .contradict = [](DriveOptions& drive) { put_setting(drive, "rotor_to_output_ratio", 0.5); }},
      {.name = "moteus_float",
       .family = "moteus",
       .options = with(options(0x05, 0.0, 40.0, 10.0), 0, true),
       .settings = {{"resolution", 1.0}, {"rotor_to_output_ratio", 1.0}},
       .step_nm = 1e-6,
       .error = 34,
       .contradict = [](DriveOptions& drive) { put_setting(drive, "rotor_to_output_ratio", 0.5); }},
      {.name = "cia402",
       .family = "cia402",
       .options = options(0x03, 0.0, 6.0, 42.0),
       .settings = {{"encoder_increments", 16384.0},
                    {"encoder_turns", 1.0},
                    {"gear_motor_revolutions", 100.0},
                    {"rated_torque_mnm", 280.0}},
       .step_nm = 0.028,
       .error = 1,
       .contradict = [](DriveOptions& drive) { put_setting(drive, "encoder_increments", 8192.0); }},
  };
}

}  // namespace benches

/// Those of the families there are, their options complete.
inline std::vector<FamilyBench> family_benches() {
  std::vector<FamilyBench> all;
  for (FamilyBench& bench : benches::table()) {
    if (find_family(bench.family) != nullptr) {
      bench.options.family = bench.family;
      for (const auto& [key, value] : bench.settings) {
        put_setting(bench.options, key, value);
      }
      all.push_back(std::move(bench));
    }
  }
  return all;
}

}  // namespace geodesic::drivers::test
