// The order of one cycle: estimate, supervise, evaluate, law, bound. Each of them lives elsewhere;
// here is only who hears what from whom.
#include "control/controller.hpp"

#include <algorithm>
#include <stdexcept>
#include <string>

#include "control/estimate.hpp"
#include "control/law/law.hpp"
#include "control/mechanism/newton_euler.hpp"
#include "control/mechanism/workspace.hpp"
#include "control/safety/assess.hpp"
#include "control/safety/limits.hpp"

namespace geodesic::control {
namespace {

constexpr std::int64_t kLongestPeriod = 1'000'000'000;
constexpr std::int64_t kLatestInstant = std::int64_t{1} << 61;

void refuse_misfits(const Mechanism& mechanism, const ControllerOptions& options) {
  std::string text;
  for (const std::string& complaint : check(options)) {
    text += (text.empty() ? "" : "; ") + complaint;
  }
  const std::vector<std::string>& names = mechanism.joint_names();
  if (mechanism.floating()) {
    text += (text.empty() ? "" : "; ") +
            std::string("the mechanism's base floats; the controller needs one that is fixed");
  } else if (names.size() != options.joints.size()) {
    text += (text.empty() ? "" : "; ") + std::string("the mechanism has ") +
            std::to_string(names.size()) + " joints, the options have " +
            std::to_string(options.joints.size());
  } else {
    for (std::size_t i = 0; i < names.size(); ++i) {
      if (names[i] != options.joints[i].name) {
        text += (text.empty() ? "" : "; ") + std::string("joint ") + std::to_string(i) + " is '" +
                names[i] + "' in the mechanism and '" + options.joints[i].name +
                "' in the options; list the options in the mechanism's order";
      }
    }
  }
  if (!text.empty()) {
    throw std::invalid_argument(text);
  }
}

Mechanism checked(Mechanism mechanism, const ControllerOptions& options) {
  refuse_misfits(mechanism, options);
  return mechanism;
}

SupervisorOptions supervisor_options(const ControllerOptions& options) {
  return {options.joints.size(), options.start_active, options.safety};
}

}  // namespace

struct Controller::Impl {
  Impl(Mechanism mechanism_in, const ControllerOptions& options_in)
      : mechanism(checked(std::move(mechanism_in), options_in)),
        workspace(mechanism),
        options(options_in),
        supervisor(supervisor_options(options_in)),
        joints(options_in.joints.size()),
        law(options_in.law),
        estimator(options_in) {
    command.joints = joints;
    report.law = law;
  }

  const ArmCommand& update(const ArmState& state, std::int64_t period_ns) noexcept;
  void take_request(Flags& flags, const Estimate& estimate) noexcept;
  void decide(const ArmState& state, const Estimate& estimate) noexcept;
  void evaluate(const Estimate& estimate, std::int64_t tick_ns, std::int64_t period_ns) noexcept;
  void write_command(const ArmState& state, const Estimate& estimate, double period_s) noexcept;
  double wanted_torque(std::size_t joint, const Estimate& estimate) const noexcept;
  void write_torque(std::size_t joint, double wanted, double period_s) noexcept;

  const Mechanism mechanism;
  Workspace workspace;
  const ControllerOptions options;
  const SupervisorOptions supervisor;
  const std::size_t joints;

