// The order of one cycle: estimate, supervise, evaluate, law, bound. Each of them lives elsewhere;
// here is only who hears what from whom.
#include "control/controller.hpp"

#include <algorithm>
#include <stdexcept>
#include <string>

#include "control/controller_impl.hpp"
#include "control/mechanism/newton_euler.hpp"

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
  } else if (!mechanism.one_chart()) {
    for (const Factor& factor : mechanism.factors()) {
      if (factor.nv > 1) {
        text += (text.empty() ? "" : "; ") + std::string("joint '") + factor.name + "' is " +
                kind_name(factor.kind) + "; the controller needs joints with one degree of freedom";
      }
    }
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
  if (text.empty()) {
    for (const std::string& complaint : check_arms(options, mechanism)) {
      text += (text.empty() ? "" : "; ") + complaint;
    }
  }
  if (!text.empty()) {
    throw std::invalid_argument(text);
  }
}

Setup checked(Mechanism mechanism, const ControllerOptions& options,
              const CompiledModel* compiled) {
  refuse_misfits(mechanism, options);
  return {options, std::move(mechanism), compiled};
}

}  // namespace

Controller::Impl::Impl(Mechanism mechanism, const ControllerOptions& options_in,
                       const CompiledModel* compiled)
    : built_in(checked(std::move(mechanism), options_in, compiled)),
      arms(arms_of(options_in)),
      workspace(built_in.mechanism),
      supervisor(robot_supervisor(options_in)),
      joints(options_in.joints.size()),
      estimator(options_in),
      watch(built_in.mechanism) {
  law.fill(options_in.law);
  command.joints = joints;
  report.arms = arms.count;
  report_arms();
}

void Controller::Impl::ask(const Request& request) noexcept {
  const bool all = request.arm == Request::kAllArms;
  const auto one = static_cast<std::size_t>(std::max(request.arm, 0));
  asked_nonsense |= !all && (request.arm < 0 || one >= arms.count);
  const BitSet concerned =
      (all ? first(arms.count) : bit(std::min<std::size_t>(one, 31))) & first(arms.count);
  if (request.kind == Request::Kind::kStop) {
    asked.stop |= concerned;
  } else if (request.kind == Request::Kind::kLaw) {
    asked.law |= concerned;
    for (std::size_t a = 0; a < arms.count; ++a) {
      asked_law[a] = has(concerned, a) ? request.law : asked_law[a];
    }
  }
}

/// Turns what operators asked for into what the supervisors are asked, or into a reason why not.
Requests Controller::Impl::take_requests(const Estimate& estimate) noexcept {
  Requests taken = asked;
  taken.law &= ~taken.stop;
  report.refused = asked_nonsense ? "there is no such arm" : nullptr;
  asked = Requests{};
  asked_nonsense = false;
  const BitSet wanted = taken.law;
  for (std::size_t a = 0; a < arms.count; ++a) {
    if (!has(wanted, a)) {
      continue;
    }
    const SupervisorState state = memory.arm[a].state;
    if (asked_law[a] > LawKind::kZero) {
      report.refused = "there is no such law";
    } else if (asked_law[a] == LawKind::kZero && !options().allow_zero_law) {
      report.refused =
          "law zero lets the arm fall and is for simulation only: set allow_zero_law in the "
          "configuration";
    } else if (state == SupervisorState::kStopping || state == SupervisorState::kLowering) {
      report.refused = "the arm is being stopped: ask again when the state is off or fault";
    } else {
      continue;
    }
    taken.law = 0;  // all of them or none
  }
  for (std::size_t i = 0; i < joints; ++i) {
    if (has(taken.law, arm_of(i))) {
      law[arm_of(i)] = asked_law[arm_of(i)];
      reference[i] = estimate.position[i];
    }
  }
  if (taken.law != 0) {
    watch.recover();
  }
  return taken;
}

