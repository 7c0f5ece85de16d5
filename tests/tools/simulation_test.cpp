// The simulated arm on a socket bus, asked by the same driver side the daemon uses: locked to the
// commands and in real time, with its stand, pushes and faults.
#include "tools/sim/simulation.hpp"

#include <gtest/gtest.h>
#include <unistd.h>

#include <atomic>
#include <csignal>
#include <cstdio>
#include <fstream>
#include <future>
#include <thread>

#include "drivers/arm.hpp"
#include "rt/clock.hpp"
#include "tests/tools/sim_robot.hpp"
#include "tools/sim/summary.hpp"

namespace geodesic::tools {
namespace {

constexpr std::int64_t kPeriod = 1'000'000;

// A simulation in a thread of its own, stopped with the test.
class Running {
 public:
  Running(const config::Robot& robot, SimulationSettings settings) {
    settings.ready = [this](const std::string& line, const std::vector<std::string>&) {
      line_ = line;
      ready_.set_value();
    };
    sigset_t mask;
    sigemptyset(&mask);
    auto answering = ready_.get_future();
    result_ = std::async(std::launch::async, [this, robot, settings, mask] {
      return run_simulation(robot, settings, stop_, mask);
    });
    while (answering.wait_for(std::chrono::milliseconds(10)) != std::future_status::ready) {
      if (result_.wait_for(std::chrono::seconds(0)) == std::future_status::ready) {
        result_.get();  // throws what went wrong
        break;
      }
    }
  }
  ~Running() { stop_.store(true); }

  const std::string& line() const { return line_; }
  SimulationReport finish() {
    stop_.store(true);
    return result_.get();
  }
  /// Without asking it to stop.
  SimulationReport wait() { return result_.get(); }

 private:
  std::atomic<bool> stop_{false};
  std::string line_;
  std::promise<void> ready_;
  std::future<SimulationReport> result_;
};

class Simulation : public testing::Test {
 protected:
  config::Robot robot(int joints) {
    config::Robot result = test::chain(joints, 0.05, 0.01);
    result.arm.buses[0].interface = "unix:" + path_;
    result.period_ns = kPeriod;
    return result;
  }

  static control::ArmCommand command(int joints, control::DriveMode mode, double torque = 0.0) {
    control::ArmCommand result;
    result.joints = static_cast<std::size_t>(joints);
    for (int i = 0; i < joints; ++i) {
      result.joint[static_cast<std::size_t>(i)].mode = mode;
      result.joint[static_cast<std::size_t>(i)].torque = torque;
    }
    return result;
  }

  static bool all(const control::ArmState& state, control::DriveCondition condition) {
    for (std::size_t i = 0; i < state.joints; ++i) {
      if (state.joint[i].condition != condition) return false;
    }
    return true;
  }

  // Cycles in lockstep until the drives are enabled, then `cycles` more. @return the last state.
  static control::ArmState drive(drivers::Arm& arm, int joints, int cycles) {
    std::int64_t tick = kPeriod;
    int left = cycles;
    bool configured = false;
    control::ArmState state;
    for (int cycle = 0; cycle < 2000 + cycles && left > 0; ++cycle) {
      const auto mode = configured ? control::DriveMode::kEnable : control::DriveMode::kMonitor;
      arm.transmit(command(joints, mode), tick);
      state = arm.receive(tick, tick + kPeriod);
      configured = configured || all(state, control::DriveCondition::kDisabled);
      if (all(state, control::DriveCondition::kEnabled)) --left;
      tick += kPeriod;
    }
    EXPECT_EQ(left, 0) << "the drives were never enabled";
    return state;
  }

