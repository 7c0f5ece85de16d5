// The driver in operation against the simulated drive: enabling, torque, faults, disabling.
#include "drivers/cia402/driver.hpp"

#include <gtest/gtest.h>

#include <algorithm>
#include <string>

#include "drivers/cia402/errors.hpp"
#include "rt/thread_health.hpp"
#include "tests/drivers/cia402/bench.hpp"

namespace geodesic::drivers::cia402::test {
namespace {

using control::DriveCondition;

constexpr double kStep = 0.028;  ///< [N·m], one per mille

/// Configured and enabled.
class Cia402Driver : public ::testing::Test {
 protected:
  void SetUp() override {
    ASSERT_GT(bench.run_until(DriveCondition::kDisabled), 0) << complaint();
    ASSERT_GT(bench.run_until(DriveCondition::kEnabled, enable()), 0) << complaint();
    ASSERT_TRUE(bench.drive.enabled());
    bench.sent.clear();
  }

  std::string complaint() const {
    const DriveComplaint& it = bench.driver.complaint();
    return it.quantity == nullptr ? "no complaint" : it.quantity;
  }

  /// Torque stays away for as long as the mode stays kEnable.
  void expect_out(DriveCondition condition) {
    bench.sent.clear();
    for (int i = 0; i < 500; ++i) {
      bench.cycle(enable(5.0));
      ASSERT_EQ(bench.driver.state().condition, condition);
      ASSERT_EQ(bench.drive.torque_nm(bench.now_ns), 0.0);
    }
    EXPECT_EQ(bench.sent_controlwords(0xFFFF), 0U);
    EXPECT_TRUE(bench.sent_on(cob::kSdoRequest + 3).empty());
  }

