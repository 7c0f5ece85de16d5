// Status and summary as JSON.
#include "tools/geodesicd/report.hpp"

#include <unistd.h>

#include "config/setup.hpp"
#include "control/arms.hpp"
#include "drivers/bus/unix_address.hpp"
#include "tools/compile/fingerprint.hpp"

namespace geodesic::tools {

using nlohmann::ordered_json;

namespace {

double seconds(std::int64_t ns) {
  return static_cast<double>(ns) * 1e-9;
}

ordered_json counters_json(const drivers::BusCounters& counters) {
  return {{"sent", counters.sent},
          {"received", counters.received},
          {"send_skipped", counters.send_skipped},
          {"send_failed", counters.send_failed},
          {"receive_dropped", counters.receive_dropped},
          {"error_frames", counters.error_frames},
          {"foreign_commands", counters.foreign_commands},
          {"last_errno", counters.last_errno}};
}

/// What the kernel tells of the controller, and what was done for its bus.
ordered_json health_json(const drivers::LinkHealth& health) {
  return {{"device", health.device},
          {"controller", drivers::to_string(health.state)},
          {"transmit_errors", health.transmit_errors},
          {"receive_errors", health.receive_errors},
          {"bus_errors", health.bus_errors},
          {"error_warnings", health.warnings},
          {"error_passives", health.passives},
          {"bus_offs", health.bus_offs},
          {"arbitration_lost", health.arbitration_lost},
          {"restarts", health.restarts},
          {"purged", health.purged},
          {"reopened", health.reopened},
          {"foreign_frames_hz", health.foreign_frames_hz}};
}

ordered_json buses_json(const RunView& run) {
  ordered_json buses = ordered_json::array();
  for (std::size_t i = 0; i < run.words.robot->arm.buses.size(); ++i) {
    const drivers::BusOptions& options = run.words.robot->arm.buses[i];
    ordered_json bus{{"name", options.name},
                     {"interface", options.interface},
                     {"state", describe(run.counters.bus[i].state)}};
    bus.update(counters_json(run.counters.bus[i].frames));
    if (!drivers::is_socket_bus(options.interface)) {
      bus.update(health_json(run.bus_health[i]));
    }
    buses.push_back(std::move(bus));
  }
  return buses;
}

/// The arms that the file names; one nameless arm of all joints if it names none.
ordered_json arms_json(const RunView& run) {
  const config::Robot& robot = *run.words.robot;
  const control::Arms arms = control::arms_of(robot.controller);
  ordered_json result = ordered_json::array();
  for (std::size_t a = 0; a < arms.count; ++a) {
    const control::ArmReport& arm = run.last.arm[a];
    ordered_json joints = ordered_json::array();
    for (std::size_t i = 0; i < robot.arm.joints.size(); ++i) {
      if (control::has(arms.joints[a], i)) {
        joints.push_back(run.words.joint(i));
      }
    }
    result.push_back({{"name", run.words.arm(a)},
                      {"state", control::to_string(arm.state)},
                      {"law", control::to_string(arm.law)},
                      {"authority", arm.authority},
                      {"joints", joints}});
  }
  return result;
}

ordered_json missing_json(const control::MissingReplies& missing) {
  return {{"run", missing.run}, {"longest", missing.longest}, {"total", missing.total}};
}

ordered_json status_joint(const RunView& run, std::size_t i) {
  const JointRecord& joint = run.last.joint[i];
  const Counters::Joint& counted = run.counters.joint[i];
  ordered_json result{{"name", run.words.joint(i)},
                      {"unit", run.words.position_unit(static_cast<int>(i))},
                      {"position", joint.position},
                      {"velocity", joint.velocity},
                      {"torque", joint.torque},
                      {"command", joint.command},
                      {"model", joint.model},
                      {"external", joint.external},
                      {"contact", joint.touched},
                      {"gain", joint.gain},
                      {"static_check", control::to_string(joint.static_check)},
                      {"temperature", joint.temperature_c},
                      {"condition", to_string(joint.condition)},
                      {"age_ms", nullptr},
                      {"lost", counted.frames.lost},
                      {"missing", missing_json(counted.missing)}};
  if (joint.age_us != JointRecord::kNever) {
    result["age_ms"] = static_cast<double>(joint.age_us) * 1e-3;
  }
  if (joint.drive_error != 0) {
    result["drive_error"] = run.words.drive_error(i, joint.drive_error);
  }
  if (const std::string complaint = describe(counted.complaint); !complaint.empty()) {
    result["complaint"] = complaint;
  }
  return result;
}

ordered_json summary_joint(const RunView& run, std::size_t i) {
  const Counters::Joint& counted = run.counters.joint[i];
  return {{"name", run.words.joint(i)},
          {"frames_sent", counted.frames.sent},
          {"frames_received", counted.frames.received},
          {"losses", counted.frames.lost},
          {"missing", missing_json(counted.missing)},
          {"max_torque", counted.max_torque},
          {"max_command", counted.max_command},
          {"max_external", counted.max_external}};
}

void add_phases(ordered_json& to, const rt::LoopStatistics& loop, const Phases& phases) {
  to["wake_latency_ns"] = to_json(loop.wake_latency_ns);
  to["cycle_time_ns"] = to_json(loop.cycle_time_ns);
  to["state_to_torque_ns"] = to_json(phases.state_to_torque_ns);
  to["transmit_ns"] = to_json(phases.transmit_ns);
  to["exchange_ns"] = to_json(phases.exchange_ns);
  to["compute_ns"] = to_json(phases.compute_ns);
  to["observe_ns"] = to_json(phases.observe_ns);
  to["publish_ns"] = to_json(phases.publish_ns);
}

void add_health(ordered_json& to, const RunView& run) {
  to["cycles"] = run.loop.cycles.load();
  to["first_tick_ns"] = run.counters.first_tick_ns;
  to["period_ns"] = run.words.robot->period_ns;
  to["missed"] = run.loop.missed.load();
  to["skipped"] = run.loop.skipped.load();
  to["page_faults"] = run.loop.page_faults.load();
  to["allocations"] = run.loop.allocations.load();
  to["realtime"] = run.loop.realtime.load();
  to["realtime_reason"] = run.not_realtime_reason;
  to["sealed"] = run.loop.sealed.load();
  to["sealed_reason"] = run.not_sealed_reason;
  to["refused_calls"] = run.loop.refused_calls.load();
  to["simulated_time"] = run.simulated_time;
  to["telemetry_dropped"] = run.records_dropped;
  to["events_dropped"] = run.events_dropped;
}

}  // namespace

void FaultList::add(const Event& event, const EventText& text) {
  if (event.kind != Event::Kind::kFault || ++count > kMost) {
    return;
  }
  ordered_json entry{{"time", text.fields.at("at_s")},
                     {"joint", text.fields.value("joint", ordered_json())},
                     {"name", text.fields.at("fault")},
                     {"class", text.fields.at("class")}};
  for (const char* key : {"bus", "arm", "found", "limit", "unit", "drive_error", "complaint"}) {
    if (text.fields.contains(key)) {
      entry[key] = text.fields[key];
    }
  }
  entry["text"] = text.text;
  entries.push_back(std::move(entry));
}

ordered_json to_json(const rt::Histogram& histogram) {
  return {{"min", histogram.min()},
          {"p50", histogram.percentile(50.0)},
          {"p99", histogram.percentile(99.0)},
          {"p999", histogram.percentile(99.9)},
          {"max", histogram.max()}};
}

ordered_json status_json(const RunView& run) {
  const config::Robot& robot = *run.words.robot;
  ordered_json status{{"ok", true},
                      {"robot", robot.name},
                      {"version", GEODESIC_VERSION},
                      {"pid", ::getpid()},
                      {"state", control::to_string(run.last.state)},
                      {"law", control::to_string(run.last.law)},
                      {"authority", run.last.authority},
                      {"time_s", run.counters.first_tick_ns == 0
                                     ? 0.0
                                     : seconds(run.last.tick_ns - run.counters.first_tick_ns)}};
  add_health(status, run);
  status["retuning"] = run.last.retuning;
  status["arms"] = arms_json(run);
  status["joints"] = ordered_json::array();
  for (std::size_t i = 0; i < robot.arm.joints.size(); ++i) {
    status["joints"].push_back(status_joint(run, i));
  }
  status["buses"] = buses_json(run);
  add_phases(status["latencies"], run.loop, run.phases);
  status["faults"] = run.faults.entries;
  status["fault_count"] = run.faults.count;
  return status;
}

ordered_json summary_json(const RunView& run, bool forced) {
  const config::Robot& robot = *run.words.robot;
  ordered_json summary{{"robot", robot.name}, {"version", GEODESIC_VERSION}};
  summary["model"] = {
      {"path", robot.compiled.empty() ? "interpreted" : "compiled"},
      {"file", robot.compiled.string()},
      {"fingerprint", compile::fingerprint(config::make_mechanism(robot, robot.payload))}};
  add_health(summary, run);
  add_phases(summary, run.loop, run.phases);
  summary["arms"] = arms_json(run);
  summary["joints"] = ordered_json::array();
  for (std::size_t i = 0; i < robot.arm.joints.size(); ++i) {
    summary["joints"].push_back(summary_joint(run, i));
  }
  summary["buses"] = buses_json(run);
  summary["faults"] = run.faults.entries;
  summary["fault_count"] = run.faults.count;
  summary["torque_forced_off"] = forced;
  summary["final_state"] = control::to_string(run.last.state);
  return summary;
}

ordered_json refused_summary_json(const std::string& robot, std::int64_t period_ns,
                                  const std::string& error) {
  ordered_json summary{{"robot", robot},
                       {"version", GEODESIC_VERSION},
                       {"cycles", 0},
                       {"first_tick_ns", 0},
                       {"period_ns", period_ns},
                       {"missed", 0},
                       {"skipped", 0},
                       {"page_faults", 0},
                       {"allocations", 0},
                       {"realtime", false}};
  add_phases(summary, rt::LoopStatistics{}, Phases(false));
  summary["arms"] = ordered_json::array();
  summary["joints"] = ordered_json::array();
  summary["buses"] = ordered_json::array();
  summary["faults"] = ordered_json::array();
  summary["fault_count"] = 0;
  summary["final_state"] = "refused";
  summary["error"] = error;
  return summary;
}

}  // namespace geodesic::tools
