// Does a robot hold its rate? Its drivers against its simulated drives on wires that are modelled
// bit for bit, in made-up time: prints JSON, and ends with 1 if a reply came late or was lost.
#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <cstdio>
#include <memory>
#include <nlohmann/json.hpp>
#include <random>
#include <string>
#include <vector>

#include "config/budget.hpp"
#include "drivers/arm.hpp"
#include "drivers/families.hpp"
#include "tests/bench/virtual_wire.hpp"

namespace geodesic::bench {
namespace {

using control::DriveCondition;
using control::DriveMode;
using nlohmann::ordered_json;

constexpr int kMostStartUp = 20'000;  // cycles
constexpr int kSettling = 200;        // the last words of the start-up dialogues

class Run {
 public:
  explicit Run(const config::Robot& robot) : robot_(robot), options_(robot.arm) {
    options_.simulated_time = true;
    const auto latency_ns = std::llround(robot.simulation.reply_latency_s * 1e9);
    std::vector<std::unique_ptr<drivers::Bus>> buses;
    for (const drivers::BusOptions& bus : options_.buses) {
      auto wire = std::make_unique<VirtualWire>(bus, latency_ns, robot.period_ns);
      wires_.push_back(wire.get());
      buses.push_back(std::move(wire));
    }
    for (const drivers::JointOptions& joint : options_.joints) {
      const drivers::Family& family = *drivers::find_family(joint.drive.family);
      auto drive = family.make_simulated(joint.drive);
      drive->set_shaft(0.1, 0.0);
      wires_[joint.bus]->add(std::move(drive));
    }
    arm_ = std::make_unique<drivers::Arm>(options_, std::move(buses));
    command_.joints = options_.joints.size();
  }

  bool start() {
    return until(DriveMode::kMonitor, DriveCondition::kDisabled) &&
           until(DriveMode::kEnable, DriveCondition::kEnabled);
  }

  /// Torques at random, so that stuff bits vary. @return cycles in which a joint had nothing new
  std::size_t cycles(int count) {
    std::mt19937 random(1);
    for (int i = 0; i < kSettling; ++i) cycle();
    for (VirtualWire* wire : wires_) wire->figures() = {};
    const std::vector<std::uint64_t> before = losses();
    std::size_t stale = 0;
    for (int i = 0; i < count; ++i) {
      for (std::size_t joint = 0; joint < command_.joints; ++joint) {
        const drivers::JointOptions& of = options_.joints[joint];
        std::uniform_real_distribution<double> torque(-0.5, 0.5);
        command_.joint[joint].torque = torque(random) * of.drive.torque_range_nm / of.ratio;
        command_.joint[joint].damping = 0.1 * torque(random) + 0.05;
      }
      const control::ArmState& state = cycle();
      bool all = true;
      for (std::size_t joint = 0; joint < command_.joints; ++joint) {
        all = all && state.joint[joint].fresh;
      }
      stale += all ? 0 : 1;
    }
    const std::vector<std::uint64_t> after = losses();
    lost_ = 0;
    for (std::size_t i = 0; i < after.size(); ++i) lost_ += after[i] - before[i];
    return stale;
  }

  std::uint64_t lost() const { return lost_; }
  WireFigures& figures(std::size_t bus) { return wires_[bus]->figures(); }
  std::string complaint() const {
    for (std::size_t i = 0; i < options_.joints.size(); ++i) {
      const drivers::DriveComplaint& one = arm_->complaint(i);
      if (one.quantity != nullptr) {
        return fmt::format("{}: {} is {}, expected {}", options_.joints[i].name, one.quantity,
                           one.found, one.expected);
      }
    }
    return "not all drives followed torque";
  }

 private:
  const control::ArmState& cycle() {
    tick_ns_ += robot_.period_ns;
    for (VirtualWire* wire : wires_) wire->begin(tick_ns_);
    arm_->transmit(command_, tick_ns_);
    return arm_->receive(tick_ns_, 0);
  }

