// An ODrive axis as the bus sees it, firmware 0.6 or 0.5: states, error words, watchdog, timers,
// endpoints. It shares the layout table with the codec and nothing else, so that a slip in the
// codec's arithmetic shows.
#pragma once

#include <array>
#include <cstddef>
#include <cstdint>
#include <span>

#include "drivers/drive.hpp"
#include "drivers/odrive/layout.hpp"
#include "drivers/odrive/settings.hpp"

namespace geodesic::drivers::odrive {

/// Contracts as drivers::SimulatedDrive. What the sources leave open is decided in README.md.
class Simulated final : public SimulatedDrive {
 public:
  static constexpr std::int64_t kBootNs = 400'000'000;  ///< silent for so long after power-on

  /// An axis that is calibrated and set up as `options` say. What an endpoint is known of stands as
  /// it left the factory: no watchdog, positions every 10 ms.
  explicit Simulated(const DriveOptions& options);

  std::size_t receive(const Frame& frame, std::int64_t now_ns, std::span<Frame> out) override;
  std::size_t speak(std::int64_t now_ns, std::span<Frame> out) override;
  void set_shaft(double position_rad, double velocity_rad_s) override;
  double torque_nm(std::int64_t now_ns) override;
  bool enabled() const override { return state_ == kAxisClosedLoop; }
  void set_temperature(double celsius) override;
  void inject_error(std::uint8_t code) override;
  void power_cycle() override;

  /// As a vendor tool would: in use and kept.
  void set_parameter(Parameter parameter, double value);
  double parameter(Parameter parameter) const;
  void set_firmware_revision(std::uint8_t revision) { revision_ = revision; }
  /// Whether set-points feed the watchdog of an idle axis; always with 0.5.
  void set_idle_feeding(bool feeds) { idle_feeding_ = feeds; }
  /// The encoder has lost its position, as told in reports.
  void set_estimate_valid(bool valid) { estimate_valid_ = valid; }
  std::uint8_t axis_state() const { return state_; }
  double velocity_limit_rev_s() const { return ram_.velocity_limit_rev_s; }
  double current_limit_a() const { return ram_.current_limit_a; }

 private:
  /// What a drive keeps when it is told to save.
  struct Config {
    std::array<double, kParameterCount> parameters{};
    double velocity_limit_rev_s = 2.0;
    double current_limit_a = 10.0;
    std::uint32_t control_mode = 3;
    std::uint32_t input_mode = 1;
    double offset_rev = 0.0;
  };
  struct Errors {
    std::uint32_t axis = 0;  ///< 0.6: active errors
    std::uint32_t disarm = 0;
    std::uint64_t motor = 0;
    std::uint32_t encoder = 0;
    std::uint32_t controller = 0;
    bool any() const { return (axis | motor | encoder | controller) != 0; }
  };

  bool old() const { return settings_.firmware == Firmware::k05; }
  bool awake(std::int64_t now_ns);
  void watch(std::int64_t now_ns);
  void feed(std::int64_t now_ns) { fed_ns_ = now_ns; }
  void fail(std::uint32_t axis_bits);
  void request_state(std::uint32_t state, std::int64_t now_ns);
  void obey(const Frame& frame, std::int64_t now_ns);
  std::size_t serve_sdo(const Frame& frame, std::span<Frame> out);
  bool report(Command command, std::int64_t now_ns, Frame& out);
  double position_rev() const;
  double current_a(std::int64_t now_ns);
  bool hot() const { return celsius_ > 100.0; }

  std::uint32_t node_;
  Settings settings_;
  Config flash_;
  Config ram_;
  Errors errors_;
  std::uint8_t state_ = kAxisIdle;
  std::uint8_t result_ = 0;
  std::uint8_t revision_ = 9;
  bool idle_feeding_ = true;
  bool estimate_valid_ = true;
  bool booting_ = false;
  std::int64_t ready_ns_ = -1;
  std::int64_t fed_ns_ = -1;
  std::int64_t cleared_ns_ = -1'000'000'000;
  float input_torque_nm_ = 0.0F;
  double shaft_rev_ = 0.0;
  double shaft_rev_s_ = 0.0;
  double turns_rev_ = 0.0;  ///< what its encoder did not see, since switched on
  double celsius_ = 25.0;
  std::array<std::int64_t, 3> next_ns_{-1, -1, -1};  ///< heartbeat, estimates, torque
};

}  // namespace geodesic::drivers::odrive
