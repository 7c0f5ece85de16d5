// A Damiao drive as the bus sees it: registers, states, watchdog, quantisation. It shares the
// layout table with the codec and nothing else, so that a slip in the codec's arithmetic shows.
#pragma once

#include <array>
#include <cstddef>
#include <cstdint>
#include <span>

#include "drivers/damiao/layout.hpp"
#include "drivers/drive.hpp"

namespace geodesic::drivers::damiao {

/// Contracts as drivers::SimulatedDrive. What the sources leave open is decided in README.md.
class Simulated final : public SimulatedDrive {
 public:
  /// A drive that was set up as `options` say, its TIMEOUT at the usual 400 ms, switched on at its
  /// zero: it has counted every turn since, until power_cycle().
  explicit Simulated(const DriveOptions& options);

  std::size_t receive(const Frame& frame, std::int64_t now_ns, std::span<Frame> out) override;
  void set_shaft(double position_rad, double velocity_rad_s) override;
  double torque_nm(std::int64_t now_ns) override;
  bool enabled() const override;
  void set_temperature(double celsius) override;
  void inject_error(std::uint8_t code) override;
  void power_cycle() override;

  /// The value in use, and its change in flash and in use, as a vendor tool would do. Raw: a uint32
  /// or the bits of a float32. Unknown registers read 0 and do not change.
  std::uint32_t register_raw(std::uint8_t number) const;
  void set_register(std::uint8_t number, std::uint32_t raw);

 private:
  static constexpr std::size_t kRegisterSpace = 256;
  using Registers = std::array<std::uint32_t, kRegisterSpace>;

  struct Command {
    float position = 0.0F;
    float velocity = 0.0F;
    float stiffness = 0.0F;
    float damping = 0.0F;
    float torque = 0.0F;
  };

  void switch_on();
  void watch(std::int64_t now_ns);
  void fall_into(Status status);
  bool heats() const;
  void obey(const Frame& frame, std::int64_t now_ns);
  std::size_t serve_register(const Frame& frame, std::int64_t now_ns, Frame& out);
  double measured_position() const;
  Frame reply() const;
  Frame state_report(std::int64_t now_ns);
  float real(Register number) const;
  float scale(Register number) const;
  std::uint32_t integer(Register number) const;

  Registers flash_{};
  Registers ram_{};
  Status status_ = Status::kDisabled;
  Command command_;
  std::int64_t last_command_ns_ = 0;
  double shaft_rad_ = 0.0;
  double shaft_rad_s_ = 0.0;
  double zero_rad_ = 0.0;   ///< kept in flash
  double turns_rad_ = 0.0;  ///< whole turns that the encoder did not see, since switched on
  double celsius_ = 25.0;
  bool fd_ = false;  ///< as can_br said when it was switched on
};

}  // namespace geodesic::drivers::damiao
