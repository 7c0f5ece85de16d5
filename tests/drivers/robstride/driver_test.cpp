// The RobStride driver against the simulated drive: torque, loss, faults, reboots, turns.
#include "drivers/robstride/driver.hpp"

#include <gtest/gtest.h>

#include <cmath>
#include <numbers>

#include "rt/heap_counter.hpp"
#include "tests/drivers/robstride/bench.hpp"

namespace geodesic::drivers::robstride::test {
namespace {

using control::DriveCondition;
using control::DriveMode;

TEST(RobstrideDriver, BringsTorqueAndTakesItBack) {
  Bench bench;
  ASSERT_GT(bench.run_until(DriveCondition::kEnabled, enable()), 0);
  EXPECT_EQ(bench.count(Type::kEnable), 1U);
  bench.run(2, enable(3.0));
  EXPECT_NEAR(bench.drive.torque_nm(bench.now_ns), 3.0, 5e-4);
  EXPECT_NEAR(bench.driver.state().torque_nm, 3.0, 1e-3);
  EXPECT_EQ(bench.frames, 1U);
  EXPECT_TRUE(bench.reported);
  bench.cycle(disable());
  EXPECT_NEAR(bench.drive.torque_nm(bench.now_ns), 0.0, 5e-4);
  bench.cycle(disable());
  EXPECT_FALSE(bench.drive.enabled());
  EXPECT_EQ(bench.driver.state().condition, DriveCondition::kDisabled);
}

TEST(RobstrideDriver, ADriveThatHoldsAnOldCommandRunsWithoutIt) {
  Bench bench;
  ASSERT_GT(bench.run_until(DriveCondition::kDisabled), 0);
  bench.ask(*encode_control(5, {.torque_nm = 10.0}, kRanges));  // kept until it runs
  for (int i = 0; i < 20; ++i) {
    bench.cycle(enable());
    EXPECT_NEAR(bench.drive.torque_nm(bench.now_ns + 400'000), 0.0, 5e-4);
  }
  EXPECT_TRUE(bench.drive.enabled());
}

TEST(RobstrideDriver, StiffnessAndDampingReachTheDrive) {
  Bench bench;
  ASSERT_GT(bench.run_until(DriveCondition::kEnabled, enable()), 0);
  bench.drive.set_shaft(0.5, 1.0);
  bench.cycle({.mode = DriveMode::kEnable,
               .torque_nm = 1.0,
               .position_rad = 0.6,
               .velocity_rad_s = 0.0,
               .stiffness_nm_rad = 20.0,
               .damping_nm_s_rad = 0.5});
  EXPECT_NEAR(bench.drive.torque_nm(bench.now_ns), 1.0 + 2.0 - 0.5, 0.02);
}

TEST(RobstrideDriver, ANonFiniteCommandBrakes) {
  Bench bench;
  ASSERT_GT(bench.run_until(DriveCondition::kEnabled, enable()), 0);
  bench.drive.set_shaft(0.0, 2.0);
  bench.cycle(enable(std::nan("")));
  EXPECT_NEAR(bench.drive.torque_nm(bench.now_ns), -2.0 * Driver::kFallbackDamping, 0.02);
  ASSERT_NE(bench.driver.complaint().quantity, nullptr);
}

TEST(RobstrideDriver, CountsOnWhereTheDriveWraps) {
  Bench bench;
  ASSERT_GT(bench.run_until(DriveCondition::kDisabled), 0);
  for (const double step : {0.05, -0.05}) {
    double shaft = bench.driver.state().position_rad;
    for (int i = 0; i < 1500; ++i) {
      shaft += step;
      bench.drive.set_shaft(shaft, 0.0);
      bench.cycle();
      ASSERT_NEAR(bench.driver.state().position_rad, shaft, 1.5e-3) << i;
    }
  }
}

TEST(RobstrideDriver, APositionAtTheEndOfARangeThatDoesNotWrapIsNone) {
  Bench bench(bench_options(true));
  ASSERT_GT(bench.run_until(DriveCondition::kDisabled), 0);
  bench.drive.set_shaft(12.4, 0.0);
  bench.cycle();
  EXPECT_TRUE(bench.reported);
  bench.drive.set_shaft(12.6, 0.0);
  bench.cycle();
  EXPECT_FALSE(bench.reported);
  EXPECT_NEAR(bench.driver.state().position_rad, 12.4, 1e-3);
}

TEST(RobstrideDriver, TheWatchdogStopsTheDriveAndItStaysOut) {
  Bench bench;
  ASSERT_GT(bench.run_until(DriveCondition::kEnabled, enable(5.0)), 0);
  bench.cut = true;
  bench.run(60, enable(5.0));
  EXPECT_EQ(bench.drive.torque_nm(bench.now_ns), 0.0);
  bench.cut = false;
  bench.run(500, enable(5.0));
  EXPECT_FALSE(bench.drive.enabled());
  EXPECT_EQ(bench.driver.state().condition, DriveCondition::kError);
  EXPECT_EQ(bench.driver.state().error, kLeftRunMode);
  bench.cycle();
  EXPECT_GT(bench.run_until(DriveCondition::kEnabled, enable()), 0);
}

TEST(RobstrideDriver, FaultsAreLatchedWhereverTheyAreTold) {
  for (const int each : {1, 2, 3, 4, 5, 6, 33, 36, 46, 48}) {
    const auto code = static_cast<std::uint8_t>(each);
    Bench bench;
    ASSERT_GT(bench.run_until(DriveCondition::kEnabled, enable(5.0)), 0);
    bench.drive.inject_error(code);
    bench.run(3, enable(5.0));
    EXPECT_EQ(bench.driver.state().condition, DriveCondition::kError) << int{code};
    // A frame is faster than the report of it: then the mode is what shows.
    EXPECT_TRUE(bench.driver.state().error == code ||
                (code >= kFirstReported && bench.driver.state().error == kLeftRunMode));
    bench.run(100, enable(5.0));
    EXPECT_FALSE(bench.drive.enabled());
    EXPECT_EQ(bench.driver.state().condition, DriveCondition::kError);
  }
}

TEST(RobstrideDriver, AFaultReportAloneIsEnough) {
  Bench bench;
  ASSERT_GT(bench.run_until(DriveCondition::kEnabled, enable(5.0)), 0);
  Frame report = encode_stop(kLink, false);
  report.id = identifier(Type::kFault, 5, 0xFD);
  report.data[4] = 1;  // a warning
  bench.driver.receive({report, bench.now_ns});
  EXPECT_EQ(bench.driver.state().condition, DriveCondition::kEnabled);
  report.data[0] = 0x10;
  bench.driver.receive({report, bench.now_ns});
  EXPECT_EQ(bench.driver.state().condition, DriveCondition::kError);
  EXPECT_EQ(bench.driver.state().error, kFirstReported + 4);
  bench.run(20, enable(5.0));
  EXPECT_FALSE(bench.drive.enabled());
}

TEST(RobstrideDriver, AnIdentityDuringOperationIsTheLossOfTheMotor) {
  Bench bench;
  ASSERT_GT(bench.run_until(DriveCondition::kEnabled, enable(5.0)), 0);
  Frame other = encode_stop(kLink, false);
  other.id = identifier(Type::kGetId, 6, kIdentityDestination);
  bench.driver.receive({other, bench.now_ns});
  EXPECT_EQ(bench.driver.state().condition, DriveCondition::kEnabled);
  bench.drive.power_cycle();  // a brown-out: it says so as it comes back
  bench.deaf = true;
  bench.cycle(enable(5.0));
  bench.deaf = false;
  other.id = identifier(Type::kGetId, 5, kIdentityDestination);
  bench.driver.receive({other, bench.now_ns});
  EXPECT_EQ(bench.driver.state().condition, DriveCondition::kError);
  EXPECT_EQ(bench.driver.state().error, kRebooted);
  bench.run(200, enable(5.0));
  EXPECT_FALSE(bench.drive.enabled());
  EXPECT_EQ(bench.drive.parameter_raw(0x7028), 0U);  // its watchdog is off, and it is left off
  bench.cycle();
  ASSERT_GT(bench.run_until(DriveCondition::kEnabled, enable()), 0);
  EXPECT_EQ(bench.drive.parameter_raw(0x7028), 1000U);
}

TEST(RobstrideDriver, AnIdleDriveThatWasOffIsConfiguredAnew) {
  Bench bench;
  ASSERT_GT(bench.run_until(DriveCondition::kDisabled), 0);
  bench.drive.power_cycle();
  EXPECT_EQ(bench.drive.parameter_raw(0x7028), 0U);
  bench.cycle();
  ASSERT_GT(bench.run_until(DriveCondition::kDisabled), 0);
  EXPECT_EQ(bench.drive.parameter_raw(0x7028), 1000U);
}

TEST(RobstrideDriver, ErrorDiffusionMakesTheMeanExact) {
  for (const bool on : {false, true}) {
    DriveOptions options = bench_options();
    options.error_diffusion = on;
    Bench bench(options);
    ASSERT_GT(bench.run_until(DriveCondition::kEnabled, enable()), 0);
    const double code = 34.0 / 65535.0;
    const double wanted = 0.3 * code;  // from the middle of two codes
    double sum = 0.0;
    for (int i = 0; i < 1000; ++i) {
      bench.cycle(enable(wanted));
      sum += bench.drive.torque_nm(bench.now_ns);
    }
    EXPECT_EQ(std::abs(sum / 1000.0 - wanted) < 0.01 * code, on) << sum / 1000.0 / code;
  }
}

TEST(RobstrideDriver, ForeignFramesChangeNothing) {
  Bench bench;
  ASSERT_GT(bench.run_until(DriveCondition::kEnabled, enable(1.0)), 0);
  const std::int64_t stamp = bench.driver.state().stamp_ns;
  Frame frame = encode_stop(kLink, false);
  for (const std::uint32_t id :
       {identifier(Type::kFeedback, 6, 0xFD), identifier(Type::kFeedback, 5, 0xFE),
        identifier(Type::kFault, 6, 0xFD), identifier(Type::kRead, 6, 0xFD)}) {
    frame.id = id;
    frame.data[0] = 0xFF;
    EXPECT_FALSE(bench.driver.receive({frame, bench.now_ns + 1}));
    EXPECT_EQ(bench.driver.state().condition, DriveCondition::kEnabled);
    EXPECT_EQ(bench.driver.state().stamp_ns, stamp);
  }
}

TEST(RobstrideDriver, ItsFiltersLetInWhatStandsInTheIdentifier) {
  const Bench bench;
  const auto matches = [](const std::vector<IdFilter>& filters, std::uint32_t id) {
    return std::any_of(filters.begin(), filters.end(),
                       [id](const IdFilter& filter) { return filter.matches(id, true); });
  };
  const std::vector<IdFilter> replies = bench.driver.reply_ids();
  for (const std::uint32_t id :
       {0x028005FDU, 0x020105FDU, 0x110005FDU, 0x110105FDU, 0x150005FDU, 0x000005FEU}) {
    EXPECT_TRUE(matches(replies, id)) << id;
  }
  for (const std::uint32_t id : {0x028006FDU, 0x028005FEU, 0x120005FDU, 0x000006FEU}) {
    EXPECT_FALSE(matches(replies, id)) << id;
  }
  const std::vector<IdFilter> commands = bench.driver.command_ids();
  for (double torque = -17.0; torque <= 17.0; torque += 1.0) {
    EXPECT_TRUE(matches(commands, encode_control(5, {.torque_nm = torque}, kRanges)->id));
  }
  EXPECT_FALSE(matches(commands, encode_control(6, {}, kRanges)->id));
  for (const IdFilter& reply : replies) {
    for (const IdFilter& command : commands) {
      EXPECT_FALSE(overlap(reply, command));
    }
  }
}

TEST(RobstrideDriver, NeverTouchesTheHeap) {
  Bench bench;
  bench.sent.reserve(10'000);
  const std::uint64_t calls = rt::heap_calls();
  bench.run_until(DriveCondition::kEnabled, enable());
  bench.run(10, enable(1.0));
  bench.run(10, disable());
  bench.driver.restart();
  bench.run(30);
  EXPECT_EQ(rt::heap_calls(), calls);
}

}  // namespace
}  // namespace geodesic::drivers::robstride::test
