// The simulated arm without a bus; see the header. What it records is in plant_report.cpp.
#include "tools/sim/plant.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <stdexcept>

namespace geodesic::tools {
namespace {

constexpr double kNs = 1e-9;
// A start-up dialogue may enable a drive for a moment, to see what it answers.
constexpr double kTriedOutS = 0.02;

std::int64_t to_ns(double seconds) {
  return std::llround(seconds / kNs);
}

// A whole number of steps in each control period, none longer than longest_s.
std::int64_t step_of(std::int64_t period_ns, double longest_s) {
  const std::int64_t longest = to_ns(longest_s);
  return period_ns / ((period_ns + longest - 1) / longest);
}

}  // namespace

Plant::Plant(const config::Robot& robot, PlantOptions options)
    : robot_(robot),
      options_(std::move(options)),
      step_ns_(step_of(robot.period_ns, options_.timestep_s)),
      physics_(robot_, static_cast<double>(step_ns_) * kNs),
      now_ns_(options_.start_ns),
      torque_(robot_.arm.joints.size(), 0.0),
      fault_done_(options_.script.faults.size(), false),
      babbling_until_ns_(robot_.arm.buses.size(), 0),
      held_until_ns_(robot_.arm.buses.size(), 0) {
  for (const drivers::JointOptions& joint : robot_.arm.joints) {
    PlantDrive drive;
    drive.options = &joint;
    drive.family = drivers::find_family(joint.drive.family);
    if (drive.family == nullptr) {
      throw std::invalid_argument(
          fmt::format("joint '{}': there is no drive family '{}'", joint.name, joint.drive.family));
    }
    drive.simulated = drive.family->make_simulated(joint.drive);
    drives_.push_back(std::move(drive));

    JointHistory history;
    history.name = joint.name;
    history.start = physics_.position(report_.joints.size());
    report_.joints.push_back(std::move(history));
  }
  for (const ScriptedFault& fault : options_.script.faults) {
    if (fault.kind != FaultKind::kDouble) continue;
    PlantDrive& drive = drives_.at(fault.joint);
    drive.twin = drive.family->make_simulated(drive.options->drive);
  }
  list_own_ids(robot_);
  for (const LinkForce& force : options_.script.forces) {
    const int link = physics_.find_link(force.link);
    if (link < 0) throw std::invalid_argument("there is no link '" + force.link + "'");
    force_link_.push_back(link);
    pushes_end_s_ = std::max(pushes_end_s_, force.start_s + force.duration_s);
  }
  for (const Push& push : options_.script.pushes) {
    pushes_end_s_ = std::max(pushes_end_s_, push.start_s + push.duration_s);
  }
  turn_shafts(0.0);
}

void Plant::list_own_ids(const config::Robot& robot) {
  std::vector<std::vector<drivers::IdFilter>> all;
  for (const PlantDrive& drive : drives_) {
    all.push_back(drive.family->make_drive(drive.options->drive)->command_ids());
  }
  for (std::size_t i = 0; i < drives_.size(); ++i) {
    for (const drivers::IdFilter& id : all[i]) {
      bool shared = false;
      for (std::size_t other = 0; other < drives_.size() && !shared; ++other) {
        if (other == i || robot.arm.joints[other].bus != robot.arm.joints[i].bus) continue;
        shared = std::any_of(
            all[other].begin(), all[other].end(),
            [&](const drivers::IdFilter& theirs) { return drivers::overlap(id, theirs); });
      }
      if (!shared) drives_[i].own_ids.push_back(id);
    }
  }
}

double Plant::elapsed_s() const noexcept {
  return static_cast<double>(now_ns_ - options_.start_ns) * kNs;
}

void Plant::advance(std::int64_t to_ns) {
  while (now_ns_ + step_ns_ <= to_ns) one_step();
}

void Plant::skip(std::int64_t to_ns) noexcept {
  now_ns_ = std::max(now_ns_, to_ns);
}

void Plant::one_step() {
  if (sample_ && now_ns_ >= next_sample_ns_) {
    sample_();
    next_sample_ns_ += sample_interval_ns_;
    next_sample_ns_ = std::max(next_sample_ns_, now_ns_ - sample_interval_ns_);
  }
  act_out_faults();
  turn_shafts(0.0);
  turned_ns_ = -1;
  for (std::size_t i = 0; i < drives_.size(); ++i) {
    drivers::SimulatedDrive& drive = *drives_[i].simulated;
    const bool before = drive.enabled();
    const drivers::JointOptions& joint = *drives_[i].options;
    torque_[i] = joint.direction / joint.ratio * drive.torque_nm(now_ns_);
    // Nobody spoke to it within a step: only its own watchdog can have switched it off.
    if (before && !drive.enabled()) ++report_.joints[i].watchdog_trips;
    physics_.set_torque(i, torque_[i]);
  }
  if (released()) {
    act_out_pushes(static_cast<double>(now_ns_ - release_ns_) * kNs);
  } else {
    lean_on_stand();
  }
  physics_.step();
  if (!physics_.finite()) {
    throw Diverged(
        fmt::format("the simulated mechanics diverged {:.3f} s after the start", elapsed_s()));
  }
  now_ns_ += step_ns_;
  if (!released()) watch_stand();
  observe();
}

void Plant::turn_shafts(double ahead_s) {
  for (std::size_t i = 0; i < drives_.size(); ++i) {
    const drivers::JointOptions& joint = *drives_[i].options;
    const bool stuck = drives_[i].stuck_position.has_value();
    const double velocity = physics_.velocity(i);
    const double position =
        stuck ? *drives_[i].stuck_position
              : physics_.position(i) + velocity * ahead_s + drives_[i].encoder_offset;
    set_shaft(*drives_[i].simulated, joint, position, velocity);
  }
}

void Plant::act_out_pushes(double since_release_s) {
  const auto acts = [&](double start, double duration) {
    return since_release_s >= start && since_release_s < start + duration;
  };
  for (const Push& push : options_.script.pushes) {
    if (!acts(push.start_s, push.duration_s)) continue;
    physics_.set_torque(push.joint, torque_[push.joint] + push.torque);
  }
  if (forces_act_) physics_.clear_forces();
  forces_act_ = false;
  for (std::size_t i = 0; i < force_link_.size(); ++i) {
    const LinkForce& force = options_.script.forces[i];
    if (!acts(force.start_s, force.duration_s)) continue;
    physics_.add_force(force_link_[i], force.force_n);
    forces_act_ = true;
  }
}

void Plant::lean_on_stand() {
  const std::vector<double> surplus = physics_.unbalanced_torques();
  for (std::size_t i = 0; i < drives_.size(); ++i) {
    const double needed = torque_[i] - surplus[i];
    const double carried = std::clamp(-surplus[i], std::min(needed, 0.0), std::max(needed, 0.0));
    physics_.set_torque(i, torque_[i] + carried);
  }
}

void Plant::watch_stand() {
  const bool all = std::all_of(drives_.begin(), drives_.end(),
                               [](const PlantDrive& drive) { return drive.simulated->enabled(); });
  if (!all) {
    enabled_since_ns_ = -1;
    return;
  }
  if (enabled_since_ns_ < 0) enabled_since_ns_ = now_ns_;
  const std::int64_t enabled_for_ns = now_ns_ - enabled_since_ns_;
  if (!report_.enabled_s && enabled_for_ns >= to_ns(std::min(kTriedOutS, options_.release_s))) {
    report_.enabled_s = static_cast<double>(enabled_since_ns_ - options_.start_ns) * kNs;
  }
  if (enabled_for_ns >= to_ns(options_.release_s)) let_go();
}

void Plant::turn_shafts_at(std::int64_t now_ns) {
  if (now_ns == turned_ns_) return;  // for the frame before, which came in the same batch
  turn_shafts(static_cast<double>(std::max<std::int64_t>(now_ns - now_ns_, 0)) * kNs);
  turned_ns_ = now_ns;
}

void Plant::speak(std::size_t bus, std::int64_t now_ns, std::vector<Answer>& answers) {
  turn_shafts_at(now_ns);
  for (std::size_t i = 0; i < drives_.size(); ++i) {
    if (drives_[i].options->bus != bus || silent(i)) continue;
    std::array<drivers::Frame, drivers::SimulatedDrive::kMaxReplies> said;
    const bool before = drives_[i].simulated->enabled();
    const std::size_t count = drives_[i].simulated->speak(now_ns, said);
    if (before && !drives_[i].simulated->enabled()) ++report_.joints[i].watchdog_trips;
    report_.joints[i].answered += count;
    for (std::size_t k = 0; k < count; ++k) answers.push_back({i, said[k]});
  }
}

void Plant::hear(std::size_t bus, const drivers::Frame& frame, std::int64_t now_ns,
                 std::vector<Answer>& answers) {
  turn_shafts_at(now_ns);
  for (std::size_t i = 0; i < drives_.size(); ++i) {
    if (drives_[i].options->bus != bus) continue;
    if (silent(i)) {
      if (addressee(bus, frame) == i) ++report_.joints[i].swallowed;
      continue;
    }
    std::array<drivers::Frame, drivers::SimulatedDrive::kMaxReplies> replies;
    const std::size_t count = drives_[i].simulated->receive(frame, now_ns, replies);
    if (count == 0) continue;
    ++report_.joints[i].heard;
    report_.joints[i].answered += count;
    for (std::size_t k = 0; k < count; ++k) answers.push_back({i, replies[k]});
    if (!drives_[i].twin_answers) continue;
    const std::size_t twins = drives_[i].twin->receive(frame, now_ns, replies);
    for (std::size_t k = 0; k < twins; ++k) answers.push_back({i, replies[k]});
  }
  note_disabled();
}

std::optional<std::size_t> Plant::addressee(std::size_t bus, const drivers::Frame& frame) const {
  for (std::size_t i = 0; i < drives_.size(); ++i) {
    if (drives_[i].options->bus != bus) continue;
    for (const drivers::IdFilter& id : drives_[i].own_ids) {
      if (id.matches(frame.id, frame.extended)) return i;
    }
  }
  // A shared identifier names its drive inside the frame; the family can tell.
  for (std::size_t i = 0; i < drives_.size(); ++i) {
    if (drives_[i].options->bus != bus) continue;
    if (drives_[i].family->decode(frame, drives_[i].options->drive)) return i;
  }
  return std::nullopt;
}

void Plant::on_sample(double interval_s, std::function<void()> sample) {
  sample_ = std::move(sample);
  sample_interval_ns_ = std::max<std::int64_t>(to_ns(interval_s), 1);
  next_sample_ns_ = now_ns_;
}

}  // namespace geodesic::tools