  void TearDown() override { std::remove(path_.c_str()); }
  std::string path_ = testing::TempDir() + "sim" + std::to_string(::getpid()) + "_" +
                      testing::UnitTest::GetInstance()->current_test_info()->name();
};

TEST_F(Simulation, LockstepAdvancesOnePeriodForEachSet) {
  config::Robot it = robot(3);
  it.gravity.setZero();
  SimulationSettings settings;
  settings.lockstep = true;
  settings.plant.release_s = 0.05;
  settings.plant.script.pushes.push_back({1, 0.5, 0.1, 0.02});
  Running running(it, settings);
  EXPECT_EQ(running.line().rfind("geodesic sim: answering on unix:", 0), 0U) << running.line();
  EXPECT_NE(running.line().find("3 drives"), std::string::npos) << running.line();

  drivers::ArmOptions options = it.arm;
  options.simulated_time = true;
  drivers::Arm arm(options);
  const control::ArmState state = drive(arm, 3, 800);
  const SimulationReport report = running.finish();
  EXPECT_EQ(report.incomplete_sets, 0U);
  EXPECT_NEAR(report.simulated_s, static_cast<double>(report.sets) * 1e-3, 1e-9);
  ASSERT_TRUE(report.plant.release_s.has_value());
  EXPECT_NEAR(*report.plant.release_s - *report.plant.enabled_s, 0.05, 1.1e-3);
  for (std::size_t i = 0; i < 3; ++i) {
    EXPECT_LT(report.plant.joints[i].motion_before, 1e-6);  // friction holds the codes' rounding
    EXPECT_EQ(arm.joint_counters(i).lost, 0U);
    // What the host was told is what the arm did, to the code's step.
    EXPECT_NEAR(state.joint[i].position, report.position[i], 25.0 / 65535.0);
  }
  EXPECT_GT(report.plant.joints[1].drift_max, 5e-3);  // the push
  ASSERT_TRUE(report.plant.rest_s.has_value());
}

TEST_F(Simulation, LockstepIsDeterministic) {
  config::Robot it = robot(3);
  std::vector<std::vector<double>> ends;
  for (int run = 0; run < 2; ++run) {
    SimulationSettings settings;
    settings.lockstep = true;
    settings.plant.release_s = 0.01;
    settings.seconds = 0.5;
    Running running(it, settings);
    drivers::ArmOptions options = it.arm;
    options.simulated_time = true;
    drivers::Arm arm(options);
    drive(arm, 3, 100);
    ends.push_back(running.finish().position);
  }
  EXPECT_EQ(ends[0], ends[1]);
}

TEST_F(Simulation, TheArmFallsWithoutTorqueOnceReleased) {
  config::Robot it = robot(2);
  it.tree.joints[0].axis = Eigen::Vector3d::UnitY();
  it.simulation.pose = {0.0, 0.0};
  SimulationSettings settings;
  settings.lockstep = true;
  settings.plant.release_s = 0.02;
  const std::string trace = path_ + ".csv";
  settings.trace = trace;
  settings.trace_hz = 1000.0;
  Running running(it, settings);
  drivers::ArmOptions options = it.arm;
  options.simulated_time = true;
  drivers::Arm arm(options);
  drive(arm, 2, 200);
  const SimulationReport report = running.finish();
  EXPECT_GT(report.plant.joints[0].drift_max, 0.1);
  EXPECT_GT(std::abs(report.plant.joints[0].residual), 0.5);
  const nlohmann::ordered_json summary = to_json(report, it);
  EXPECT_GT(summary["drift_before_stop"].get<double>(), 0.1);
  EXPECT_NEAR(summary["released_s"].get<double>(), 0.18, 0.01);

  std::ifstream lines(trace);
  std::string header;
  std::string first;
  ASSERT_TRUE(std::getline(lines, header) && std::getline(lines, first));
  EXPECT_EQ(header,
            "time_s,released,q_joint1,v_joint1,torque_joint1,q_joint2,v_joint2,torque_joint2");
  EXPECT_EQ(first.front(), '-');  // before the release
  std::remove(trace.c_str());
}

TEST_F(Simulation, ASilentDriveIsNotWaitedFor) {
  config::Robot it = robot(2);
  SimulationSettings settings;
  settings.lockstep = true;
  ScriptedFault fault;
  fault.joint = 1;
  fault.base = FaultBase::kStart;
  settings.plant.script.faults.push_back(fault);
  Running running(it, settings);
  drivers::ArmOptions options = it.arm;
  options.simulated_time = true;
  drivers::Arm arm(options);
  std::int64_t tick = kPeriod;
  control::ArmState state;
  for (int cycle = 0; cycle < 2; ++cycle) {
    arm.transmit(command(2, control::DriveMode::kMonitor), tick);
    state = arm.receive(tick, tick + kPeriod);
    tick += kPeriod;
  }
  EXPECT_TRUE(arm.joint_counters(0).received > 0);
  EXPECT_EQ(arm.joint_counters(1).received, 0U);
  const SimulationReport report = running.finish();
  EXPECT_GT(report.plant.joints[1].swallowed, 0U);
  EXPECT_EQ(report.incomplete_sets, 0U);
}

TEST_F(Simulation, InRealTimeRepliesTakeTheWiresTime) {
  config::Robot it = robot(2);
  it.simulation.reply_latency_s = 1e-3;
  SimulationSettings settings;
  Running running(it, settings);
  drivers::Arm arm(it.arm);
  std::int64_t shortest = kPeriod * 1000;
  for (int cycle = 0; cycle < 20; ++cycle) {
    const std::int64_t begin = rt::now_ns();
    arm.transmit(command(2, control::DriveMode::kMonitor), begin);
    const control::ArmState& state = arm.receive(begin, begin + 50 * kPeriod);
    if (state.joint[0].fresh && state.joint[1].fresh) {
      shortest = std::min(shortest, rt::now_ns() - begin);
    }
  }
  EXPECT_GT(shortest, 1'000'000 + 2 * 111'000);  // latency, command, reply
  const SimulationReport report = running.finish();
  EXPECT_EQ(report.buses[0].dropped, 0U);
  EXPECT_TRUE(report.buses[0].hosts_hub);
}

TEST_F(Simulation, TheDrivesWatchdogTripsWhenTheHostIsGone) {
  config::Robot it = robot(2);
  SimulationSettings settings;
  settings.wire = false;
  settings.plant.release_s = 100.0;
  Running running(it, settings);
  {
    drivers::Arm arm(it.arm);
    bool configured = false;
    bool enabled = false;
    for (int cycle = 0; cycle < 3000 && !enabled; ++cycle) {
      const std::int64_t now = rt::now_ns();
      const auto mode = configured ? control::DriveMode::kEnable : control::DriveMode::kMonitor;
      arm.transmit(command(2, mode), now);
      const control::ArmState& state = arm.receive(now, now + 5 * kPeriod);
      configured = configured || all(state, control::DriveCondition::kDisabled);
      enabled = all(state, control::DriveCondition::kEnabled);
    }
    ASSERT_TRUE(enabled);
  }
  std::this_thread::sleep_for(std::chrono::milliseconds(300));
  const SimulationReport report = running.finish();
  for (std::size_t i = 0; i < 2; ++i) {
    EXPECT_EQ(report.plant.joints[i].watchdog_trips, 1U);
    EXPECT_FALSE(report.enabled[i]);
  }
}

TEST_F(Simulation, EndsByItselfAfterItsSeconds) {
  SimulationSettings settings;
  settings.seconds = 0.05;
  Running running(robot(1), settings);
  EXPECT_NEAR(running.wait().simulated_s, 0.05, 1e-3);
}

TEST_F(Simulation, RefusesABusThereIsNot) {
  config::Robot it = robot(1);
  it.arm.buses[0].interface = "nocan7";
  EXPECT_THROW(Running(it, {}), drivers::BusError);
}

}  // namespace
}  // namespace geodesic::tools