void Controller::Impl::decide(const ArmState& state, const Estimate& estimate) noexcept {
  Flags flags = assess(options(), state, estimate, bounds);
  watch.add_to(flags);
  const Requests requests = take_requests(estimate);
  const std::int64_t now_ns = std::clamp<std::int64_t>(state.tick_ns, 0, kLatestInstant);
  const RobotDecision decision = supervise_arms(supervisor, memory, flags, requests, now_ns);

  for (std::size_t a = 0; a < arms.count; ++a) {
    damps[a] = worst_action(supervisor.arm[a], memory.arm[a]) == Action::kDamp;
  }
  report.restart = decision.restart;
  report.restart_drives = decision.restart != 0;
  report.events = decision.events;
  for (std::size_t i = 0; i < decision.events; ++i) {
    report.event[i] = decision.event[i];
    add_evidence(report.event[i], options(), state, estimate, bounds,
                 memory.arm[static_cast<std::size_t>(decision.event[i].arm)]);
    watch.add_evidence(report.event[i], options());
  }
  report_arms();
  count_missing(estimate);
}

/// Keeps what observe() will need, before anything of it is decided anew.
void Controller::Impl::note_cycle(const ArmState& state, std::int64_t period_ns) noexcept {
  unobserved.waits = true;
  unobserved.state.tick_ns = state.tick_ns;
  unobserved.state.joints = state.joints;
  std::copy_n(state.joint.begin(), joints, unobserved.state.joint.begin());
  std::copy_n(command.joint.begin(), joints, unobserved.sent.joint.begin());
  std::copy_n(report.model_torque.begin(), joints, unobserved.model.begin());
  unobserved.period_ns = period_ns;
  unobserved.active = 0;
  unobserved.torque = 0;
  for (std::size_t i = 0; i < joints; ++i) {
    const SupervisorMemory& own = memory_of(i);
    unobserved.authority[i] = own.authority;
    const bool compensates = law[arm_of(i)] != LawKind::kZero;
    unobserved.active |= own.state == SupervisorState::kActive && compensates ? bit(i) : 0;
    unobserved.torque |= makes_torque(own.state) && !own.drives_only ? bit(i) : 0;
  }
}

void Controller::Impl::observe() noexcept {
  if (!unobserved.waits) {
    return;
  }
  unobserved.waits = false;
  watch.observe(options(), setup->mechanism, workspace,
                {.state = unobserved.state,
                 .estimate = estimator.estimate(),
                 .sent = unobserved.sent,
                 .model = unobserved.model,
                 .authority = unobserved.authority,
                 .active = unobserved.active,
                 .torque = unobserved.torque,
                 .period_ns = unobserved.period_ns});
  report.external_torque = watch.external_torque();
  report.touched = watch.touched();
  for (std::size_t i = 0; i < joints; ++i) {
    report.gain[i] = watch.gain(i);
    report.static_check[i] = watch.static_check().state(i);
  }
}

void Controller::Impl::report_arms() noexcept {
  report.state = overall(supervisor, memory);
  for (std::size_t a = arms.count; a-- > 0;) {
    const SupervisorMemory& own = memory.arm[a];
    report.arm[a] = {own.state, law[a], own.authority};
    if (own.state == report.state) {
      report.law = law[a];
      report.authority = own.authority;
    }
  }
}

void Controller::Impl::count_missing(const Estimate& estimate) noexcept {
  for (std::size_t i = 0; i < joints; ++i) {
    const SupervisorState state = memory_of(i).state;
    MissingReplies& counted = report.missing[i];
    // A drive owes replies once it has been configured.
    const bool owed = state == SupervisorState::kReady || state == SupervisorState::kEnabling ||
                      makes_torque(state);
    const bool missed = owed && !has(estimate.fresh, i);
    counted.run = missed ? counted.run + 1 : 0;
    counted.total += missed ? 1 : 0;
    counted.longest = std::max(counted.longest, counted.run);
  }
}

