// load_robot(): reads the file, runs every check, and leaves a Robot or the reasons why not.
#include <fmt/format.h>

#include <cmath>

#include "config/checks.hpp"
#include "config/files.hpp"
#include "config/options/toml_reader.hpp"
#include "config/settings.hpp"
#include "config/watch_options.hpp"

namespace geodesic::config {
namespace {

control::LawKind law_named(const std::string& name) {
  for (const control::LawKind law : {control::LawKind::kHold, control::LawKind::kDamp}) {
    if (name == control::to_string(law)) return law;
  }
  return control::LawKind::kFloat;
}

/// Reads the URDF that the file names, if it names one.
UrdfResult read_urdf(const RobotFile& file, const LoadOptions& options, Robot& robot,
                     Findings& findings) {
  UrdfResult result;
  const Given<std::string>& named = file.robot.urdf;
  if (!named.given) return result;
  robot.urdf = robot.file.parent_path() / named.value;
  if (options.text) {
    result = load_urdf(robot.urdf, options.strict, options.text->urdf);
    for (const Message& message : result.messages) findings.add(message);
    return result;
  }
  std::error_code problem;
  if (!std::filesystem::exists(robot.urdf, problem)) {
    findings.error(named.place,
                   fmt::format("urdf: there is no file {} (relative paths begin at the "
                               "robot file)",
                               quote_path(robot.urdf)));
    return result;
  }
  result = load_urdf(robot.urdf, options.strict);
  for (const Message& message : result.messages) findings.add(message);
  return result;
}

/// A drive moves one degree of freedom; what `geodesic model` takes beyond that has none.
void refuse_joints_without_drive(Draft& draft) {
  if (!draft.urdf.ok) return;
  for (const control::JointDescription& joint : draft.urdf.tree.joints) {
    if (control::freedoms(joint.kind) <= 1) continue;
    draft.urdf.ok = false;
    draft.findings.error(
        draft.urdf.joints.at(joint.name),
        fmt::format("joint {} is {}: no drive can move it; expected revolute, continuous, "
                    "prismatic or fixed (a root link that moves freely is known to "
                    "`geodesic model --floating` only)",
                    quote(joint.name), control::kind_name(joint.kind)));
  }
}

/// One number of cycles against the next: told at the one that the file gives.
void check_order(const Given<std::int64_t>& less, const char* less_key,
                 const Given<std::int64_t>& more, const char* more_key, bool holds,
                 const char* expected, Findings& findings) {
  if (holds) return;
  findings.error(less.given ? less.place : more.place,
                 fmt::format("{}: found {}, expected {} {}, which is {}", less_key, less.value,
                             expected, more_key, more.value));
}

}  // namespace

void fill_plain_options(Draft& draft) {
  const RobotFile& file = draft.file;
  Robot& robot = draft.robot;
  robot.name = file.robot.name.value;
  robot.period_ns = std::llround(1e9 / file.robot.rate_hz.value);
  robot.gravity = Eigen::Vector3d(file.robot.gravity.value.data());
  robot.realtime.priority = static_cast<int>(file.realtime.priority.value);
  robot.realtime.cpus.assign(file.realtime.cpus.value.begin(), file.realtime.cpus.value.end());
  robot.realtime.receive_deadline = file.realtime.receive_deadline.value;

  robot.controller.law = law_named(file.control.law.value);
  robot.controller.start_active = file.control.start_active.value;
  robot.controller.velocity_filter_hz = file.control.velocity_filter_hz.value;
  robot.controller.coriolis = file.control.coriolis.value;
  robot.controller.retune_s = file.control.retune_s.value;
  if (file.control.compiled.given && !file.control.compiled.value.empty()) {
    robot.compiled = robot.file.parent_path() / file.control.compiled.value;
  }

  control::SafetyOptions& to = robot.controller.safety;
  const SafetyEntry& from = file.safety;
  to.carry_on_cycles = static_cast<int>(from.carry_on_cycles.value);
  to.damp_cycles = static_cast<int>(from.damp_cycles.value);
  to.silent_cycles = static_cast<int>(from.silent_cycles.value);
  check_order(from.carry_on_cycles, "carry_on_cycles", from.damp_cycles, "damp_cycles",
              to.carry_on_cycles < to.damp_cycles, "less than", draft.findings);
  check_order(from.damp_cycles, "damp_cycles", from.silent_cycles, "silent_cycles",
              to.damp_cycles <= to.silent_cycles, "no more than", draft.findings);
  to.overrun_cycles = static_cast<int>(from.overrun_cycles.value);
  to.start_ramp_s = from.start_ramp_s.value;
  to.stop_rest_velocity = from.stop_rest_velocity.value;
  to.stop_rest_s = from.stop_rest_s.value;
  to.stop_timeout_s = from.stop_timeout_s.value;
  to.lower_s = from.lower_s.value;
  to.settle_timeout_s = from.settle_timeout_s.value;
  to.other_arm =
      from.other_arm.value == "carry_on" ? control::OtherArm::kCarryOn : control::OtherArm::kStop;
  to.connect_timeout_s = from.connect_timeout_s.value;
  to.enable_timeout_s = from.enable_timeout_s.value;
  to.start_velocity = from.start_velocity.value;
  to.encoder_jump = from.encoder_jump.value;
  to.encoder_stuck = from.encoder_stuck.value;
  fill_watch(file, robot.controller);

  const Given<std::string>& tool = file.robot.tool_link;
  robot.tool_link = tool.value;
  robot.controller.tool_link = tool.value;
  if (tool.given && draft.urdf.ok && draft.urdf.links.count(tool.value) == 0) {
    std::vector<std::string> known;
    for (const auto& [name, place] : draft.urdf.links) known.push_back(name);
    draft.findings.error(tool.place,
                         fmt::format("tool_link: the URDF has no link {}{}", quote(tool.value),
                                     did_you_mean(tool.value, known)));
  }
}

std::vector<std::string> independent_joints(const control::TreeDescription& tree) {
  std::vector<std::string> names;
  for (const control::JointDescription& joint : tree.joints) {
    if (joint.kind != control::JointKind::kFixed && !joint.mimic) names.push_back(joint.name);
  }
  return names;
}

const control::JointDescription* find_joint(const control::TreeDescription& tree,
                                            std::string_view name) {
  for (const control::JointDescription& joint : tree.joints) {
    if (joint.name == name) return &joint;
  }
  return nullptr;
}

LoadResult load_robot(const std::filesystem::path& file, const LoadOptions& options) {
  LoadResult result;
  Findings findings;
  RobotFile written;
  result.robot.file = file;
  const auto text = options.text ? options.text->robot : read_file(file, findings);
  const std::vector<TomlOverride> overrides =
      text ? resolve(options.overrides, file, *text, findings) : std::vector<TomlOverride>{};
  if (text) result.text.robot = *text;
  if (text &&
      read_toml(
          file, *text, [&](OptionVisitor& o) { describe(o, written); }, findings, overrides)) {
    UrdfResult urdf = read_urdf(written, options, result.robot, findings);
    result.text.urdf = urdf.text;
    Draft draft{written, options, urdf, result.robot, findings};
    refuse_joints_without_drive(draft);
    fill_plain_options(draft);
    apply_locks(draft);
    fill_buses(draft);
    fill_joints(draft);
    fill_arms(draft);
    check_identifiers(draft);
    fill_simulation(draft);
    fill_payloads(draft);
    check_budget(draft);
    result.robot.settings = settings_of(written, result.robot.tree);
  }
  result.ok = !findings.has_errors();
  result.messages = findings.take();
  return result;
}

}  // namespace geodesic::config
