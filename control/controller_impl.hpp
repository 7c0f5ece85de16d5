// The controller's inside, shared by the three files that implement it: the cycle
// (controller.cpp), what torque leaves (controller_torque.cpp), and the exchange of setups
// (controller_exchange.cpp). Nobody else includes it.
#pragma once

#include "control/controller.hpp"
#include "control/estimate.hpp"
#include "control/mechanism/workspace.hpp"
#include "control/retune.hpp"
#include "control/safety/assess.hpp"
#include "control/safety/supervise_arms.hpp"
#include "control/safety/watch.hpp"

namespace geodesic::control {

/// What observe() needs to know of the cycle that update() went through before it.
struct UnobservedCycle {
  bool waits = false;
  ArmState state;
  ArmCommand sent;                             ///< left at the beginning of the cycle
  std::array<double, kMaxJoints> model{};      ///< torque, of the cycle before
  std::array<double, kMaxJoints> authority{};  ///< of the cycle before
  BitSet active = 0;                           ///< joints a law ran on
  BitSet torque = 0;                           ///< joints torque flowed on
  std::int64_t period_ns = 0;
};

struct Controller::Impl {
  Impl(Mechanism mechanism, const ControllerOptions& options, const CompiledModel* compiled);

  const ArmCommand& update(const ArmState& state, std::int64_t period_ns) noexcept;
  void ask(const Request& request) noexcept;
  Requests take_requests(const Estimate& estimate) noexcept;
  void decide(const ArmState& state, const Estimate& estimate) noexcept;
  void report_arms() noexcept;
  void count_missing(const Estimate& estimate) noexcept;
  const Eigen::VectorXd& compensation(const Setup& by) noexcept;
  void evaluate(const Estimate& estimate, std::int64_t tick_ns, std::int64_t period_ns) noexcept;
  void note_cycle(const ArmState& state, std::int64_t period_ns) noexcept;
  void observe() noexcept;

  // controller_torque.cpp
  void write_command(const ArmState& state, double period_s) noexcept;
  double wanted_torque(std::size_t joint, double model_torque) const noexcept;
  void write_torque(std::size_t joint, double wanted, double period_s) noexcept;
  double lowering_scale(std::size_t joint) const noexcept;

  // controller_exchange.cpp
  bool takes(const Setup& next) const noexcept;
  const Setup* exchange(const Setup* next) noexcept;

  const ControllerOptions& options() const noexcept { return setup->options; }
  std::size_t arm_of(std::size_t joint) const noexcept { return arms.arm_of[joint]; }
  const SupervisorMemory& memory_of(std::size_t joint) const noexcept {
    return memory.arm[arm_of(joint)];
  }
  const SupervisorOptions& supervisor_of(std::size_t joint) const noexcept {
    return supervisor.arm[arm_of(joint)];
  }

  const Setup built_in;
  const Setup* setup = &built_in;
  const Setup* lent = nullptr;  ///< `setup`, if it is not built_in
  const Arms arms;
  Workspace workspace;
  RobotSupervisor supervisor;
  const std::size_t joints;

  std::array<LawKind, kMaxArms> law{};  ///< of each arm
  Requests asked;                       ///< since the last update
  std::array<LawKind, kMaxArms> asked_law{};
  bool asked_nonsense = false;
  Estimator estimator;
  RobotMemory memory;
  std::array<bool, kMaxArms> damps{};  ///< arms whose worst fault asks for the law damp
  BoundFindings bounds;
  Watch watch;
  UnobservedCycle unobserved;
  std::array<double, kMaxJoints> acting_position{};  ///< when the torque will act
  std::array<double, kMaxJoints> acting_velocity{};  ///< as far as Coriolis torque is compensated
  std::array<double, kMaxJoints> reference{};        ///< position at entry into the law
  std::array<double, kMaxJoints> last_torque{};      ///< as it left in the last cycle
  std::array<Retune, kMaxJoints> retune{};
  ArmCommand command;
  ControllerReport report;
};

}  // namespace geodesic::control