  LawKind law;
  Request request;
  Estimator estimator;
  SupervisorMemory memory;
  BoundFindings bounds;
  std::array<double, kMaxJoints> acting_position{};  ///< when the torque will act
  std::array<double, kMaxJoints> reference{};        ///< position at entry into the law
  std::array<double, kMaxJoints> last_torque{};      ///< as it left in the last cycle
  ArmCommand command;
  ControllerReport report;
};

/// Turns what an operator asked for into flags, or into a reason why not.
void Controller::Impl::take_request(Flags& flags, const Estimate& estimate) noexcept {
  const Request asked = request;
  request = Request{};
  report.refused = nullptr;
  if (asked.kind == Request::Kind::kStop) {
    flags.stop_requested = true;
    return;
  }
  if (asked.kind != Request::Kind::kLaw) {
    return;
  }
  if (asked.law > LawKind::kZero) {
    report.refused = "there is no such law";
  } else if (asked.law == LawKind::kZero && !options.allow_zero_law) {
    report.refused =
        "law zero lets the arm fall and is for simulation only: set allow_zero_law in the "
        "configuration";
  } else if (memory.state == SupervisorState::kStopping ||
             memory.state == SupervisorState::kLowering) {
    report.refused = "the arm is being stopped: ask again when the state is off or fault";
  } else {
    flags.law_requested = true;
    law = asked.law;
    reference = estimate.position;
  }
}

void Controller::Impl::decide(const ArmState& state, const Estimate& estimate) noexcept {
  Flags flags = assess(options, state, estimate, bounds);
  take_request(flags, estimate);
  const std::int64_t now_ns = std::clamp<std::int64_t>(state.tick_ns, 0, kLatestInstant);
  const SupervisorDecision decision = supervise(supervisor, memory, flags, now_ns);
  memory = decision.memory;

  report.state = memory.state;
  report.law = law;
  report.authority = memory.authority;
  report.restart_drives = decision.restart_drives;
  report.events = decision.events;
  for (std::size_t i = 0; i < decision.events; ++i) {
    report.event[i] = decision.event[i];
    add_evidence(report.event[i], options, state, estimate, bounds, memory);
  }
}

/// The model where the arm will be when the torque acts; zero as long as the pose is not known.
/// What is computed now leaves at the next tick and stays for a period: in the middle of it,
/// gravity as of now would be 1.5 periods old, which is a damping of -1.5 period * dg/dq, negative
/// above the shoulder: a big arm would gather speed by itself.
void Controller::Impl::evaluate(const Estimate& estimate, std::int64_t tick_ns,
                                std::int64_t period_ns) noexcept {
  report.position = estimate.position;
  report.velocity = estimate.velocity;
  if (estimate.known != first(joints)) {
    report.model_torque.fill(0.0);
    return;
  }
  const std::int64_t acts_ns =
      std::clamp<std::int64_t>(tick_ns, 0, kLatestInstant) + period_ns + period_ns / 2;
  const double ahead_s = 1e-9 * static_cast<double>(std::clamp<std::int64_t>(
                                    acts_ns - estimate.instant_ns, 0, 2 * period_ns));
  for (std::size_t i = 0; i < joints; ++i) {
    acting_position[i] = estimate.position[i] + ahead_s * estimate.velocity[i];
  }
  const auto size = static_cast<Eigen::Index>(joints);
  const Eigen::Map<const Eigen::VectorXd> q(acting_position.data(), size);
  const Eigen::Map<const Eigen::VectorXd> v(estimate.velocity.data(), size);
  Eigen::Map<Eigen::VectorXd>(report.model_torque.data(), size) = bias(mechanism, workspace, q, v);
}

double Controller::Impl::wanted_torque(std::size_t joint, const Estimate& estimate) const noexcept {
  const JointTuning& tuning = options.joints[joint];
  const LawInput input{estimate.position[joint], estimate.velocity[joint],
                       report.model_torque[joint], reference[joint]};
  const double wall = wall_torque(tuning, input.position, input.velocity);
  switch (memory.state) {
    case SupervisorState::kActive:
      return memory.authority * (law_torque(law, tuning, input) + wall);
    case SupervisorState::kStopping: {
      // Compensation as far as it had come; the damping whole, since it only ever brakes.
      const double damping = damp_torque(tuning, input) - input.model_torque;
      return memory.authority * (input.model_torque + wall) + damping;
    }
    case SupervisorState::kLowering:
      return memory.authority * (input.model_torque + wall);
    default:
      return 0.0;
  }
}

void Controller::Impl::write_torque(std::size_t joint, double wanted, double period_s) noexcept {
  const JointTuning& tuning = options.joints[joint];
  const BoundedTorque bounded = bound_torque(tuning, wanted, last_torque[joint], period_s);
  JointCommand& out = command.joint[joint];
  out.torque = bounded.torque;
  bounds.wanted[joint] = wanted;
  bounds.saturated |= bounded.saturated ? bit(joint) : 0;
  if (!bounded.finite) {
    bounds.not_finite |= bit(joint);
    out.damping = tuning.drive_damping;
  }
}

void Controller::Impl::write_command(const ArmState& state, const Estimate& estimate,
                                     double period_s) noexcept {
  const bool torque_flows = makes_torque(memory.state) && !memory.drives_only;
  const BitSet failed = failed_drives(memory);
  const BitSet silent = silent_joints(supervisor, memory);
  bounds.saturated = 0;
  bounds.not_finite = 0;
  for (std::size_t i = 0; i < joints; ++i) {
    const DriveCondition condition =
        i < state.joints ? state.joint[i].condition : DriveCondition::kUnknown;
    JointCommand& out = command.joint[i];
    out.mode = drive_mode(memory, i, condition);
    out.torque = 0.0;
    out.position = estimate.position[i];
    out.velocity = 0.0;
    out.stiffness = 0.0;
    // A joint that is not seen cannot be damped from here; its drive may still hear us.
    const bool drive_damps = memory.state == SupervisorState::kLowering ||
                             (makes_torque(memory.state) && has(silent, i));
    out.damping = drive_damps && !has(failed, i) ? options.joints[i].drive_damping : 0.0;
    if (torque_flows && !has(failed, i)) {
      write_torque(i, wanted_torque(i, estimate), period_s);
    }
    last_torque[i] = out.torque;
  }
}

const ArmCommand& Controller::Impl::update(const ArmState& state, std::int64_t period_ns) noexcept {
  const std::int64_t period = std::clamp<std::int64_t>(period_ns, 1, kLongestPeriod);
  const SupervisorState before = memory.state;
  const Estimate& estimate = estimator.update(state, period);
  decide(state, estimate);
  if (report.restart_drives) {
    estimator.reset();  // what was measured before the dialogues began anew may not hold any more
  }
  evaluate(estimate, state.tick_ns, period);
  if (before != SupervisorState::kActive) {
    reference = estimate.position;
  }
  write_command(state, estimate, static_cast<double>(period) * 1e-9);
  return command;
}

Controller::Controller(Mechanism mechanism, const ControllerOptions& options)
    : impl_(std::make_unique<Impl>(std::move(mechanism), options)) {}

Controller::~Controller() = default;

const ArmCommand& Controller::update(const ArmState& state, std::int64_t period_ns) noexcept {
  return impl_->update(state, period_ns);
}

void Controller::request(const Request& request) noexcept {
  if (impl_->request.kind != Request::Kind::kStop) {
    impl_->request = request;
  }
}

const ControllerReport& Controller::report() const noexcept {
  return impl_->report;
}

}  // namespace geodesic::control
