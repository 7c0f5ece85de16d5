// The simulated arm on its buses; see the header. The loops are in real_time.cpp and lockstep.cpp.
#include "tools/sim/simulation.hpp"

#include <fmt/format.h>
#include <sched.h>
#include <sys/prctl.h>

#include <memory>
#include <stdexcept>

#include "rt/clock.hpp"
#include "tools/sim/loops.hpp"
#include "tools/sim/motion_trace.hpp"
#include "tools/sim/sim_buses.hpp"

namespace geodesic::tools {
namespace {

std::string ready_line(const SimBuses& buses, std::size_t drives, bool lockstep) {
  std::string where;
  for (std::size_t bus = 0; bus < buses.size(); ++bus) {
    where += (bus == 0 ? "" : ", ") + buses.interface(bus);
    if (buses.hosts_hub(bus)) where += " (hub hosted here)";
  }
  return fmt::format("geodesic sim: answering on {}: {} drive{}, {}", where, drives,
                     drives == 1 ? "" : "s",
                     lockstep ? "time locked to the commands" : "in real time");
}

void check_script(const SimulationSettings& settings, const config::Robot& robot,
                  const SimBuses& buses) {
  for (const ScriptedFault& fault : settings.plant.script.faults) {
    if (fault.kind != FaultKind::kHoldBus) continue;
    const std::size_t bus = robot.arm.joints.at(fault.joint).bus;
    if (settings.lockstep || !buses.hosts_hub(bus)) {
      throw std::invalid_argument(
          fmt::format("fault hold-bus on {}: only a socket bus (unix:PATH) that this simulator "
                      "serves itself, in real time, can be held still; {}",
                      buses.interface(bus),
                      settings.lockstep ? "leave out --lockstep"
                                        : "on vcan use `tc qdisc add dev ... root netem delay`"));
    }
  }
}

}  // namespace

SimulationReport run_simulation(const config::Robot& robot, const SimulationSettings& settings,
                                const std::atomic<bool>& stop, const sigset_t& waiting_mask) {
  SimulationReport report;
  // Real drives are never late for want of a processor. Where it is allowed, neither are these: by
  // default far below the daemon's priority, and asleep most of the time. A hub's thread inherits
  // it.
  if (!settings.lockstep) {
    const sched_param priority{settings.priority};
    report.realtime = sched_setscheduler(0, SCHED_FIFO, &priority) == 0;
  } else {
    // The first of a set of commands must not put us in front of their sender: we would answer to
    // each alone, at the price of two context switches.
    const sched_param none{};
    sched_setscheduler(0, SCHED_BATCH, &none);
  }
  SimBuses buses(robot.arm.buses);
  check_script(settings, robot, buses);
  PlantOptions plant_options = settings.plant;
  plant_options.start_ns = settings.lockstep ? robot.period_ns : rt::now_ns();
  Plant plant(robot, plant_options);
  report.warnings = plant.warnings();

  std::unique_ptr<MotionTrace> trace;
  if (!settings.trace.empty()) {
    if (!(settings.trace_hz > 0.0)) throw std::invalid_argument("a trace needs a rate above 0 Hz");
    trace = std::make_unique<MotionTrace>(settings.trace, plant);
    plant.on_sample(1.0 / settings.trace_hz, [&] { trace->write(plant); });
  }
  prctl(PR_SET_TIMERSLACK, 1);  // replies are due to the microsecond
  if (settings.ready) {
    settings.ready(ready_line(buses, plant.joints(), settings.lockstep), plant.warnings());
  }

  const LoopContext context{robot, settings, plant, buses, stop, waiting_mask, report};
  if (settings.lockstep) {
    run_in_lockstep(context);
  } else {
    run_in_real_time(context);
  }

  report.plant = plant.report();
  report.simulated_s = plant.elapsed_s();
  report.start_ns = plant_options.start_ns;
  report.energy = plant.physics().energy();
  for (std::size_t i = 0; i < plant.joints(); ++i) {
    report.enabled.push_back(plant.enabled(i));
    report.position.push_back(plant.position(i));
  }
  for (std::size_t bus = 0; bus < buses.size(); ++bus) {
    report.buses.push_back(
        {buses.interface(bus), buses.hosts_hub(bus), buses.counters(bus), buses.dropped(bus)});
  }
  return report;
}

}  // namespace geodesic::tools
