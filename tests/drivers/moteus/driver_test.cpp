// The moteus driver in operation against the simulated drive: enabling, torque, faults, disabling.
#include "drivers/moteus/driver.hpp"

#include <gtest/gtest.h>

#include <cmath>

#include "rt/thread_health.hpp"
#include "tests/drivers/moteus/bench.hpp"

namespace geodesic::drivers::moteus::test {
namespace {

using control::DriveCondition;

/// Configured and enabled.
class MoteusDriver : public ::testing::Test {
 protected:
  void SetUp() override {
    ASSERT_GT(bench.run_until(DriveCondition::kDisabled), 0);
    ASSERT_GT(bench.run_until(DriveCondition::kEnabled, enable()), 0);
    ASSERT_EQ(bench.drive.mode(), 10);
    bench.sent.clear();
  }

  /// Torque stays away for as long as the mode stays kEnable.
  void expect_out(DriveCondition condition) {
    bench.sent.clear();
    for (int i = 0; i < 500; ++i) {
      bench.cycle(enable(5.0));
      ASSERT_EQ(bench.driver.state().condition, condition);
      ASSERT_EQ(bench.torque(), 0.0);
    }
    EXPECT_EQ(bench.sent_mode(Mode::kPosition), 0U);
    EXPECT_EQ(bench.sent_mode(Mode::kStopped), 0U);
  }

