// A moteus drive as the bus sees it: registers, modes, watchdog, quantisation, console. It shares
// the layout table with the codec and nothing else, so that a slip in the codec's arithmetic shows.
#pragma once

#include <array>
#include <cstddef>
#include <cstdint>
#include <limits>
#include <span>
#include <string_view>

#include "drivers/drive.hpp"
#include "drivers/moteus/layout.hpp"

namespace geodesic::drivers::moteus {

/// Contracts as drivers::SimulatedDrive. What the sources leave open is decided in README.md.
class Simulated final : public SimulatedDrive {
 public:
  /// What `conf` reads and keeps; float32, as the drive has it.
  struct Config {
    float kp = 4.0F;   ///< servo.pid_position.kp [N·m/rev]
    float kd = 0.05F;  ///< servo.pid_position.kd [N·m·s/rev]
    float ratio = 1.0F;
    float output_offset = 0.0F;  ///< [rev], what cfg-set-output changes
    float default_timeout_s = 0.1F;
    float timeout_max_torque = 5.0F;
    float fault_temperature = 75.0F;
  };

  /// A drive that was set up as `options` say, switched on at its zero: it has counted every turn
  /// since, until power_cycle().
  explicit Simulated(const DriveOptions& options);

  std::size_t receive(const Frame& frame, std::int64_t now_ns, std::span<Frame> out) override;
  void set_shaft(double position_rad, double velocity_rad_s) override;
  double torque_nm(std::int64_t now_ns) override;
  bool enabled() const override;
  void set_temperature(double celsius) override;
  /// A fault code, or 11: the position time-out.
  void inject_error(std::uint8_t code) override;
  void power_cycle() override;

  std::uint8_t mode() const { return mode_; }
  std::uint8_t fault() const { return fault_; }
  const Config& config() const { return ram_; }
  /// In use and kept, as a vendor tool would change it.
  void set_config(const Config& config);
  void set_home(Home home) { home_ = home; }
  void set_register_map(std::int32_t version) { map_ = version; }
  /// The position it reports is NaN: no valid encoder.
  void lose_encoder() { encoder_lost_ = true; }
  /// The watchdog it was given last [s], and the torque it may make [N·m].
  float timeout_s() const { return command_.timeout_s; }
  float max_torque() const { return command_.max_torque; }

 private:
  static constexpr float kNone = std::numeric_limits<float>::quiet_NaN();
  struct Command {
    std::uint8_t mode = 0;
    float position = 0.0F;
    float velocity = 0.0F;
    float torque = 0.0F;
    float kp_scale = 1.0F;
    float kd_scale = 1.0F;
    float ilimit_scale = 1.0F;
    float max_torque = kNone;
    float timeout_s = 0.0F;
  };
  /// A value as it stood in a frame: an integer, or a float.
  struct Value {
    unsigned type = 0;
    std::int32_t integer = 0;
    float real = 0.0F;
  };
  struct Cursor;

  void advance(std::int64_t now_ns);
  void apply(std::int64_t now_ns);
  bool process(Cursor& cursor, Frame* reply);
  bool write_group(Cursor& cursor, unsigned code, Frame* reply);
  bool read_group(Cursor& cursor, unsigned code, Frame* reply);
  bool serve_stream(Cursor& cursor, std::uint8_t code, Frame* reply);
  std::uint32_t write_register(std::uint32_t number, const Value& value);
  bool read_register(std::uint32_t number, unsigned type, Frame& reply) const;
  void put_number(Frame& reply, unsigned type, float value, Quantity quantity) const;
  void obey_line(std::string_view line);
  void say(std::string_view text);
  float position() const;
  float made_torque() const;

  std::uint32_t id_;
  std::uint32_t prefix_;
  bool output_encoder_;
  float torque_range_;
  Config flash_;
  Config ram_;
  Home home_;
  std::int32_t map_ = kRegisterMapVersion;
  std::uint8_t mode_ = 0;
  std::uint8_t fault_ = 0;
  Command command_;
  Command running_;  ///< what the servo follows
  bool commanded_ = false;
  float control_rev_ = 0.0F;
  std::int64_t ready_ns_ = 0;  ///< when enabling is over
  std::int64_t expires_ns_ = 0;
  bool watched_ = false;
  bool encoder_lost_ = false;
  double shaft_rev_ = 0.0;
  double shaft_rev_s_ = 0.0;
  double base_rev_ = 0.0;  ///< shaft to position, without the output offset
  float celsius_ = 25.0F;
  std::array<char, 128> heard_{};
  std::size_t heard_size_ = 0;
  std::array<char, 128> said_{};
  std::size_t said_size_ = 0;
};

}  // namespace geodesic::drivers::moteus
