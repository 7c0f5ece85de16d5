// Scripted faults as the bus sees them: what each drive answers after one, and who falls silent.
#include <gtest/gtest.h>

#include "drivers/damiao/codec.hpp"
#include "tests/tools/sim_robot.hpp"
#include "tools/sim/plant.hpp"

namespace geodesic::tools {
namespace {

using drivers::damiao::StateReport;

constexpr std::int64_t kMillisecond = 1'000'000;
constexpr double kStep = 25.0 / 65535.0;  // of the position's code

// Two joints at rest without gravity.
class PlantFaults : public testing::Test {
 protected:
  void play(FaultKind kind, double value = 0.0, std::uint8_t code = 0) {
    ScriptedFault fault;
    fault.joint = 1;
    fault.kind = kind;
    fault.value = value;
    fault.code = code;
    fault.base = FaultBase::kStart;
    fault.at_s = 0.01;
    PlantOptions options;
    options.script.faults.push_back(fault);
    robot_.gravity.setZero();
    plant_.emplace(robot_, options);
  }

  std::vector<StateReport> ask(std::size_t joint, std::int64_t at_ms) {
    plant_->advance(at_ms * kMillisecond);
    const drivers::DriveOptions& drive = robot_.arm.joints[joint].drive;
    std::vector<Plant::Answer> answers;
    plant_->hear(0, drivers::damiao::encode_state_request(drive.id, false), plant_->now_ns(),
                 answers);
    std::vector<StateReport> reports;
    for (const Plant::Answer& answer : answers) {
      EXPECT_EQ(answer.joint, joint);
      EXPECT_EQ(answer.frame.id, drive.reply_id);
      reports.push_back(*drivers::damiao::decode_report(
          answer.frame,
          {drive.position_range_rad, drive.velocity_range_rad_s, drive.torque_range_nm}));
    }
    return reports;
  }

  config::Robot robot_ = test::chain(2);
  std::optional<Plant> plant_;
};

TEST_F(PlantFaults, SilentForAWhile) {
  play(FaultKind::kSilent, 0.005);
  EXPECT_EQ(ask(1, 5).size(), 1U);
  EXPECT_EQ(ask(1, 13).size(), 0U);
  EXPECT_TRUE(plant_->silent(1));
  EXPECT_EQ(ask(0, 13).size(), 1U);
  EXPECT_EQ(ask(1, 20).size(), 1U);
  EXPECT_EQ(plant_->report().joints[1].swallowed, 1U);
}

TEST_F(PlantFaults, SilentForGood) {
  play(FaultKind::kSilent);
  EXPECT_EQ(ask(1, 500).size(), 0U);
}

TEST_F(PlantFaults, TheInjectionIsOnRecord) {
  play(FaultKind::kTemperature, 90.0);
  EXPECT_EQ(ask(1, 5).at(0).rotor_c, 25.0);
  EXPECT_EQ(ask(1, 20).at(0).rotor_c, 90.0);
  ASSERT_EQ(plant_->report().injections.size(), 1U);
  const Injection& injection = plant_->report().injections[0];
  EXPECT_EQ(injection.joint, 1U);
  EXPECT_EQ(injection.kind, FaultKind::kTemperature);
  EXPECT_NEAR(injection.at_s, 0.01, 1e-3);
  EXPECT_EQ(injection.at_ns, 10 * kMillisecond);
}

TEST_F(PlantFaults, EncoderJumps) {
  play(FaultKind::kEncoderJump, -0.4);
  EXPECT_NEAR(ask(1, 5).at(0).position_rad, 0.3, kStep);
  EXPECT_NEAR(ask(1, 20).at(0).position_rad, -0.1, kStep);
  EXPECT_NEAR(plant_->position(1), 0.3, 1e-6) << "the arm itself did not move";
}

TEST_F(PlantFaults, PositionStandsStillWhileTheJointMoves) {
  play(FaultKind::kEncoderStuck);
  plant_->advance(11 * kMillisecond);
  const std::vector<double> moved{0.3, 0.9};
  const std::vector<double> velocity{0.0, 0.5};
  plant_->physics().set_state(moved, velocity);
  const StateReport stuck = ask(1, 12).at(0);
  EXPECT_NEAR(stuck.position_rad, 0.3, kStep);
  EXPECT_NEAR(stuck.velocity_rad_s, 0.5, 0.02);
  EXPECT_GT(plant_->position(1), 0.8);
}

TEST_F(PlantFaults, ASecondDriveAnswersToo) {
  play(FaultKind::kDouble, 0.5);
  EXPECT_EQ(ask(1, 5).size(), 1U);
  const std::vector<StateReport> both = ask(1, 20);
  ASSERT_EQ(both.size(), 2U);
  EXPECT_NEAR(both[0].position_rad, 0.3, kStep);
  EXPECT_NEAR(both[1].position_rad, 0.8, kStep);
  EXPECT_EQ(ask(0, 20).size(), 1U);
}

TEST_F(PlantFaults, ABabblerSilencesTheWholeBus) {
  play(FaultKind::kBabble, 0.01);
  EXPECT_FALSE(plant_->babbling(0));
  EXPECT_EQ(ask(0, 15).size(), 0U);
  EXPECT_TRUE(plant_->babbling(0));
  EXPECT_TRUE(plant_->silent(0) && plant_->silent(1));
  EXPECT_EQ(ask(0, 25).size(), 1U);
}

TEST_F(PlantFaults, ABusIsHeldForItsTime) {
  play(FaultKind::kHoldBus, 0.01);
  plant_->advance(5 * kMillisecond);
  EXPECT_FALSE(plant_->held(0));
  plant_->advance(15 * kMillisecond);
  EXPECT_TRUE(plant_->held(0));
  plant_->advance(25 * kMillisecond);
  EXPECT_FALSE(plant_->held(0));
}

}  // namespace
}  // namespace geodesic::tools
