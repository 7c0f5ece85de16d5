// Positions and velocities of all joints at one common instant, from measurements that arrived one
// after the other. Only kinematics of single joints; the model is not used here.
#pragma once

#include <array>
#include <cstdint>

#include "control/joint.hpp"
#include "control/options.hpp"

namespace geodesic::control {

/// What is known of the arm at `instant_ns`. All numbers are finite.
struct Estimate {
  std::int64_t instant_ns = 0;                    ///< the newest receive stamp there is
  std::array<double, kMaxJoints> position{};      ///< [rad or m]
  std::array<double, kMaxJoints> velocity{};      ///< low-passed [rad/s or m/s]
  std::array<double, kMaxJoints> step{};          ///< newest measured step of position [rad or m]
  std::array<double, kMaxJoints> allowed_step{};  ///< what velocity and the options allow it to be
  std::uint32_t known = 0;       ///< joints measured at least once since reset; bit i
  std::uint32_t fresh = 0;       ///< joints measured in this cycle, plausibly
  std::uint32_t jumped = 0;      ///< joints whose step is larger than allowed, in this cycle
  std::uint32_t not_finite = 0;  ///< joints that reported what no joint can have, in this cycle
};

/// A measured figure beyond this is no measurement, whatever the unit.
inline constexpr double kImplausible = 1e6;

/// The memory between the cycles. A joint that misses answers is extrapolated for
/// SafetyOptions::carry_on_cycles periods, then taken to be at rest. Deterministic: the same inputs
/// give the same bits.
class Estimator {
 public:
  /// Not real-time.
  explicit Estimator(const ControllerOptions& options);

  /// Takes over other options for the same joints; what has been measured stands. Real-time.
  void retune(const ControllerOptions& options) noexcept;

  /// Trusts these joints no more: the next measurement of each is taken as it is. Until then the
  /// last positions stand, at rest and not `known`.
  void reset(std::uint32_t joints = ~std::uint32_t{0}) noexcept;

  /// Takes one cycle's measurements. A joint's velocity begins at its first measurement (no rise
  /// from zero); the low pass is v += a (measured - v), a = w dt / (1 + w dt), w = 2 pi f, with dt
  /// between the joint's own stamps. Real-time, O(joints).
  const Estimate& update(const ArmState& state, std::int64_t period_ns) noexcept;

  /// What the last update() gave. Real-time.
  const Estimate& estimate() const noexcept { return estimate_; }

 private:
  struct Joint {
    double position = 0.0;  ///< as last measured
    double velocity = 0.0;  ///< as last measured
    double filtered = 0.0;
    std::int64_t stamp_ns = 0;
    int missed = 0;
    double velocity_limit = 0.0;
  };

  void measure(std::size_t index, const JointState& measured) noexcept;
  void predict(std::size_t index, std::int64_t period_ns) noexcept;

  std::size_t joints_;
  double filter_rad_s_ = 0.0;
  double encoder_jump_ = 0.0;
  int carry_on_cycles_ = 0;
  std::array<Joint, kMaxJoints> joint_{};
  Estimate estimate_;
};

}  // namespace geodesic::control