/// Gravity and the chosen share of the Coriolis torque, which is quadratic in the velocity: that
/// share of it belongs to the velocity times the share's root.
const Eigen::VectorXd& Controller::Impl::compensation(const Setup& by) noexcept {
  const double root = std::sqrt(by.options.coriolis);
  for (std::size_t i = 0; i < joints; ++i) {
    acting_velocity[i] = root * report.velocity[i];
  }
  const auto size = static_cast<Eigen::Index>(joints);
  const Eigen::Map<const Eigen::VectorXd> q(acting_position.data(), size);
  const Eigen::Map<const Eigen::VectorXd> v(acting_velocity.data(), size);
  if (by.compiled != nullptr) {
    by.compiled->bias(q.data(), v.data(), workspace.bias.data());
    return workspace.bias;
  }
  return bias(by.mechanism, workspace, q, v);
}

/// The model where the arm will be when the torque acts; zero as long as the pose is not known.
/// What is computed now leaves at the next tick and stays for a period: in the middle of it,
/// gravity as of now would be 1.5 periods old, which is a damping of -1.5 period * dg/dq, negative
/// above the shoulder: a big arm would gather speed by itself.
void Controller::Impl::evaluate(const Estimate& estimate, std::int64_t tick_ns,
                                std::int64_t period_ns) noexcept {
  report.position = estimate.position;
  report.velocity = estimate.velocity;
  const std::int64_t acts_ns =
      std::clamp<std::int64_t>(tick_ns, 0, kLatestInstant) + period_ns + period_ns / 2;
  const double ahead_s = 1e-9 * static_cast<double>(std::clamp<std::int64_t>(
                                    acts_ns - estimate.instant_ns, 0, 2 * period_ns));
  for (std::size_t i = 0; i < joints; ++i) {
    acting_position[i] = estimate.position[i] + ahead_s * estimate.velocity[i];
  }
  Eigen::Map<Eigen::VectorXd>(report.model_torque.data(), static_cast<Eigen::Index>(joints)) =
      compensation(*setup);
  // Arms do not carry each other: what one of them does not know of itself is its own affair.
  for (std::size_t i = 0; i < joints; ++i) {
    const BitSet needed = arms.joints[arm_of(i)];
    report.model_torque[i] = (estimate.known & needed) == needed ? report.model_torque[i] : 0.0;
  }
}

const ArmCommand& Controller::Impl::update(const ArmState& state, std::int64_t period_ns) noexcept {
  const std::int64_t period = std::clamp<std::int64_t>(period_ns, 1, kLongestPeriod);
  BitSet was_active = 0;
  for (std::size_t a = 0; a < arms.count; ++a) {
    was_active |= memory.arm[a].state == SupervisorState::kActive ? arms.joints[a] : 0;
  }
  observe();
  const Estimate& estimate = estimator.update(state, period);
  note_cycle(state, period);
  decide(state, estimate);
  if (report.restart != 0) {
    watch.restart();
    // What was measured before the dialogues began anew may not hold any more.
    estimator.reset(report.restart);
  }
  evaluate(estimate, state.tick_ns, period);
  for (std::size_t i = 0; i < joints; ++i) {
    reference[i] = has(was_active, i) ? reference[i] : estimate.position[i];
  }
  write_command(state, static_cast<double>(period) * 1e-9);
  return command;
}

Controller::Controller(Mechanism mechanism, const ControllerOptions& options,
                       const CompiledModel* compiled)
    : impl_(std::make_unique<Impl>(std::move(mechanism), options, compiled)) {}

Controller::~Controller() = default;

const ArmCommand& Controller::update(const ArmState& state, std::int64_t period_ns) noexcept {
  return impl_->update(state, period_ns);
}

void Controller::request(const Request& request) noexcept {
  impl_->ask(request);
}

void Controller::observe() noexcept {
  impl_->observe();
}

const Setup* Controller::exchange(const Setup* next) noexcept {
  return impl_->exchange(next);
}

const ControllerReport& Controller::report() const noexcept {
  return impl_->report;
}

}  // namespace geodesic::control
