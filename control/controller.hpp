// Joint states in, joint commands out: estimate, supervise, evaluate, law, bound. Pure: no I/O, no
// clock of its own, no allocation after construction; the same inputs give the same bits.
#pragma once

#include <array>
#include <cstdint>
#include <memory>

#include "control/joint.hpp"
#include "control/mechanism/mechanism.hpp"
#include "control/options.hpp"
#include "control/safety/supervisor.hpp"

namespace geodesic::control {

/// What an operator may ask for. Handed over between cycles.
struct Request {
  enum class Kind : std::uint8_t { kNone, kLaw, kStop } kind = Kind::kNone;
  LawKind law =
      LawKind::kFloat;  ///< kLaw: start it, or switch to it; from off or fault: start anew
};

/// What one update decided, for telemetry and for people. Valid until the next update.
struct ControllerReport {
  SupervisorState state = SupervisorState::kOff;
  LawKind law = LawKind::kFloat;
  double authority = 0.0;                     ///< 0..1, the ramp
  std::array<double, kMaxJoints> position{};  ///< at the common instant [rad or m]
  std::array<double, kMaxJoints> velocity{};  ///< at the common instant, filtered
  /// Gravity + Coriolis [N·m or N], at the pose predicted for when the torque will act.
  std::array<double, kMaxJoints> model_torque{};
  std::array<FaultEvent, kMaxEventsPerCycle> event{};  ///< raised in this update
  std::size_t events = 0;
  bool restart_drives = false;  ///< a start from off: the drives' dialogues begin anew
  /// Why the last request was not followed, a literal, in the update that refused it; else null.
  const char* refused = nullptr;
};

class Controller {
 public:
  /// @throws std::invalid_argument if options do not fit the mechanism. Not real-time.
  Controller(Mechanism mechanism, const ControllerOptions& options);
  ~Controller();
  Controller(const Controller&) = delete;
  Controller& operator=(const Controller&) = delete;

  /// One cycle. Real-time, O(joints). The command lives until the next call.
  const ArmCommand& update(const ArmState& state, std::int64_t period_ns) noexcept;

  /// Takes effect in the next update; of several, the last counts, but a stop is never overwritten.
  /// Same thread as update(). Real-time.
  void request(const Request& request) noexcept;

  const ControllerReport& report() const noexcept;

 private:
  struct Impl;
  std::unique_ptr<Impl> impl_;
};

}  // namespace geodesic::control
