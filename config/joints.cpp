// [[joint]] to JointOptions and JointTuning, matched with the URDF's joints and put in their order.
#include <fmt/format.h>

#include <algorithm>
#include <stdexcept>

#include "config/checks.hpp"
#include "control/mechanism/mechanism.hpp"
#include "drivers/families.hpp"

namespace geodesic::config {
namespace {

using control::JointDescription;

bool is_locked(const Draft& draft, const std::string& name) {
  const auto& lock = draft.file.robot.lock;
  return std::any_of(lock.begin(), lock.end(), [&](const auto& l) { return l.name == name; });
}

/// The URDF's joint an entry speaks of; null, with a finding, if there is none to be driven.
const JointDescription* driven_joint(Draft& draft, const JointEntry& entry) {
  if (!draft.urdf.ok || !entry.name.given) return nullptr;
  const std::string& name = entry.name.value;
  const JointDescription* joint = find_joint(draft.urdf.tree, name);
  std::string wrong;
  if (joint == nullptr) {
    const std::vector<std::string> known = independent_joints(draft.urdf.tree);
    wrong = fmt::format("the URDF has no joint {}{} Its joints that move: {}", quote(name),
                        nearest_name(name, known).empty() ? "." : did_you_mean(name, known),
                        list_names(known));
  } else if (is_locked(draft, name)) {
    wrong = fmt::format("joint {} is locked in [robot]; remove it here or there", quote(name));
  } else if (joint->mimic) {
    wrong = fmt::format("joint {} mimics {} and has no drive of its own; configure that one",
                        quote(name), quote(joint->mimic->joint));
  } else if (joint->kind == control::JointKind::kFixed) {
    wrong = fmt::format("joint {} is fixed in the URDF; remove this entry", quote(name));
  } else {
    return joint;
  }
  draft.findings.error(entry.name.place, wrong);
  return nullptr;
}

/// Index of the entry's bus; 0, with a finding, if there is none.
std::size_t bus_of(Draft& draft, const JointEntry& entry) {
  if (!entry.bus.given) return 0;
  std::vector<std::string> known;
  for (std::size_t i = 0; i < draft.file.buses.size(); ++i) {
    known.push_back(draft.file.buses[i].name.value);
    if (known.back() == entry.bus.value) return i;
  }
  draft.findings.error(
      entry.bus.place,
      fmt::format(
          "there is no bus {}{} Its buses: {}", quote(entry.bus.value),
          nearest_name(entry.bus.value, known).empty() ? "." : did_you_mean(entry.bus.value, known),
          list_names(known)));
  return 0;
}

drivers::DriveOptions drive_of(const DriveEntry& entry, bool fd, Findings& findings) {
  drivers::DriveOptions drive;
  drive.family = entry.family.value;
  drive.id = static_cast<std::uint32_t>(entry.id.value);
  drive.reply_id = static_cast<std::uint32_t>(entry.reply_id.value);
  drive.fd = fd;
  drive.position_range_rad = entry.position_range_rad.value;
  drive.velocity_range_rad_s = entry.velocity_range_rad_s.value;
  drive.torque_range_nm = entry.torque_range_nm.value;
  drive.watchdog_ns = static_cast<std::int64_t>(entry.watchdog_ms.value * 1e6);
  drive.clear_errors = entry.clear_errors.value;
  drive.error_diffusion = entry.error_diffusion.value;
  for (std::size_t i = 0; i < entry.settings.size(); ++i) {
    drive.settings.values[i] = entry.settings[i].value;
  }
  if (!entry.family.given) return drive;
  const drivers::Family* family = drivers::find_family(drive.family);
  if (family == nullptr) {
    std::vector<std::string> known;
    for (const drivers::Family& f : drivers::families()) known.emplace_back(f.name);
    findings.error(entry.family.place,
                   fmt::format("family: found {}, expected one of: {}{}", quote(drive.family),
                               list_names(known), did_you_mean(drive.family, known)));
  } else if (entry.id.given && entry.velocity_range_rad_s.given && entry.torque_range_nm.given) {
    for (const std::string& wrong : family->check(drive)) {
      findings.error(entry.id.place, fmt::format("drive: {}", wrong));
    }
  }
  return drive;
}

/// Where the joint may stand at power-on: as given, or one turn of the drive about the middle of
/// its travel. No wider than a turn, or nobody could tell which one the drive is in. A continuous
/// joint is the same in each.
void fill_start_band(const JointEntry& entry, const JointDescription* described,
                     const control::JointTuning& tuning, drivers::JointOptions& joint,
                     Findings& findings) {
  const drivers::Family* family = drivers::find_family(joint.drive.family);
  if (family == nullptr || described == nullptr) return;
  const double turn = family->position_period_rad(joint.drive) * joint.ratio;
  const bool given = entry.start_lower.given || entry.start_upper.given;
  const double middle = 0.5 * (tuning.position_lower + tuning.position_upper);
  const double travel = tuning.position_upper - tuning.position_lower;
  joint.start_lower = entry.start_lower.given ? entry.start_lower.value : middle - 0.5 * turn;
  joint.start_upper = entry.start_upper.given ? entry.start_upper.value : middle + 0.5 * turn;
  if (!(turn > 0.0)) return;
  const double band = joint.start_upper - joint.start_lower;
  const Place& place = entry.start_lower.given   ? entry.start_lower.place
                       : entry.start_upper.given ? entry.start_upper.place
                                                 : entry.place;
  if (entry.start_lower.given != entry.start_upper.given) {
    findings.error(place, "start_lower and start_upper: found one, expected both or none");
  } else if (given && !(band > 0.0 && band <= turn)) {
    findings.error(place, fmt::format("start_lower {} to start_upper {}: found a band of {:.6g}, "
                                      "expected more than 0 and at most one turn of the drive at "
                                      "the joint, {:.6g}",
                                      joint.start_lower, joint.start_upper, band, turn));
  } else if (!given && travel > turn && described->kind != control::JointKind::kContinuous) {
    findings.error(place,
                   fmt::format("joint {}: its travel of {:.6g} is more than one turn of the drive "
                               "at the joint, {:.6g}, and the drive forgets its turns when it is "
                               "switched off: say where the joint may stand then, by start_lower "
                               "and start_upper",
                               quote(entry.name.value), travel, turn));
  }
}

/// Every moving joint has an entry, and the robot is not larger than all arrays.
void check_complete(Draft& draft) {
  if (!draft.urdf.ok) return;
  for (const std::string& name : independent_joints(draft.urdf.tree)) {
    const auto& joints = draft.file.joints;
    if (std::any_of(joints.begin(), joints.end(),
                    [&](const auto& entry) { return entry.name.value == name; })) {
      continue;
    }
    draft.findings.error(
        draft.file.robot.urdf.place,
        fmt::format(
            "joint {} (line {} of the URDF) moves but has no [[joint]]; give it a drive, or "
            "lock it: lock = {{ {} = 0.0 }} in [robot]",
            quote(name), draft.urdf.joints[name].line, name));
  }
}

void check_counts(Draft& draft) {
  if (draft.file.joints.size() > control::kMaxJoints) {
    draft.findings.error(draft.file.joints[control::kMaxJoints].place,
                         fmt::format("{} joints, expected at most {}", draft.file.joints.size(),
                                     control::kMaxJoints));
  }
  for (const BusEntry& bus : draft.file.buses) {
    const auto& joints = draft.file.joints;
    if (bus.name.given && std::none_of(joints.begin(), joints.end(), [&](const auto& entry) {
          return entry.bus.value == bus.name.value;
        })) {
      draft.findings.error(bus.place,
                           fmt::format("no joint is on bus {}; remove it", quote(bus.name.value)));
    }
  }
}

/// Entries in the mechanism's order of v; the file's order if there is no mechanism to ask.
std::vector<std::size_t> order_of_v(Draft& draft) {
  const auto& joints = draft.file.joints;
  std::vector<std::size_t> order;
  if (draft.urdf.ok) {
    try {
      const control::Mechanism mechanism(draft.urdf.tree, draft.robot.gravity);
      for (const std::string& name : mechanism.joint_names()) {
        const auto at = std::find_if(joints.begin(), joints.end(),
                                     [&](const auto& entry) { return entry.name.value == name; });
        if (at != joints.end()) order.push_back(static_cast<std::size_t>(at - joints.begin()));
      }
    } catch (const std::invalid_argument& wrong) {
      draft.findings.error(draft.file.robot.urdf.place,
                           fmt::format("no mechanism can be made of this URDF: {}", wrong.what()));
    }
  }
  for (std::size_t i = 0; i < joints.size(); ++i) {
    if (std::find(order.begin(), order.end(), i) == order.end()) order.push_back(i);
  }
  return order;
}

}  // namespace

void fill_joints(Draft& draft) {
  draft.robot.tree = draft.urdf.tree;
  check_complete(draft);
  check_counts(draft);
  for (const std::size_t i : order_of_v(draft)) {
    const JointEntry& entry = draft.file.joints[i];
    for (std::size_t k = 0; k < i; ++k) {
      if (entry.name.given && draft.file.joints[k].name.value == entry.name.value) {
        draft.findings.error(entry.name.place,
                             fmt::format("a second [[joint]] {}; the first is in line {}",
                                         quote(entry.name.value), draft.file.joints[k].place.line));
      }
    }
    const JointDescription* joint = driven_joint(draft, entry);
    drivers::JointOptions options;
    options.name = entry.name.value;
    options.bus = bus_of(draft, entry);
    const bool fd = options.bus < draft.file.buses.size() && draft.file.buses[options.bus].fd.value;
    options.drive = drive_of(entry.drive, fd, draft.findings);
    options.direction = entry.direction.value < 0 ? -1.0 : 1.0;
    options.ratio = entry.ratio.value;
    options.offset = entry.offset.value;
    control::JointTuning tuning = check_limits(entry, joint, draft.robot.period_ns, draft.findings);
    tuning.bus = options.bus;
    fill_start_band(entry, joint, tuning, options, draft.findings);
    draft.robot.controller.joints.push_back(std::move(tuning));
    draft.robot.arm.joints.push_back(std::move(options));
  }
}

}  // namespace geodesic::config
