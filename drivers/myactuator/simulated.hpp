// A MyActuator drive as the bus sees it, after the vendor's V4 manual and what users measured of
// its watchdog. It shares the layout table with the codec and nothing else, so that a slip shows.
#pragma once

#include <cstddef>
#include <cstdint>
#include <span>

#include "drivers/drive.hpp"
#include "drivers/myactuator/layout.hpp"

namespace geodesic::drivers::myactuator {

/// Contracts as drivers::SimulatedDrive. What the sources leave open is decided in README.md.
class Simulated final : public SimulatedDrive {
 public:
  static constexpr double kOverTemperature = 100.0;         ///< [°C]
  static constexpr std::int64_t kNoticeNs = 1'000'000'000;  ///< between two notices (0xF1)
  static constexpr std::uint32_t kFirmware = 20240315;

  static constexpr std::int64_t kBootNs = 200'000'000;  ///< silent after it was switched on

  /// A drive set up as `options` say but with its watchdog off, as it comes, switched on at its
  /// zero.
  explicit Simulated(const DriveOptions& options);

  std::size_t receive(const Frame& frame, std::int64_t now_ns, std::span<Frame> out) override;
  std::size_t speak(std::int64_t now_ns, std::span<Frame> out) override;
  void set_shaft(double position_rad, double velocity_rad_s) override;
  double torque_nm(std::int64_t now_ns) override;
  bool enabled() const override { return running_ && !tripped_ && errors_ == 0; }
  void set_temperature(double celsius) override;
  /// @param code  as DriveState::error: number of the error bit, counted from 1.
  void inject_error(std::uint8_t code) override;
  void power_cycle() override;

  std::uint32_t watchdog_ms() const { return watchdog_ms_; }
  bool brake_released() const { return brake_released_; }
  /// Another drive than the configuration says.
  void set_motion_ranges(double position_rad, double velocity_rad_s, double torque_nm);
  void set_firmware(std::uint32_t date) { firmware_ = date; }

 private:
  enum class Loop : std::uint8_t { kNone, kCurrent, kMotion };
  struct Motion {
    float position = 0.0F;
    float velocity = 0.0F;
    float stiffness = 0.0F;
    float damping = 0.0F;
    float torque = 0.0F;
  };

  bool boots(std::int64_t now_ns);
  void watch(std::int64_t now_ns);
  bool serve(const Frame& frame, std::int64_t now_ns, Frame& out);
  void obey_motion(const Frame& frame, std::int64_t now_ns, Frame& out);
  void put_loop_reply(std::int64_t now_ns, Frame& out);
  void stop();
  double angle_rad() const { return shaft_rad_ - zero_rad_ + turns_rad_; }
  double amperes(std::int64_t now_ns);
  std::uint8_t byte_of_celsius() const;

  std::uint32_t motor_;
  float position_range_;
  float velocity_range_;
  float torque_range_;
  float stiffness_range_;
  float damping_range_;
  double torque_per_ampere_nm_;
  double period_rad_;
  bool has_brake_;
  std::uint32_t firmware_ = kFirmware;

  std::uint32_t watchdog_ms_ = 0;  ///< in ROM, as are the next two
  bool saves_turns_ = false;
  double zero_rad_ = 0.0;
  double next_zero_rad_ = 0.0;  ///< takes effect at the next start

  bool running_ = false;
  bool tripped_ = false;  ///< by the watchdog, until somebody speaks
  bool brake_released_ = true;
  bool spoken_to_ = false;
  Loop loop_ = Loop::kNone;
  Motion motion_;
  double current_a_ = 0.0;
  std::uint16_t errors_ = 0;
  std::int64_t last_heard_ns_ = 0;
  std::int64_t next_notice_ns_ = 0;
  bool switched_on_ = false;  ///< and has not seen the time since
  std::int64_t boots_until_ns_ = 0;
  double shaft_rad_ = 0.0;
  double shaft_rad_s_ = 0.0;
  double turns_rad_ = 0.0;  ///< what was forgotten at power-off
  double celsius_ = 25.0;
};

}  // namespace geodesic::drivers::myactuator