  Bench bench;
};

TEST_F(MoteusDriver, MonitorsByAskingNotByCommanding) {
  Bench fresh;
  ASSERT_GT(fresh.run_until(DriveCondition::kDisabled), 0);
  fresh.sent.clear();
  fresh.run(50);
  const Frame query = encode_query(link_for(fresh.options), formats_for(fresh.options));
  EXPECT_EQ(fresh.sent, std::vector<Frame>(50, query));
  EXPECT_TRUE(fresh.reported);
}

TEST_F(MoteusDriver, FollowsTorqueInBothResolutions) {
  for (const double resolution : {0.0, 1.0}) {
    Bench fresh(with(kResolution, resolution));
    ASSERT_GT(fresh.run_until(DriveCondition::kEnabled, enable()), 0);
    for (const double torque : {0.0, 1.5, -9.99, 10.0, 42.0, -42.0}) {
      fresh.run(2, enable(torque));
      const double expected = std::clamp(torque, -10.0, 10.0);
      EXPECT_NEAR(fresh.torque(), expected, resolution == 0.0 ? 0.0051 : 1e-6);
      EXPECT_NEAR(fresh.driver.state().torque_nm, expected, resolution == 0.0 ? 0.0151 : 1e-6);
      EXPECT_EQ(fresh.frames, 1U);
    }
  }
}

TEST_F(MoteusDriver, ATorqueFrameHasTheVendorsFieldsAndLength) {
  bench.cycle(enable(1.25));
  const Frame& frame = bench.sent.back();
  EXPECT_EQ(frame.id, 0x8005U);
  EXPECT_TRUE(frame.extended && frame.fd && frame.bit_rate_switch);
  EXPECT_EQ(frame.length, 32);
  EXPECT_TRUE(std::isnan(written(frame, Register::kCommandPosition).value()));
  EXPECT_EQ(written(frame, Register::kCommandTorque), 1.25);
  EXPECT_EQ(written(frame, Register::kCommandKpScale), 0.0);
  EXPECT_EQ(written(frame, Register::kCommandKdScale), 0.0);
  EXPECT_EQ(written(frame, Register::kCommandIlimitScale), 0.0);
  EXPECT_EQ(written(frame, Register::kCommandMaxTorque), 10.0);
  EXPECT_EQ(written(frame, Register::kCommandTimeout), 0.05);
  EXPECT_FALSE(written(frame, Register::kCommandVelocity));
  Bench floats(with(kResolution, 1.0));
  ASSERT_GT(floats.run_until(DriveCondition::kEnabled, enable()), 0);
  floats.cycle(enable(1.25));
  EXPECT_EQ(floats.sent.back().length, 48);
}

TEST_F(MoteusDriver, StiffnessAndDampingAreMadeHereWhereTheDrivesGainsAreUnknown) {
  bench.drive.set_shaft(0.5, 2.0);
  DriveCommand command = enable(1.0);
  command.position_rad = 0.6;
  command.velocity_rad_s = 1.0;
  command.stiffness_nm_rad = 20.0;
  command.damping_nm_s_rad = 1.5;
  bench.run(2, command);
  EXPECT_NEAR(bench.torque(), 1.0 + 20.0 * 0.1 - 1.5 * 1.0, 0.02);
  EXPECT_EQ(written(bench.sent.back(), Register::kCommandKpScale), 0.0);
  bench.deaf = true;  // what was measured is soon too old to act on
  bench.run(8, command);
  EXPECT_NEAR(bench.torque(), 1.0, 0.02);
}

TEST_F(MoteusDriver, StiffnessAndDampingAreMadeInTheDriveAsFarAsItsGainsGo) {
  for (const double resolution : {0.0, 1.0}) {
    Bench fresh(
        with(kKp, 60.0, with(kKd, 6.0, with(kResolution, resolution))));  // 9.55, 0.955 per rad
    ASSERT_GT(fresh.run_until(DriveCondition::kEnabled, enable()), 0);
    fresh.drive.set_shaft(0.5, 2.0);
    DriveCommand command = enable(1.0);
    command.position_rad = 0.6;
    command.velocity_rad_s = 1.0;
    command.stiffness_nm_rad = 5.0;
    command.damping_nm_s_rad = 0.5;
    fresh.run(2, command);
    EXPECT_NEAR(fresh.torque(), 1.0 + 5.0 * 0.1 - 0.5, 0.02);
    EXPECT_EQ(written(fresh.sent.back(), Register::kCommandTorque), 1.0);
    // Beyond what scale 1 makes, the rest comes from here.
    command.stiffness_nm_rad = 20.0;
    command.damping_nm_s_rad = 1.5;
    fresh.run(2, command);
    EXPECT_NEAR(fresh.torque(), 1.0 + 20.0 * 0.1 - 1.5, 0.02);
    EXPECT_NEAR(written(fresh.sent.back(), Register::kCommandKpScale).value(), 1.0, 1e-4);
    // Damping alone names no position.
    fresh.run(2, {.mode = control::DriveMode::kEnable, .damping_nm_s_rad = 0.5});
    EXPECT_TRUE(std::isnan(written(fresh.sent.back(), Register::kCommandPosition).value()));
    EXPECT_NEAR(fresh.torque(), -1.0, 0.02);
  }
}

TEST_F(MoteusDriver, ReportsWhatItMeasures) {
  bench.drive.set_shaft(-3.25, 7.5);
  bench.drive.set_temperature(61.0);
  bench.cycle(enable());
  const DriveState& state = bench.driver.state();
  EXPECT_NEAR(state.position_rad, -3.25, kTurn * 1e-5);
  EXPECT_NEAR(state.velocity_rad_s, 7.5, kTurn * 2.5e-4);
  EXPECT_EQ(state.temperature_c, 61.0);
  EXPECT_EQ(state.stamp_ns, bench.now_ns + 300'000);
  EXPECT_EQ(state.error, 0);
}

TEST_F(MoteusDriver, PositionsBeyond16BitsTravelIn32) {
  bench.drive.set_shaft(100.0, 0.0);  // 15.9 rev
  bench.cycle(enable());
  EXPECT_NEAR(bench.driver.state().position_rad, 100.0, 1e-3);
  DriveOptions narrow = bench_options();
  narrow.position_range_rad = 12.5;  // the robot file says no further: 16 bits
  Bench fresh(narrow);
  ASSERT_GT(fresh.run_until(DriveCondition::kEnabled, enable()), 0);
  fresh.drive.set_shaft(-20.0, 0.0);
  fresh.cycle(enable());
  EXPECT_TRUE(fresh.reported);
  fresh.drive.set_shaft(21.0, 0.0);  // and it does: saturated, so no position at all
  fresh.cycle(enable());
  EXPECT_FALSE(fresh.reported);
  EXPECT_NEAR(fresh.driver.state().position_rad, -20.0, 1e-3);
  ASSERT_NE(fresh.driver.complaint().quantity, nullptr);
  EXPECT_NEAR(fresh.driver.complaint().found, 3.2767, 1e-9);
}

TEST_F(MoteusDriver, EnablesWithZeroTorqueUntilTheDriveIsInPositionMode) {
  Bench fresh;
  ASSERT_GT(fresh.run_until(DriveCondition::kDisabled), 0);
  fresh.sent.clear();
  const int cycles = fresh.run_until(DriveCondition::kEnabled, enable(5.0));
  EXPECT_GE(cycles, 10);  // the drive takes its time
  for (const Frame& frame : fresh.sent) {
    EXPECT_EQ(written(frame, Register::kCommandTorque), 0.0);
  }
  EXPECT_NEAR(fresh.drive.timeout_s(), 0.05F, 1e-6F);
  EXPECT_NEAR(fresh.drive.max_torque(), 10.0F, 1e-5F);
}

TEST_F(MoteusDriver, GivesUpOnADriveThatDoesNotBecomeEnabled) {
  Bench fresh;
  ASSERT_GT(fresh.run_until(DriveCondition::kDisabled), 0);
  fresh.cut = true;
  fresh.run(1000, enable(5.0));
  EXPECT_LE(fresh.sent_mode(Mode::kPosition), 500U);
  EXPECT_NE(fresh.driver.complaint().quantity, nullptr);
  fresh.cut = false;
  fresh.run(100, enable(5.0));
  EXPECT_FALSE(fresh.drive.enabled());
}

TEST_F(MoteusDriver, DisablesByZeroTorqueThenStop) {
  bench.cycle(enable(5.0));
  bench.sent.clear();
  bench.deaf = true;
  bench.run(4, disable());
  EXPECT_EQ(written(bench.sent[0], Register::kCommandTorque), 0.0);
  for (std::size_t i = 1; i < 4; ++i) {
    EXPECT_EQ(written(bench.sent[i], Register::kMode), 0.0);
  }
  bench.deaf = false;
  bench.run(2, disable());
  EXPECT_EQ(bench.driver.state().condition, DriveCondition::kDisabled);
  EXPECT_FALSE(written(bench.sent.back(), Register::kMode));
  EXPECT_FALSE(bench.drive.enabled());
  EXPECT_GT(bench.run_until(DriveCondition::kEnabled, enable()), 0);
}

TEST_F(MoteusDriver, TheDrivesWatchdogEndsTorqueAndItStaysAway) {
  bench.cycle(enable(5.0));
  bench.cut = true;
  bench.run(49, enable(5.0));
  EXPECT_GT(bench.torque(), 4.9);
  bench.run(3, enable(5.0));
  EXPECT_EQ(bench.torque(), 0.0);
  bench.cut = false;
  bench.cycle(enable(5.0));
  EXPECT_EQ(bench.drive.mode(), 11);
  EXPECT_EQ(bench.driver.state().error, 11);
  expect_out(DriveCondition::kError);
  bench.run(50, disable());  // its error can still be read
  EXPECT_EQ(bench.driver.state().error, 11);
}

TEST_F(MoteusDriver, EveryFaultIsToldAndKeepsTheDriveOut) {
  for (std::uint8_t code = 32; code <= 50; ++code) {
    Bench fresh;
    ASSERT_GT(fresh.run_until(DriveCondition::kEnabled, enable()), 0);
    fresh.drive.inject_error(code);
    fresh.cycle(enable(5.0));
    EXPECT_EQ(fresh.driver.state().condition, DriveCondition::kError);
    EXPECT_EQ(fresh.driver.state().error, code);
    fresh.sent.clear();
    fresh.run(100, enable(5.0));
    EXPECT_EQ(fresh.sent_mode(Mode::kPosition) + fresh.sent_mode(Mode::kStopped), 0U);
    EXPECT_EQ(fresh.torque(), 0.0);
  }
}

TEST_F(MoteusDriver, ALimitIsNoFault) {
  Frame reply;
  reply.id = 0x0500;
  reply.fd = true;
  reply.length = 24;
  reply.data = {0x21, 0x00, 0x0A, 0x29, 0x01, 0,    0,    0,  0, 0x26,
                0x02, 0,    0,    0,    0,    0x22, 0x0E, 30, 99};
  std::fill(reply.data.begin() + 19, reply.data.begin() + 24, std::uint8_t{0x50});
  EXPECT_TRUE(bench.driver.receive({reply, bench.now_ns + 1}));
  EXPECT_EQ(bench.driver.state().error, 0);
  EXPECT_EQ(bench.driver.state().condition, DriveCondition::kEnabled);
}

TEST_F(MoteusDriver, HeatAndALostEncoderEndTorque) {
  bench.drive.set_temperature(80.0);
  bench.cycle(enable(5.0));
  EXPECT_EQ(bench.driver.state().error, 38);
  bench.drive.set_temperature(40.0);
  expect_out(DriveCondition::kError);
  Bench fresh;
  ASSERT_GT(fresh.run_until(DriveCondition::kEnabled, enable()), 0);
  fresh.drive.lose_encoder();
  fresh.cycle(enable(5.0));
  EXPECT_EQ(fresh.driver.state().error, 43);
  EXPECT_FALSE(fresh.reported);  // a position that is NaN is none
  EXPECT_NE(fresh.driver.complaint().quantity, nullptr);
}

TEST_F(MoteusDriver, APowerCycleInOperationLeavesTheDriveOutThoughOurFramesCouldStartIt) {
  bench.cycle(enable(5.0));
  bench.drive.power_cycle();
  for (int i = 0; i < 500; ++i) {
    bench.cycle(enable(5.0));
    ASSERT_EQ(bench.torque(), 0.0);
  }
  EXPECT_FALSE(bench.drive.enabled());
  EXPECT_EQ(bench.driver.state().condition, DriveCondition::kDisabled);
  bench.run(10, disable());
  ASSERT_GT(bench.run_until(DriveCondition::kConfiguring), 0);
  ASSERT_GT(bench.run_until(DriveCondition::kDisabled), 0);
  EXPECT_GT(bench.run_until(DriveCondition::kEnabled, enable()), 0);
}

TEST_F(MoteusDriver, AfterALongSilenceNothingStartsTheDrive) {
  bench.cycle(enable(5.0));
  bench.cut = true;
  bench.run(90, enable(5.0));
  EXPECT_EQ(bench.sent_mode(Mode::kPosition), 91U);  // it may still hear us
  bench.run(30, enable(5.0));
  EXPECT_EQ(bench.driver.state().condition, DriveCondition::kEnabled);  // as it last said
  bench.sent.clear();
  bench.drive.power_cycle();
  bench.cut = false;
  bench.run(100, enable(5.0));
  EXPECT_EQ(bench.sent_mode(Mode::kPosition), 0U);
  EXPECT_EQ(bench.drive.mode(), 0);
  EXPECT_EQ(bench.driver.state().condition, DriveCondition::kDisabled);
}

TEST_F(MoteusDriver, ADriveStoppedOrStartedByAnotherIsNotOurs) {
  std::array<Frame, 1> reply;
  bench.drive.receive(encode_stop({1, 5, 0}, {}), bench.now_ns, reply);
  for (int i = 0; i < 300; ++i) {
    bench.cycle(enable(5.0));
    ASSERT_EQ(bench.torque(), 0.0);
  }
  bench.driver.restart();  // nor by a restart, while it is still told to be enabled
  bench.run(100, enable(5.0));
  EXPECT_FALSE(bench.drive.enabled());
  bench.run(5, disable());
  PositionCommand other;
  other.max_torque_nm = 1.0;
  other.watchdog_ns = 1'000'000'000;
  bench.drive.receive(encode_position({1, 5, 0}, {}, other, false).value(), bench.now_ns, reply);
  bench.run(3);
  EXPECT_FALSE(bench.drive.enabled());
}

TEST_F(MoteusDriver, ADriveThatWasSilentWhileIdleIsConfiguredAnew) {
  bench.run(5, disable());
  bench.cut = true;
  bench.run(150);
  bench.cut = false;
  bench.sent.clear();
  ASSERT_GT(bench.run_until(DriveCondition::kConfiguring), 0);
  ASSERT_GT(bench.run_until(DriveCondition::kEnabled, enable()), 0);
}

TEST_F(MoteusDriver, FramesOfOthersAndNonsenseAreNotItsState) {
  const DriveState before = bench.driver.state();
  Frame frame;
  frame.id = 0x0600;
  frame.fd = true;
  frame.length = 24;
  frame.data = {0x21, 0x00, 0x0A, 0x2F, 0x01};
  EXPECT_FALSE(bench.driver.receive({frame, bench.now_ns}));
  frame.id = 0x0500;
  frame.data = {0x60, 0x01, 0x02};
  EXPECT_FALSE(bench.driver.receive({frame, bench.now_ns}));
  frame.data = {0x21, 0x00, 0x0A, 0x2F, 0x01, 0x00, 0x00, 0x80, 0x7F};  // infinity
  EXPECT_FALSE(bench.driver.receive({frame, bench.now_ns}));
  frame.data = {0x21, 0x00, 0x0A, 0x2D, 0x01, 0x00, 0x00, 0xC8, 0x42};  // a position and no more
  EXPECT_FALSE(bench.driver.receive({frame, bench.now_ns}));
  EXPECT_EQ(bench.driver.state().stamp_ns, before.stamp_ns);
  EXPECT_EQ(bench.driver.state().position_rad, before.position_rad);
}

TEST_F(MoteusDriver, ErrorDiffusionMakesTheMeanTorqueExact) {
  DriveOptions options = bench_options();
  options.error_diffusion = true;
  for (const double torque : {0.0034, -1.2372, 9.9999, 0.3}) {
    Bench fresh(options);
    ASSERT_GT(fresh.run_until(DriveCondition::kEnabled, enable()), 0);
    double sum = 0.0;
    for (int i = 0; i < 2000; ++i) {
      fresh.cycle(enable(torque));
      sum += written(fresh.sent.back(), Register::kCommandTorque).value();
    }
    EXPECT_NEAR(sum / 2000.0, torque, 1e-5);
  }
}

TEST_F(MoteusDriver, NeverAllocates) {
  for (const double resolution : {0.0, 1.0}) {
    Bench fresh(with(kKp, 60.0, with(kHome, 1.0, with(kResolution, resolution))));
    fresh.sent.reserve(10'000);
    rt::RealtimeGuard guard;
    fresh.run(100);
    fresh.run(100, enable(1.0));
    fresh.drive.inject_error(33);
    fresh.run(50, enable(1.0));
    fresh.run(50, disable());
    fresh.driver.restart();
    fresh.run(50);
    const rt::ThreadHealth seen = guard.seen();
    EXPECT_EQ(seen.allocations, 0U) << to_string(seen);
  }
}

TEST_F(MoteusDriver, NamesItsIdentifiers) {
  ASSERT_EQ(bench.driver.reply_ids().size(), 1U);
  EXPECT_EQ(bench.driver.reply_ids()[0].id, 0x500U);
  EXPECT_FALSE(bench.driver.reply_ids()[0].extended);
  DriveOptions far = bench_options();
  far.id = 8;  // from here on replies do not fit into 11 bits
  EXPECT_TRUE(Driver(far).reply_ids()[0].extended);
  EXPECT_EQ(Driver(far).reply_ids()[0].id, 0x800U);
  const auto commanded = [&](std::uint32_t id, bool extended) {
    for (const IdFilter& filter : bench.driver.command_ids()) {
      if (filter.matches(id, extended)) return true;
    }
    return false;
  };
  EXPECT_TRUE(commanded(0x8005, true));
  EXPECT_TRUE(commanded(0x0105, false));  // from anybody
  EXPECT_FALSE(commanded(0x8006, true));
  EXPECT_FALSE(commanded(0x0500, false));
  EXPECT_FALSE(commanded(0x01238005, true));
}

TEST_F(MoteusDriver, SpeaksWithAPrefixAndAnotherHostId) {
  Bench fresh(with(kPrefix, 0x123, with(kHostId, 3)));
  ASSERT_GT(fresh.run_until(DriveCondition::kEnabled, enable()), 0);
  EXPECT_EQ(fresh.sent.back().id, 0x01238305U);
  EXPECT_EQ(fresh.driver.reply_ids()[0].id, 0x01230503U);
}

}  // namespace
}  // namespace geodesic::drivers::moteus::test
