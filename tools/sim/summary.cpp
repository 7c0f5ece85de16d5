// A run of the simulated arm as JSON; see the header.
#include "tools/sim/summary.hpp"

#include <algorithm>
#include <cmath>

namespace geodesic::tools {
namespace {

using nlohmann::ordered_json;

ordered_json optional(const std::optional<double>& value) {
  return value ? ordered_json(*value) : ordered_json(nullptr);
}

double largest(const std::vector<double>& values, double until_s) {
  const double bins = std::floor(std::max(until_s, 0.0) / PlantReport::kDriftBin);
  const auto end = static_cast<std::size_t>(std::min(bins, static_cast<double>(values.size())));
  double most = 0.0;
  for (std::size_t i = 0; i < end; ++i) most = std::max(most, values[i]);
  return most;
}

std::vector<double> by_second(const std::vector<double>& drift) {
  const auto bins = static_cast<std::size_t>(std::lround(1.0 / PlantReport::kDriftBin));
  std::vector<double> result((drift.size() + bins - 1) / bins, 0.0);
  for (std::size_t i = 0; i < drift.size(); ++i) {
    result[i / bins] = std::max(result[i / bins], drift[i]);
  }
  return result;
}

ordered_json joint_json(const SimulationReport& report, const config::Robot& robot,
                        std::size_t index) {
  const JointHistory& joint = report.plant.joints[index];
  const drivers::JointOptions& options = robot.arm.joints[index];
  return {{"name", joint.name},
          {"enabled", static_cast<bool>(report.enabled[index])},
          {"start", joint.start},
          {"at_release", joint.at_release},
          {"end", report.position[index]},
          // 16-bit position codes; 0 where the family sends floating point.
          {"encoder_step", 2.0 * options.drive.position_range_rad / 65535.0 * options.ratio},
          {"moved_before_release", joint.motion_before},
          {"residual_at_release", joint.residual},
          {"drift_max", joint.drift_max},
          {"drift_since_rest", joint.drift_rest},
          {"max_torque", joint.torque_max},
          {"frames_heard", joint.heard},
          {"frames_answered", joint.answered},
          {"frames_swallowed", joint.swallowed},
          {"watchdog_trips", joint.watchdog_trips}};
}

}  // namespace

ordered_json to_json(const SimulationReport& report, const config::Robot& robot) {
  const PlantReport& plant = report.plant;
  const double end_s = plant.disabled_s.value_or(report.simulated_s);
  const double released_s = plant.release_s ? end_s - *plant.release_s : 0.0;
  // Nobody tells the drives that a stop has begun; it may have begun this long before they went
  // off.
  const control::SafetyOptions& safety = robot.controller.safety;
  const double stop_s = plant.disabled_s ? safety.stop_timeout_s + safety.lower_s + 0.2 : 0.0;

  ordered_json joints = ordered_json::array();
  for (std::size_t i = 0; i < plant.joints.size(); ++i)
    joints.push_back(joint_json(report, robot, i));
  ordered_json injections = ordered_json::array();
  for (const Injection& injection : plant.injections) {
    injections.push_back({{"joint", plant.joints[injection.joint].name},
                          {"fault", to_string(injection.kind)},
                          {"at_s", injection.at_s},
                          {"at_ns", injection.at_ns}});
  }
  ordered_json buses = ordered_json::array();
  for (const SimulatedBusReport& bus : report.buses) {
    buses.push_back({{"interface", bus.interface},
                     {"hosts_hub", bus.hosts_hub},
                     {"received", bus.counters.received},
                     {"sent", bus.counters.sent},
                     {"send_failed", bus.counters.send_failed},
                     {"receive_dropped", bus.counters.receive_dropped},
                     {"error_frames", bus.counters.error_frames},
                     {"replies_dropped", bus.dropped}});
  }
  return {{"robot", robot.name},
          {"simulated_s", report.simulated_s},
          {"start_ns", report.start_ns},
          {"enabled_at_s", optional(plant.enabled_s)},
          {"release_at_s", optional(plant.release_s)},
          {"disabled_at_s", optional(plant.disabled_s)},
          {"released_s", released_s},
          {"drift_max", largest(plant.drift, report.simulated_s)},
          {"drift_before_stop", largest(plant.drift, released_s - stop_s)},
          {"drift_by_second", by_second(plant.drift)},
          {"rest_at_s", optional(plant.rest_s)},
          {"energy_at_release_j",
           {{"kinetic", plant.energy_at_release.kinetic_j},
            {"potential", plant.energy_at_release.potential_j}}},
          {"energy_at_end_j",
           {{"kinetic", report.energy.kinetic_j}, {"potential", report.energy.potential_j}}},
          {"contact_s", plant.contact_s},
          {"contact_force_max_n", plant.contact_force_max_n},
          {"lockstep_sets", report.sets},
          {"lockstep_incomplete_sets", report.incomplete_sets},
          {"realtime", report.realtime},
          {"late_max_s", report.late_max_s},
          {"slipped_s", report.slipped_s},
          {"injections", std::move(injections)},
          {"joints", std::move(joints)},
          {"buses", std::move(buses)},
          {"warnings", report.warnings}};
}

}  // namespace geodesic::tools
