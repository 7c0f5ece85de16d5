// A RobStride or CyberGear drive as the bus sees it: parameters, states, watchdog, quantisation. It
// shares the layout table with the codec and nothing else, so that a slip in the codec's arithmetic
// shows.
#pragma once

#include <array>
#include <cstddef>
#include <cstdint>
#include <optional>
#include <span>

#include "drivers/drive.hpp"
#include "drivers/robstride/layout.hpp"

namespace geodesic::drivers::robstride {

/// Contracts as drivers::SimulatedDrive. What the sources leave open is decided in README.md.
class Simulated final : public SimulatedDrive {
 public:
  /// A drive that was set up as `options` say, its watchdog off as it comes, switched on at its
  /// zero: it has counted every turn since, until power_cycle().
  explicit Simulated(const DriveOptions& options);

  std::size_t receive(const Frame& frame, std::int64_t now_ns, std::span<Frame> out) override;
  std::size_t speak(std::int64_t now_ns, std::span<Frame> out) override;
  void set_shaft(double position_rad, double velocity_rad_s) override;
  double torque_nm(std::int64_t now_ns) override;
  bool enabled() const override { return mode_ == Mode::kRun; }
  void set_temperature(double celsius) override;
  void inject_error(std::uint8_t code) override;
  void power_cycle() override;

  /// The value in use, and its change in flash and in use, as a vendor tool would do. Raw: an
  /// integer or the bits of a float32. Unknown parameters read 0 and do not change.
  std::uint32_t parameter_raw(std::uint16_t index) const;
  void set_parameter(std::uint16_t index, std::uint32_t raw);
  /// What the version query tells; nothing: it is answered as any stop.
  void set_version(std::optional<std::array<std::uint8_t, 4>> version) { version_ = version; }

 private:
  using Values = std::array<std::uint32_t, kParameters.size()>;

  struct Command {
    float position = 0.0F;
    float velocity = 0.0F;
    float stiffness = 0.0F;
    float damping = 0.0F;
    float torque = 0.0F;
  };
  struct Scale {
    float position = 1.0F;
    float velocity = 1.0F;
    float torque = 1.0F;
    float stiffness = 1.0F;
    float damping = 1.0F;
  };

  void switch_on();
  void watch(std::int64_t now_ns);
  void stop();
  bool heats() const;
  void take_command(const Frame& frame);
  bool obey(const Frame& frame, std::int64_t now_ns);
  void write(const Frame& frame);
  Frame answer_read(const Frame& frame) const;
  Frame feedback(std::int64_t now_ns);
  Frame say(std::uint32_t type, std::uint32_t data, std::uint32_t to) const;
  double turned() const;
  double reported_position() const;
  std::size_t place_of(Index index) const;
  float real(Index index) const;

  Scale scale_;
  bool cybergear_;
  bool wraps_;
  std::uint32_t motor_;
  std::uint32_t host_;  ///< who spoke to it last
  Values flash_{};
  Values ram_{};
  Mode mode_ = Mode::kReset;
  std::uint32_t faults_ = 0;
  Command command_;
  bool reports_ = false;
  std::int64_t next_report_ns_ = 0;
  std::int64_t last_command_ns_ = 0;
  bool identity_due_ = false;
  std::uint32_t report_due_ = 0;  ///< faults of a type 21 frame
  double shaft_rad_ = 0.0;
  double shaft_rad_s_ = 0.0;
  double zero_rad_ = 0.0;  ///< kept in flash once saved
  double saved_zero_rad_ = 0.0;
  double turns_rad_ = 0.0;  ///< whole turns that the encoder did not see, since switched on
  double celsius_ = 25.0;
  std::optional<std::array<std::uint8_t, 4>> version_{{0, 0, 2, 6}};
};

}  // namespace geodesic::drivers::robstride
