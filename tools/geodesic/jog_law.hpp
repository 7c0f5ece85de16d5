// How much torque a jogged joint gets, and when none: dead-man, bounds on torque, velocity and
// travel, and what ends the jogging. Pure decisions: no clock, no input, no bus.
#pragma once

#include <cstdint>
#include <string>

#include "control/joint.hpp"

namespace geodesic::tools {

/// All at the joint: rad or m, N·m or N.
struct JogOptions {
  double torque = 0.0;    ///< bound; more is never commanded
  double velocity = 0.0;  ///< bound: torque fades out towards it, and brakes beyond
  double lower = 0.0;     ///< travel: no torque pushes further than these
  double upper = 0.0;
  double overrun = 0.05;  ///< this far beyond the travel is a fault
  double temperature_limit_c = 85.0;
  std::int64_t period_ns = 1'000'000;
};

/// What the person asks for: by a key held down, or by lines that keep coming.
struct JogRequest {
  double torque = 0.0;        ///< signed; 0: nothing
  std::int64_t stamp_ns = 0;  ///< when it arrived
};

enum class JogPhase : std::uint8_t {
  kIdle,      ///< disabled, no torque
  kEnabling,  ///< asked to enable, not confirmed; no torque
  kPushing,   ///< enabled, torque as far as the bounds allow
  kFault,     ///< for good: disabled, no torque
};

class JogLaw {
 public:
  static constexpr std::int64_t kDeadManNs = 200'000'000;
  static constexpr std::int64_t kRampNs = 200'000'000;      ///< torque fades in over this
  static constexpr std::int64_t kEnableNs = 1'000'000'000;  ///< the drive has so long
  static constexpr std::int64_t kDisableNs = 500'000'000;   ///< and so long to let go
  static constexpr std::int64_t kSilentNs =
      20'000'000;  ///< or five periods: no position, no torque
  static constexpr std::int64_t kHeldUpNs = 50'000'000;  ///< this program itself was not running
  static constexpr double kOverspeed = 2.0;              ///< times the velocity bound is a fault
  static constexpr double kApproach = 2.0;  ///< velocity allowed at a distance from the end [1/s]

  explicit JogLaw(const JogOptions& options) : options_(options) {}

  /// One cycle. @param joint  as last reported    @param request  the last that arrived
  control::JointCommand update(std::int64_t now_ns, const control::JointState& joint,
                               const JogRequest& request);

  /// Ends it from outside (a bus that is lost, another drive enabled). The first reason stays.
  void fail(std::string reason);

  JogPhase phase() const { return phase_; }
  const std::string& reason() const { return reason_; }
  double torque() const { return torque_; }  ///< last commanded

 private:
  void judge(std::int64_t now_ns, const control::JointState& joint);
  void follow(std::int64_t now_ns, const control::JointState& joint, bool wanted);
  double push(std::int64_t now_ns, const control::JointState& joint, double asked);

  JogOptions options_;
  JogPhase phase_ = JogPhase::kIdle;
  std::string reason_;
  double torque_ = 0.0;
  double sign_ = 0.0;          ///< of the push under way
  std::int64_t since_ns_ = 0;  ///< the phase began
  std::int64_t ramp_ns_ = 0;   ///< the push began, or turned round
  std::int64_t last_ns_ = 0;
};

const char* to_string(JogPhase phase);

}  // namespace geodesic::tools
