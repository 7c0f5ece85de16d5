// A drive family that only a folder and a line of the table know of, through the robot file, the
// arm, the simulated arm and its checks.
#include <gtest/gtest.h>
#include <unistd.h>

#include <atomic>
#include <csignal>
#include <cstdio>
#include <filesystem>
#include <fstream>
#include <future>
#include <sstream>
#include <string>

#include "config/robot.hpp"
#include "drivers/arm.hpp"
#include "drivers/families.hpp"
#include "tools/sim/simulation.hpp"

namespace geodesic {
namespace {

constexpr std::int64_t kPeriodNs = 1'000'000;
constexpr const char* kDrive =
    "{ family = \"dummy\", torque_range_nm = 54, velocity_range_rad_s = 45, watchdog_ms = 50, "
    "colour = \"green\" }";

class Eighth : public testing::Test {
 protected:
  void SetUp() override {
    std::filesystem::create_directories(folder_);
    std::filesystem::copy_file(source_ / "planar2r.urdf", folder_ / "planar2r.urdf",
                               std::filesystem::copy_options::overwrite_existing);
  }
  void TearDown() override { std::filesystem::remove_all(folder_); }

  /// planar2r with this family's drives in place of its own, written as a person would.
  config::LoadResult load(const std::string& drive) {
    std::ifstream in(source_ / "robot.toml");
    std::ofstream out(folder_ / "robot.toml");
    int drives = 0;
    for (std::string line; std::getline(in, line);) {
      if (line.rfind("drive = { family", 0) == 0) {
        line = "drive = " + drive;
      } else if (line.rfind("drive = { id", 0) == 0) {
        line = "drive = { id = " + std::to_string(++drives) + " }";
      } else if (line.rfind("interface", 0) == 0) {
        line = "interface = \"unix:" + (folder_ / "bus").string() + "\"";
      }
      out << line << "\n";
    }
    out.close();
    EXPECT_EQ(drives, 2) << "planar2r is written otherwise by now";
    return config::load_robot(folder_ / "robot.toml");
  }

  static std::string told(const config::LoadResult& result) {
    std::ostringstream text;
    for (const auto& message : result.messages) {
      text << message.text << "\n";
    }
    return text.str();
  }

  const std::filesystem::path source_ =
      std::filesystem::path(GEODESIC_SOURCE_DIR) / "config/robots/planar2r";
  const std::filesystem::path folder_ =
      std::filesystem::path(testing::TempDir()) / ("eighth" + std::to_string(::getpid()));
};

TEST_F(Eighth, StandsInTheTable) {
  const drivers::Family* family = drivers::find_family("dummy");
  ASSERT_NE(family, nullptr);
  EXPECT_NE(drivers::find_family("damiao"), nullptr);
  EXPECT_EQ(family->settings.size(), 1U);
}

TEST_F(Eighth, TheRobotFileKnowsItsOptionsAndRefusesWrongOnes) {
  const config::LoadResult good = load(kDrive);
  ASSERT_TRUE(good.ok) << told(good);
  EXPECT_EQ(good.robot.arm.joints[0].drive.family, "dummy");
  EXPECT_EQ(good.robot.arm.joints[0].drive.settings.values[0], 1.0);
  const config::LoadResult unpainted =
      load("{ family = \"dummy\", torque_range_nm = 54, velocity_range_rad_s = 45 }");
  EXPECT_FALSE(unpainted.ok);
  EXPECT_NE(told(unpainted).find("colour"), std::string::npos) << told(unpainted);
  const config::LoadResult blue = load(
      "{ family = \"dummy\", torque_range_nm = 54, velocity_range_rad_s = 45, colour = \"blue\" }");
  EXPECT_FALSE(blue.ok);
  EXPECT_NE(told(blue).find("green"), std::string::npos) << told(blue);
}

TEST_F(Eighth, TheArmDrivesTheSimulatedArm) {
  const config::LoadResult loaded = load(kDrive);
  ASSERT_TRUE(loaded.ok) << told(loaded);
  const config::Robot& robot = loaded.robot;
  tools::SimulationSettings settings;
  settings.lockstep = true;
  std::promise<void> answers;
  settings.ready = [&answers](const std::string&, const std::vector<std::string>&) {
    answers.set_value();
  };
  std::atomic<bool> stop{false};
  sigset_t mask;
  sigemptyset(&mask);
  auto simulation = std::async(std::launch::async,
                               [&] { return tools::run_simulation(robot, settings, stop, mask); });
  ASSERT_EQ(answers.get_future().wait_for(std::chrono::seconds(20)), std::future_status::ready);
  {
    drivers::ArmOptions options = robot.arm;
    options.simulated_time = true;
    drivers::Arm arm(options);
    control::ArmCommand command;
    command.joints = 2;
    control::ArmState state;
    double moved = 0.0;
    for (int cycle = 1; cycle <= 300; ++cycle) {
      for (std::size_t i = 0; i < 2; ++i) {
        command.joint[i].mode =
            cycle < 50 ? control::DriveMode::kMonitor : control::DriveMode::kEnable;
        command.joint[i].torque = i == 0 ? 50.0 : 0.0;  // more than the weight
      }
      const std::int64_t tick_ns = cycle * kPeriodNs;
      arm.transmit(command, tick_ns);
      state = arm.receive(tick_ns, tick_ns + kPeriodNs);
      moved = cycle == 49 ? state.joint[0].position : moved;
    }
    moved = state.joint[0].position - moved;
    EXPECT_EQ(state.joint[0].condition, control::DriveCondition::kEnabled);
    EXPECT_EQ(state.joint[1].condition, control::DriveCondition::kEnabled);
    EXPECT_TRUE(state.joint[0].fresh);
    EXPECT_EQ(arm.joint_counters(0).lost, 0U);
    EXPECT_GT(moved, 0.05) << "its torque reaches physics";
  }
  stop.store(true);
  EXPECT_EQ(simulation.get().incomplete_sets, 0U);
}

}  // namespace
}  // namespace geodesic