  bool until(DriveMode mode, DriveCondition condition) {
    for (control::JointCommand& one : command_.joint) one.mode = mode;
    for (int i = 0; i < kMostStartUp; ++i) {
      const control::ArmState& state = cycle();
      if (std::all_of(state.joint.begin(),
                      state.joint.begin() + static_cast<std::ptrdiff_t>(state.joints),
                      [&](const auto& joint) { return joint.condition == condition; })) {
        return true;
      }
    }
    return false;
  }

  std::vector<std::uint64_t> losses() const {
    std::vector<std::uint64_t> all;
    for (std::size_t i = 0; i < options_.joints.size(); ++i) {
      all.push_back(arm_->joint_counters(i).lost);
    }
    return all;
  }

  const config::Robot& robot_;
  drivers::ArmOptions options_;
  std::vector<VirtualWire*> wires_;
  std::unique_ptr<drivers::Arm> arm_;
  control::ArmCommand command_;
  std::int64_t tick_ns_ = 1'000'000'000;
  std::uint64_t lost_ = 0;
};

double us(double ns) {
  return ns * 1e-3;
}

ordered_json measure(const config::Robot& robot, int count) {
  Run run(robot);
  if (!run.start()) return {{"robot", robot.name}, {"holds", false}, {"why", run.complaint()}};
  const std::size_t stale = run.cycles(count);
  const config::BudgetReport budget = config::bus_budget(robot);
  bool holds = run.lost() == 0 && stale == 0;
  ordered_json buses = ordered_json::array();
  for (std::size_t i = 0; i < budget.buses.size(); ++i) {
    const config::BusLoad& load = budget.buses[i];
    const WireFigures& found = run.figures(i);
    const double cycles = static_cast<double>(std::max<std::int64_t>(found.cycles, 1));
    // A drive's own timer may run out at any moment of a cycle: only its answers have to come
    // early.
    const bool by_timer = std::any_of(load.plan.frames.begin(), load.plan.frames.end(),
                                      [](const auto& planned) { return planned.frame.unasked; });
    const double bound_us = us(static_cast<double>(load.plan.bound_ns()));
    holds = holds && (by_timer || found.latest_ns <= load.deadline_ns);
    buses.push_back({{"bus", load.name},
                     {"frames_a_cycle", static_cast<double>(found.carried) / cycles},
                     {"busy_us", us(static_cast<double>(found.busy_ns) / cycles)},
                     {"busy_best_us", us(static_cast<double>(load.budget().best_ns))},
                     {"busy_worst_us", us(static_cast<double>(load.budget().worst_ns))},
                     {"last_reply_us", us(static_cast<double>(found.last_sum_ns) / cycles)},
                     {"latest_reply_us", us(static_cast<double>(found.latest_ns))},
                     {"bound_us", by_timer ? ordered_json(nullptr) : ordered_json(bound_us)},
                     {"deadline_us", us(static_cast<double>(load.deadline_ns))},
                     {"reply_gap_us", us(static_cast<double>(found.gap_ns))},
                     {"limit_hz", load.plan.limit_hz()}});
  }
  return {{"robot", robot.name},      {"rate_hz", 1e9 / static_cast<double>(robot.period_ns)},
          {"cycles", count},          {"lost", run.lost()},
          {"stale", stale},           {"holds", holds},
          {"buses", std::move(buses)}};
}

int main_of(int argc, char** argv) {
  if (argc < 3) {
    fmt::print(stderr, "usage: wire_rate CYCLES ROBOT.toml...\n");
    return 2;
  }
  ordered_json all = ordered_json::array();
  bool hold = true;
  for (int i = 2; i < argc; ++i) {
    const config::LoadResult loaded = config::load_robot(argv[i]);
    if (!loaded.ok) {
      for (const config::Message& message : loaded.messages) {
        fmt::print(stderr, "{}\n", config::to_string(message));
      }
      return 1;
    }
    all.push_back(measure(loaded.robot, std::stoi(argv[1])));
    hold = hold && all.back()["holds"].get<bool>();
  }
  fmt::print("{}\n", all.dump(1));
  return hold ? 0 : 1;
}

}  // namespace
}  // namespace geodesic::bench

int main(int argc, char** argv) {
  try {
    return geodesic::bench::main_of(argc, argv);
  } catch (const std::exception& problem) {
    fmt::print(stderr, "wire_rate: {}\n", problem.what());
    return 1;
  }
}