  Bench bench;
};

TEST_F(Cia402Driver, FollowsTorqueInTheSameCycle) {
  for (const double torque : {0.0, 1.5, -27.9, 41.99, 60.0, -60.0}) {
    bench.cycle(enable(torque));
    const double expected = std::clamp(torque, -42.0, 42.0);
    EXPECT_NEAR(bench.drive.torque_nm(bench.now_ns), expected, 0.5001 * kStep);
    EXPECT_NEAR(bench.driver.state().torque_nm, expected, 0.5001 * kStep);
    EXPECT_TRUE(bench.reported);
    EXPECT_EQ(bench.due, 2U);
    EXPECT_EQ(bench.heard, 2U);
  }
}

TEST_F(Cia402Driver, SendsTorqueThenHeartbeatThenSyncLast) {
  bench.run(20, enable(1.0));
  std::size_t heartbeats = 0;
  std::size_t syncs = 0;
  for (std::size_t i = 0; i < bench.sent.size(); ++i) {
    heartbeats += bench.sent[i].id == 0x77F ? 1U : 0U;
    if (decode_sync(bench.sent[i])) {
      ++syncs;
      EXPECT_TRUE(bench.sent[i - 1].id == 0x203 || bench.sent[i - 1].id == 0x77F);
    }
  }
  EXPECT_EQ(syncs, 20U);
  EXPECT_EQ(heartbeats, 2U);  // one in 10 ms
  EXPECT_EQ(bench.sent_on(0x203).size(), 20U);
}

TEST_F(Cia402Driver, OnlyTheLeaderSpeaksForTheBus) {
  DriveOptions options = bench_options();
  options.leader = false;
  Bench follower(options);
  follower.run(300, enable());
  EXPECT_TRUE(follower.sent_on(cob::kSync).empty());
  EXPECT_TRUE(follower.sent_on(0x77F).empty());
}

TEST_F(Cia402Driver, AddsStiffnessAndDampingFromWhatWasReported) {
  bench.drive.set_shaft(0.5, 2.0);
  bench.cycle(enable());
  DriveCommand command = enable(1.0);
  command.position_rad = 0.6;
  command.velocity_rad_s = 1.0;
  command.stiffness_nm_rad = 20.0;
  command.damping_nm_s_rad = 1.5;
  bench.cycle(command);
  EXPECT_NEAR(bench.drive.torque_nm(bench.now_ns), 1.0 + 20.0 * 0.1 - 1.5 * 1.0, 0.03);
  bench.deaf = true;  // 20 ms later that is no news to act on
  bench.run(25, command);
  EXPECT_NEAR(bench.drive.torque_nm(bench.now_ns), 1.0, kStep);
}

TEST_F(Cia402Driver, ReportsWhatItMeasures) {
  bench.drive.set_shaft(-3.25, 1.5);
  bench.cycle(enable());
  const DriveState& state = bench.driver.state();
  EXPECT_NEAR(state.position_rad, -3.25, 1e-5);
  EXPECT_NEAR(state.velocity_rad_s, 1.5, 1e-5);
  EXPECT_EQ(state.stamp_ns, bench.now_ns + 300'000);
  EXPECT_EQ(state.error, 0);
}

TEST_F(Cia402Driver, EveryUnitOfVelocityMeansTheSame) {
  for (int unit = 0; unit < 5; ++unit) {
    for (const Side side : {Side::kMotor, Side::kOutput}) {
      DriveOptions options = bench_options();
      put(options, Setting::kVelocityUnit, unit);
      put(options, Setting::kEncoderAt, static_cast<double>(side));
      put(options, Setting::kEncoderIncrements, 1 << 20);
      Bench other(options);
      ASSERT_GT(other.run_until(DriveCondition::kEnabled, enable()), 0) << unit;
      double shaft = 0.0;
      for (int i = 0; i < 10; ++i) {
        shaft += 3e-3;
        other.drive.set_shaft(shaft, 3.0);
        other.cycle(enable());
      }
      const bool coarse = unit == static_cast<int>(VelocityUnit::kRpm) && side == Side::kOutput;
      EXPECT_NEAR(other.driver.state().velocity_rad_s, 3.0, coarse ? 0.11 : 0.02) << unit;
      EXPECT_NEAR(other.driver.state().position_rad, shaft, 1e-5);
      EXPECT_EQ(other.due, unit == 0 ? 1U : 2U);
      EXPECT_EQ(other.heard, other.due);
    }
  }
}

TEST_F(Cia402Driver, OneTransitionForEachStateTheDriveHasReached) {
  Bench fresh;
  ASSERT_GT(fresh.run_until(DriveCondition::kDisabled), 0);
  fresh.sent.clear();
  fresh.deaf = true;
  fresh.run(30, enable(5.0));  // it moves on, but we do not hear of it
  for (const Frame& frame : fresh.sent_on(0x203)) {
    EXPECT_EQ(*decode_torque(frame), (TorqueCommand{control_word::kShutdown, 0}));
  }
  EXPECT_EQ(fresh.drive.power_state(), PowerState::kReady);
  fresh.deaf = false;
  fresh.sent.clear();
  ASSERT_GT(fresh.run_until(DriveCondition::kEnabled, enable(5.0)), 0);
  std::vector<std::uint16_t> words;
  for (const Frame& frame : fresh.sent_on(0x203)) {
    EXPECT_EQ(decode_torque(frame)->torque_permille, 0);
    words.push_back(decode_torque(frame)->controlword);
  }
  EXPECT_EQ(words, (std::vector<std::uint16_t>{0x06, 0x07, 0x0F}));
}

TEST_F(Cia402Driver, GivesUpOnADriveThatDoesNotBecomeEnabled) {
  Bench fresh;
  ASSERT_GT(fresh.run_until(DriveCondition::kDisabled), 0);
  fresh.drive.dictionary().set(object::kReceiveType, 240);
  fresh.drive.dictionary().set(object::kReceiveId, 0x204);  // it is deaf to its torque frames
  fresh.run(2500, enable(5.0));
  EXPECT_FALSE(fresh.drive.enabled());
  ASSERT_NE(fresh.driver.complaint().quantity, nullptr);
  fresh.drive.dictionary().set(object::kReceiveId, 0x203);
  fresh.run(100, enable(5.0));
  EXPECT_FALSE(fresh.drive.enabled());
}

TEST_F(Cia402Driver, DisablesByZeroTorqueThenDisableVoltage) {
  bench.cycle(enable(5.0));
  bench.sent.clear();
  bench.deaf = true;
  bench.run(4, disable());
  const std::vector<Frame> sent = bench.sent_on(0x203);
  EXPECT_EQ(*decode_torque(sent[0]), (TorqueCommand{0x0F, 0}));
  for (std::size_t i = 1; i < sent.size(); ++i) {
    EXPECT_EQ(*decode_torque(sent[i]), (TorqueCommand{0, 0}));
  }
  bench.deaf = false;
  bench.run(2, disable());
  EXPECT_EQ(bench.driver.state().condition, DriveCondition::kDisabled);
  EXPECT_FALSE(bench.drive.enabled());
  EXPECT_GT(bench.run_until(DriveCondition::kEnabled, enable()), 0);
}

TEST_F(Cia402Driver, TheDrivesWatchdogEndsTorqueAndItStaysAway) {
  bench.cycle(enable(5.0));
  bench.cut = true;
  bench.run(40, enable(5.0));
  EXPECT_GT(bench.drive.torque_nm(bench.now_ns), 4.9);
  bench.run(12, enable(5.0));
  EXPECT_EQ(bench.drive.torque_nm(bench.now_ns), 0.0);
  bench.cut = false;
  bench.run(3, enable(5.0));
  EXPECT_FALSE(bench.drive.enabled());
  EXPECT_NE(bench.driver.state().condition, DriveCondition::kEnabled);
  bench.run(500, enable(5.0));
  EXPECT_EQ(bench.drive.torque_nm(bench.now_ns), 0.0);
}

TEST_F(Cia402Driver, EveryErrorIsToldAndKeepsTheDriveOut) {
  for (std::uint8_t code = 1; code < 40; ++code) {
    Bench fresh;
    ASSERT_GT(fresh.run_until(DriveCondition::kEnabled, enable()), 0);
    fresh.drive.inject_error(code);
    fresh.cycle(enable(5.0));
    EXPECT_EQ(fresh.driver.state().condition, DriveCondition::kError);
    EXPECT_STRNE(error_name(fresh.driver.state().error), "unknown error");
    EXPECT_EQ(fresh.driver.state().error, error_of(emergency_of(code)));
    EXPECT_EQ(fresh.driver.complaint().found, emergency_of(code));
    fresh.sent.clear();
    fresh.run(200, enable(5.0));
    EXPECT_EQ(fresh.sent_controlwords(0xFFFF), 0U);
    EXPECT_EQ(fresh.drive.torque_nm(fresh.now_ns), 0.0);
  }
}

TEST_F(Cia402Driver, AFaultWithoutItsEmergencyIsAnErrorToo) {
  bench.drive.inject_error(2);
  std::array<Frame, 4> lost;
  bench.drive.speak(bench.now_ns, lost);
  bench.cycle(enable(5.0));
  EXPECT_EQ(bench.driver.state().condition, DriveCondition::kError);
  EXPECT_EQ(bench.driver.state().error, kUnspecifiedFault);
}

TEST_F(Cia402Driver, HeatEndsTorque) {
  bench.drive.set_temperature(101.0);
  bench.cycle(enable(5.0));
  EXPECT_STREQ(error_name(bench.driver.state().error), "drive over-temperature (0x4310)");
  bench.drive.set_temperature(40.0);
  expect_out(DriveCondition::kError);  // the drive keeps its error until it is reset
}

TEST_F(Cia402Driver, APowerCycleInOperationLeavesTheDriveOutUntilItIsStartedAnew) {
  bench.cycle(enable(5.0));
  bench.drive.power_cycle();
  EXPECT_EQ(bench.drive.dictionary().value(object::kConsumerHeartbeat), 0U);  // forgotten
  bench.cycle(enable(5.0));                                                   // its boot-up
  expect_out(DriveCondition::kDisabled);
  EXPECT_EQ(bench.driver.complaint().found, 0.0);
  bench.run(10, disable());
  EXPECT_EQ(bench.drive.nmt_state(), NmtState::kPreOperational);
  ASSERT_GT(bench.run_until(DriveCondition::kConfiguring), 0);
  ASSERT_GT(bench.run_until(DriveCondition::kDisabled), 0);
  EXPECT_EQ(bench.drive.dictionary().value(object::kConsumerHeartbeat), 0x7F0032U);
  EXPECT_GT(bench.run_until(DriveCondition::kEnabled, enable()), 0);
}

TEST_F(Cia402Driver, ADriveThatIsSwitchedOffByAnotherIsNotEnabledAgain) {
  std::array<Frame, 4> reply;
  bench.drive.receive(encode_torque(3, {0, 0}), bench.now_ns, reply);
  bench.drive.receive(encode_sync(), bench.now_ns, reply);
  ASSERT_FALSE(bench.drive.enabled());
  bench.cycle(enable(5.0));
  expect_out(DriveCondition::kDisabled);
  bench.driver.restart();  // nor by a restart, while it is still told to be enabled
  bench.run(300, enable(5.0));
  EXPECT_FALSE(bench.drive.enabled());
  bench.cycle(disable());
  EXPECT_GT(bench.run_until(DriveCondition::kEnabled, enable()), 0);
}

TEST_F(Cia402Driver, ADriveEnabledByAnotherIsDisabled) {
  bench.run(5, disable());
  std::array<Frame, 4> reply;
  for (const std::uint16_t word :
       {control_word::kShutdown, control_word::kSwitchOn, control_word::kEnableOperation}) {
    bench.drive.receive(encode_torque(3, {word, 0}), bench.now_ns, reply);
    bench.drive.receive(encode_sync(), bench.now_ns, reply);
  }
  ASSERT_TRUE(bench.drive.enabled());
  bench.run(2);
  EXPECT_FALSE(bench.drive.enabled());
}

TEST_F(Cia402Driver, NmtStopEndsTorqueAndKeepsTheDriveOut) {
  bench.cycle(enable(5.0));
  std::array<Frame, 4> reply;
  bench.drive.receive(encode_nmt({NmtCommand::kStop, 0}), bench.now_ns, reply);
  EXPECT_EQ(bench.drive.torque_nm(bench.now_ns), 0.0);
  bench.run(30, enable(5.0));  // its heartbeat tells
  EXPECT_EQ(bench.driver.complaint().found, 4.0);
  bench.drive.receive(encode_nmt({NmtCommand::kStart, 0}), bench.now_ns, reply);
  bench.run(50, enable(5.0));
  EXPECT_EQ(bench.drive.torque_nm(bench.now_ns), 0.0);
}

TEST_F(Cia402Driver, ADriveThatWasSilentWhileIdleIsConfiguredAnew) {
  bench.run(5, disable());
  bench.cut = true;
  bench.run(150);
  bench.drive.power_cycle();
  bench.cut = false;
  ASSERT_GT(bench.run_until(DriveCondition::kEnabled, enable()), 0);
  EXPECT_EQ(bench.drive.dictionary().value(object::kConsumerHeartbeat), 0x7F0032U);
}

TEST_F(Cia402Driver, TheDrivesHeartbeatIsWatched) {
  bench.drive.dictionary().set(object::kProducerHeartbeat, 0);
  bench.run(90, enable(1.0));
  EXPECT_EQ(bench.driver.state().condition, DriveCondition::kEnabled);
  bench.run(30, enable(1.0));
  EXPECT_NE(bench.driver.state().condition, DriveCondition::kEnabled);
  EXPECT_NE(complaint().find("0x1017"), std::string::npos);
  EXPECT_FALSE(bench.drive.enabled());
}

TEST_F(Cia402Driver, TwoDrivesOfOneNodeAreFoundOut) {
  const Frame doubled = encode_report(3, {0x1637, 0, 0});
  for (int i = 0; i < 400; ++i) {  // a link that doubles one frame in four
    bench.cycle(enable(1.0));
    if (i % 4 == 0) {
      bench.driver.receive({doubled, bench.now_ns});
    }
  }
  ASSERT_EQ(bench.driver.state().condition, DriveCondition::kEnabled);
  for (int i = 0; i < 60; ++i) {
    bench.cycle(enable(1.0));
    bench.driver.receive({doubled, bench.now_ns});
  }
  EXPECT_EQ(bench.driver.state().condition, DriveCondition::kRefused);
  EXPECT_NE(complaint().find("SYNC"), std::string::npos);
  bench.run(3, enable(1.0));
  EXPECT_FALSE(bench.drive.enabled());
}

TEST_F(Cia402Driver, FramesOfOthersAndOfOtherFormsAreNotItsOwn) {
  const DriveState before = bench.driver.state();
  const Frame right = encode_report(3, {0x1637, 5, 0});
  const auto refused = [&](auto change) {
    Frame frame = right;
    change(frame);
    return !bench.driver.receive({frame, bench.now_ns + 1});
  };
  EXPECT_TRUE(refused([](Frame& f) { f.id = 0x184; }));
  EXPECT_TRUE(refused([](Frame& f) { f.extended = true; }));
  EXPECT_TRUE(refused([](Frame& f) { f.length = 7; }));
  EXPECT_TRUE(refused([](Frame& f) { f.fd = true; }));
  EXPECT_TRUE(refused([](Frame& f) { f.remote = true; }));
  EXPECT_TRUE(refused([](Frame& f) { f.error = true; }));
  EXPECT_EQ(bench.driver.state().stamp_ns, before.stamp_ns);
}

TEST_F(Cia402Driver, PositionGoesOnWhereTheCounterWraps) {
  const double edge = 2147483640.0 / (16384.0 * 100.0) * 2.0 * 3.14159265358979;
  DriveOptions options = bench_options();
  Bench far(options);
  far.drive.set_shaft(edge, 0.0);
  ASSERT_GT(far.run_until(DriveCondition::kEnabled, enable()), 0);
  double shaft = edge;
  for (int i = 0; i < 50; ++i) {
    shaft += 1e-2;
    far.drive.set_shaft(shaft, 10.0);
    far.cycle(enable());
    ASSERT_NEAR(far.driver.state().position_rad, shaft, 1e-4) << i;
  }
}

TEST_F(Cia402Driver, DiffusesTheRemainderWhenAskedTo) {
  DriveOptions options = bench_options();
  options.error_diffusion = true;
  Bench other(options);
  ASSERT_GT(other.run_until(DriveCondition::kEnabled, enable()), 0);
  double sum = 0.0;
  for (int i = 0; i < 1000; ++i) {
    other.cycle(enable(0.0101));
    sum += other.drive.torque_nm(other.now_ns);
  }
  EXPECT_NEAR(sum / 1000.0, 0.0101, kStep / 1000.0);
}

TEST_F(Cia402Driver, NeverAllocates) {
  Bench fresh;
  fresh.sent.reserve(40'000);
  rt::RealtimeGuard guard;
  fresh.run(200);
  fresh.run(50, enable(1.0));
  fresh.drive.inject_error(9);
  fresh.run(50, enable(1.0));
  fresh.run(50, disable());
  fresh.driver.restart();
  fresh.run(200);
  fresh.drive.power_cycle();
  fresh.run(200);
  const rt::ThreadHealth seen = guard.seen();
  EXPECT_EQ(seen.allocations, 0U) << to_string(seen);
}

}  // namespace
}  // namespace geodesic::drivers::cia402::test
