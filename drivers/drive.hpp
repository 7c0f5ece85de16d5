// A drive family's two sides of the bus, seen alike by all who use them: Drive (this host talks to
// it) and SimulatedDrive (stands in for it). Drive side of the gear: what the drive itself calls
// position and torque. drivers/families.hpp lists the families.
#pragma once

#include <cmath>
#include <cstdint>
#include <memory>
#include <span>
#include <string>
#include <vector>

#include "control/joint.hpp"
#include "drivers/bus/bus.hpp"
#include "drivers/bus/frame.hpp"
#include "drivers/drive_setting.hpp"

namespace geodesic::drivers {

/// What the configuration says of one drive; every figure is compared with the drive's own.
struct DriveOptions {
  std::string family;                     ///< as in families.hpp
  std::uint32_t id = 0;                   ///< where the drive listens
  std::uint32_t reply_id = 0;             ///< where it answers; 0 where the family knows
  bool fd = false;                        ///< the bus carries CAN FD with bit-rate switch
  double position_range_rad = 0.0;        ///< the drive's scaling: codes span +-this (Damiao PMAX)
  double velocity_range_rad_s = 0.0;      ///< (VMAX); without scaling, the most that can be
  double torque_range_nm = 0.0;           ///< (TMAX); without scaling, the most ever asked for
  std::int64_t watchdog_ns = 50'000'000;  ///< the drive stops on its own after this without command
  bool clear_errors = false;              ///< clear an error the drive already has at start-up
  bool error_diffusion = false;           ///< carry a torque code's rounding into the next cycle
  bool leader = false;     ///< the last of its family on its bus: sends what is the whole bus'
  DriveSettings settings;  ///< the family's own, in the order of Family::settings
};

/// A drive as it last reported, in its own coordinates.
struct DriveState {
  double position_rad = 0.0;
  double velocity_rad_s = 0.0;
  double torque_nm = 0.0;
  double temperature_c = 0.0;
  std::int64_t stamp_ns = 0;
  control::DriveCondition condition = control::DriveCondition::kUnknown;
  std::uint8_t error = 0;
};

/// A command in the drive's own coordinates; meaning as control::JointCommand.
struct DriveCommand {
  control::DriveMode mode = control::DriveMode::kMonitor;
  double torque_nm = 0.0;
  double position_rad = 0.0;
  double velocity_rad_s = 0.0;
  double stiffness_nm_rad = 0.0;
  double damping_nm_s_rad = 0.0;
};

inline bool is_finite(const DriveCommand& command) noexcept {
  return std::isfinite(command.torque_nm) && std::isfinite(command.position_rad) &&
         std::isfinite(command.velocity_rad_s) && std::isfinite(command.stiffness_nm_rad) &&
         std::isfinite(command.damping_nm_s_rad);
}

/// Why a drive was refused, or what it will not become. Texts are string literals.
struct DriveComplaint {
  const char* quantity = nullptr;  ///< e.g. "PMAX (register 21) [rad]"; null: no complaint
  double found = 0.0;
  double expected = 0.0;
  const char* fix = nullptr;  ///< what to do about it
};

/// Host side of one drive: a state machine that is asked for this cycle's frames and shown every
/// frame that carries its identifier. Real-time throughout: no allocation, no system call, bounded.
class Drive {
 public:
  virtual ~Drive() = default;

  /// This cycle's frames for the drive: the start-up dialogue until it is configured, then what
  /// `command` asks for. At most kMaxFramesPerCycle. A non-finite command is never encoded: the
  /// drive gets zero torque with damping instead, and complaint() says so.
  /// @return how many frames were written to `out`.
  static constexpr std::size_t kMaxFramesPerCycle = 4;
  virtual std::size_t transmit(const DriveCommand& command, std::int64_t now_ns,
                               std::span<Frame> out) noexcept = 0;

  /// How many of the `frames` that the last transmit() wrote bring an answer each.
  virtual std::size_t answers_due(std::size_t frames) const noexcept { return frames; }

  /// The drive also reports by its own timer, so that more may come than was asked for.
  virtual bool speaks_unasked() const noexcept { return false; }

  /// A frame on an identifier that drives share (IdFilter::shared) is this one's.
  virtual bool claims(const Frame& /*frame*/) const noexcept { return true; }

  /// @return true if the frame was a state report of this drive and state() is new.
  virtual bool receive(const ReceivedFrame& received) noexcept = 0;

  virtual const DriveState& state() const noexcept = 0;
  virtual const DriveComplaint& complaint() const noexcept = 0;

  /// Begins again at power-on: forgets what was read back and every latched refusal.
  virtual void restart() noexcept = 0;

  /// Identifiers this drive answers on and is commanded by. Not real-time.
  virtual std::vector<IdFilter> reply_ids() const = 0;
  virtual std::vector<IdFilter> command_ids() const = 0;

 protected:
  Drive() = default;
  Drive(const Drive&) = default;
  Drive& operator=(const Drive&) = default;
};

/// The drive seen from the bus. Not real-time, but allocates nothing once built.
class SimulatedDrive {
 public:
  virtual ~SimulatedDrive() = default;

  static constexpr std::size_t kMaxReplies = 4;
  /// Shows it a frame on the bus that arrived at now_ns. @return replies written to `out`, which
  /// has room for kMaxReplies.
  virtual std::size_t receive(const Frame& frame, std::int64_t now_ns, std::span<Frame> out) = 0;

  /// What it sends unasked (boot-up, heartbeat, reports by its own timer) and is due by now_ns;
  /// asked at least once a millisecond. @return frames written to `out`, of kMaxReplies.
  virtual std::size_t speak(std::int64_t /*now_ns*/, std::span<Frame> /*out*/) { return 0; }

  /// Physics moved the output shaft; the drive measures (and quantises) it from here.
  virtual void set_shaft(double position_rad, double velocity_rad_s) = 0;

  /// Torque on the output shaft [N·m] at now_ns by the last command, the drive's state and its
  /// own watchdog; 0 when disabled.
  virtual double torque_nm(std::int64_t now_ns) = 0;

  virtual bool enabled() const = 0;
  virtual void set_temperature(double celsius) = 0;
  /// Falls into the family's error `code` as the real drive would, torque off.
  virtual void inject_error(std::uint8_t code) = 0;
  /// Off and on: everything volatile is lost.
  virtual void power_cycle() = 0;

 protected:
  SimulatedDrive() = default;
  SimulatedDrive(const SimulatedDrive&) = default;
  SimulatedDrive& operator=(const SimulatedDrive&) = default;
};

}  // namespace geodesic::drivers
