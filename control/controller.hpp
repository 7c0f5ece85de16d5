// Joint states in, joint commands out: estimate, supervise, evaluate, law, bound. Pure: no I/O, no
// clock of its own, no allocation after construction; the same inputs give the same bits.
#pragma once

#include <array>
#include <cstdint>
#include <memory>

#include "control/joint.hpp"
#include "control/mechanism/mechanism.hpp"
#include "control/options.hpp"
#include "control/safety/static_check.hpp"
#include "control/safety/supervisor.hpp"
#include "control/setup.hpp"

namespace geodesic::control {

/// What an operator may ask for. Handed over between cycles.
struct Request {
  enum class Kind : std::uint8_t { kNone, kLaw, kStop } kind = Kind::kNone;
  LawKind law =
      LawKind::kFloat;  ///< kLaw: start it, or switch to it; from off or fault: start anew
  static constexpr int kAllArms = -1;
  int arm = kAllArms;  ///< number of the arm it concerns
};

/// Replies that a joint's drive owed while its arm was connected.
struct MissingReplies {
  std::uint32_t run = 0;      ///< in a row, until now
  std::uint32_t longest = 0;  ///< in a row, since the start
  std::uint64_t total = 0;    ///< since the start
};

struct ArmReport {
  SupervisorState state = SupervisorState::kOff;
  LawKind law = LawKind::kFloat;
  double authority = 0.0;
};

/// What one update decided, for telemetry and for people. Valid until the next update.
struct ControllerReport {
  /// Of the robot as a whole: the state of the arm in which most can move (see overall()), and that
  /// arm's law and authority.
  SupervisorState state = SupervisorState::kOff;
  LawKind law = LawKind::kFloat;
  double authority = 0.0;                 ///< 0..1, the ramp
  std::size_t arms = 1;                   ///< arm[0 .. arms) are valid
  std::array<ArmReport, kMaxArms> arm{};  ///< each by itself
  std::array<MissingReplies, kMaxJoints> missing{};
  std::array<double, kMaxJoints> position{};  ///< at the common instant [rad or m]
  std::array<double, kMaxJoints> velocity{};  ///< at the common instant, filtered
  /// Gravity + Coriolis [N·m or N], at the pose predicted for when the torque will act.
  std::array<double, kMaxJoints> model_torque{};
  std::array<double, kMaxJoints> external_torque{};  ///< observed [N·m or N]
  BitSet touched = 0;                                ///< joints in contact
  /// 0..1: what a vibration has left of damping, stiffness and friction compensation.
  std::array<double, kMaxJoints> gain{};
  std::array<StaticCheckState, kMaxJoints> static_check{};
  std::array<FaultEvent, kMaxEventsPerCycle> event{};  ///< raised in this update
  std::size_t events = 0;
  bool retuning = false;        ///< torque is on its way to an exchanged setup
  BitSet restart = 0;           ///< of which joints
  bool restart_drives = false;  ///< a start from off: the drives' dialogues begin anew
  /// Why the last request was not followed, a literal, in the update that refused it; else null.
  const char* refused = nullptr;
};

class Controller {
 public:
  /// @throws std::invalid_argument if options do not fit the mechanism. Not real-time.
  /// @param compiled  functions compiled for this mechanism, which outlive it; null: none
  Controller(Mechanism mechanism, const ControllerOptions& options,
             const CompiledModel* compiled = nullptr);
  ~Controller();
  Controller(const Controller&) = delete;
  Controller& operator=(const Controller&) = delete;

  /// One cycle. Real-time, O(joints). The command lives until the next call.
  const ArmCommand& update(const ArmState& state, std::int64_t period_ns) noexcept;

  /// Looks at the cycle that update() has just decided: external torque, contact, vibration, static
  /// check, stuck encoders. What it finds counts in the next update(), which otherwise does this
  /// first, with the same result to the bit: call it when the commands have been seen off. Same
  /// thread as update(). Real-time.
  void observe() noexcept;

  /// Takes effect in the next update; of several for an arm, the last counts, but a stop is never
  /// overwritten.
  /// Same thread as update(). Real-time.
  void request(const Request& request) noexcept;

  /// From the next update on, `next` counts: same joints, other tuning; unexchangeable() must have
  /// found nothing, and `next` must live until it is given back. Torque does not step: what the old
  /// setup made beyond the new one fades out linearly within retune_s, or as much slower as the
  /// joint's torque_rate_limit demands (retune.hpp has the bound). nullptr: the setup it was made
  /// with. Same thread as update(). Real-time.
  /// @return  the setup that was in use until now, nullptr if that was the one it was made with; or
  ///   `next` itself if it is refused, since with it the arm would be beyond its limits already.
  const Setup* exchange(const Setup* next) noexcept;

  const ControllerReport& report() const noexcept;

 private:
  struct Impl;
  std::unique_ptr<Impl> impl_;
};

}  // namespace geodesic::control
