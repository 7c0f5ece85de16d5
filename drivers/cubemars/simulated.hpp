// A CubeMars drive as the bus sees it, after the open mini-cheetah firmware and the vendor's
// manual. It shares the layout table with the codec and nothing else, so that a slip in one shows.
#pragma once

#include <cstddef>
#include <cstdint>
#include <span>

#include "drivers/cubemars/layout.hpp"
#include "drivers/drive.hpp"

namespace geodesic::drivers::cubemars {

/// Contracts as drivers::SimulatedDrive. What the sources leave open is decided in README.md.
class Simulated final : public SimulatedDrive {
 public:
  static constexpr std::int64_t kDeafNs = 1'000'000'000;  ///< after it was told to set its zero
  static constexpr double kOverTemperature = 100.0;       ///< [°C]

  static constexpr std::int64_t kBootNs = 200'000'000;  ///< silent after it was switched on

  /// A drive set up as `options` say (its watchdog by the vendor's tool), switched on at its zero.
  explicit Simulated(const DriveOptions& options);

  std::size_t receive(const Frame& frame, std::int64_t now_ns, std::span<Frame> out) override;
  std::size_t speak(std::int64_t now_ns, std::span<Frame> out) override;
  void set_shaft(double position_rad, double velocity_rad_s) override;
  double torque_nm(std::int64_t now_ns) override;
  bool enabled() const override { return running_ && !expired_; }
  void set_temperature(double celsius) override;
  void inject_error(std::uint8_t code) override;
  void power_cycle() override;

  /// As with the vendor's tool.
  void set_servo_mode(bool servo);
  void set_ranges(double velocity_rad_s, double torque_nm);
  void set_reply_bytes(std::uint8_t bytes) { reply_bytes_ = bytes; }
  void set_status_interval_ns(std::int64_t interval_ns) { status_interval_ns_ = interval_ns; }
  void set_watchdog_ns(std::int64_t watchdog_ns) { watchdog_ns_ = watchdog_ns; }

 private:
  struct Command {
    float position = 0.0F;
    float velocity = 0.0F;
    float stiffness = 0.0F;
    float damping = 0.0F;
    float torque = 0.0F;
  };

  bool boots(std::int64_t now_ns);
  void watch(std::int64_t now_ns);
  void fail(Error error);
  double measured_rad() const;
  std::size_t serve_mit(const Frame& frame, std::int64_t now_ns, Frame& out);
  void obey_servo(const Frame& frame, std::int64_t now_ns);
  Frame mit_reply(std::int64_t now_ns);
  Frame status(std::int64_t now_ns);
  Frame announcement(Function function) const;

  std::uint32_t id_;
  std::uint32_t reply_id_;
  float position_range_;
  float velocity_range_;
  float torque_range_;
  double gear_;
  double torque_per_ampere_nm_;
  double erpm_per_rad_s_;
  double degrees_per_radian_;
  double period_rad_;  ///< what it does not know when it is switched on
  double temperature_offset_c_;
  bool servo_;
  std::int64_t watchdog_ns_;
  std::uint8_t reply_bytes_ = reply::kWithError;
  std::int64_t status_interval_ns_ = 2'000'000;

  bool running_ = false;  ///< makes torque
  bool expired_ = false;  ///< by its watchdog, until the next command
  Error error_ = Error::kNone;
  Command command_;
  double current_a_ = 0.0;  ///< servo mode
  std::int64_t last_command_ns_ = 0;
  std::int64_t deaf_until_ns_ = 0;
  std::int64_t next_status_ns_ = 0;
  int announcements_due_ = 2;
  bool switched_on_ = false;  ///< and has not seen the time since
  std::int64_t boots_until_ns_ = 0;
  double shaft_rad_ = 0.0;
  double shaft_rad_s_ = 0.0;
  double zero_rad_ = 0.0;   ///< kept over power-off
  double turns_rad_ = 0.0;  ///< what the encoder did not see, since switched on
  double celsius_ = 25.0;
};

}  // namespace geodesic::drivers::cubemars
