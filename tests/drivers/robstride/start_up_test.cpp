// The start-up dialogue against the simulated drive: what it reads, writes, refuses and survives.
#include <gtest/gtest.h>

#include <cmath>
#include <numbers>
#include <string>

#include "tests/drivers/robstride/bench.hpp"

namespace geodesic::drivers::robstride::test {
namespace {

using control::DriveCondition;

bool names(const DriveComplaint& complaint, const std::string& text) {
  return complaint.quantity != nullptr &&
         std::string(complaint.quantity).find(text) != std::string::npos;
}

TEST(RobstrideStartUp, ConfiguresADriveAndEndsStopped) {
  Bench bench;
  bench.drive.set_shaft(1.0, 0.0);
  EXPECT_EQ(bench.driver.state().condition, DriveCondition::kUnknown);
  const int cycles = bench.run_until(DriveCondition::kDisabled);
  EXPECT_GT(cycles, 8);
  EXPECT_LT(cycles, 30);
  EXPECT_EQ(bench.driver.complaint().quantity, nullptr);
  EXPECT_EQ(bench.drive.parameter_raw(0x7028), 1000U);  // 50 ms in 50 µs
  EXPECT_EQ(bench.count(Type::kWrite), 1U);             // the others were right
  EXPECT_EQ(bench.count(Type::kEnable), 0U);
  EXPECT_EQ(bench.count(encode_reports(kLink, false)), 2U);  // once more after it was switched on
  EXPECT_EQ(bench.driver.firmware(), 206U);
  EXPECT_NEAR(bench.driver.state().position_rad, 1.0, 4e-4);
}

TEST(RobstrideStartUp, ConfiguresACyberGearByItsOwnParameters) {
  Bench bench(bench_options(true));
  ASSERT_GT(bench.run_until(DriveCondition::kDisabled), 0);
  EXPECT_EQ(bench.drive.parameter_raw(0x200C), 1000U);
  EXPECT_EQ(bench.drive.parameter_raw(0x7028), 0U);
  EXPECT_EQ(bench.count(encode_read(kLink, 0x7029)), 0U);
  EXPECT_EQ(bench.count(Type::kReport), 0U);
}

TEST(RobstrideStartUp, WhatDiffersIsWrittenAndReadBack) {
  DriveOptions options = bench_options();
  options.settings.values[kTorqueLimit] = 9.5;
  Bench bench(options);
  bench.drive.set_parameter(0x7005, 3);
  ASSERT_GT(bench.run_until(DriveCondition::kDisabled), 0);
  EXPECT_EQ(bench.drive.parameter_raw(0x7005), 0U);
  EXPECT_EQ(bench.drive.parameter_raw(0x700B), Bench::raw(9.5));
  EXPECT_EQ(bench.count(Type::kWrite), 3U);
  EXPECT_EQ(bench.count(encode_read(kLink, 0x700B)), 2U);
  ASSERT_GT(bench.run_until(DriveCondition::kEnabled, enable()), 0);
  bench.run(3, enable(15.0));
  EXPECT_NEAR(bench.drive.torque_nm(bench.now_ns), 9.5, 1e-6);
}

TEST(RobstrideStartUp, ADriveThatPowersUpBetweenZeroAndTwoPiIsRefused) {
  Bench bench;
  bench.drive.set_parameter(0x7029, 0);
  ASSERT_GT(bench.run_until(DriveCondition::kRefused), 0);
  EXPECT_TRUE(names(bench.driver.complaint(), "zero_sta (parameter 0x7029)"));
  EXPECT_EQ(bench.driver.complaint().found, 0.0);
  EXPECT_EQ(bench.driver.complaint().expected, 1.0);
  bench.run(200, enable(1.0));
  EXPECT_EQ(bench.driver.state().condition, DriveCondition::kRefused);
  EXPECT_EQ(bench.count(Type::kEnable), 0U);
  EXPECT_EQ(bench.count(Type::kWrite), 0U);
}

TEST(RobstrideStartUp, ATorqueRangeOtherThanTheDrivesIsRefused) {
  for (const double range_nm : {12.0, 60.0}) {  // the drive's is 17
    DriveOptions options = bench_options();
    options.torque_range_nm = range_nm;
    Bench bench;
    Driver driver(options);
    std::int64_t now_ns = 0;
    for (int i = 0; i < 100 && driver.state().condition != DriveCondition::kRefused; ++i) {
      now_ns += 1'000'000;
      std::array<Frame, 4> out;
      const std::size_t count = driver.transmit({}, now_ns, out);
      for (std::size_t k = 0; k < count; ++k) {
        std::array<Frame, 4> reply;
        if (bench.drive.receive(out[k], now_ns, reply) == 1) {
          driver.receive({reply[0], now_ns});
        }
      }
    }
    EXPECT_EQ(driver.state().condition, DriveCondition::kRefused);
    EXPECT_TRUE(names(driver.complaint(), "limit_torque (parameter 0x700B)"));
    EXPECT_EQ(driver.complaint().found, 17.0);
    EXPECT_EQ(driver.complaint().expected, range_nm);
  }
}

TEST(RobstrideStartUp, APositionRangeOtherThanTheDrivesShowsAgainstMechPos) {
  Bench bench;
  bench.drive.set_shaft(3.0, 0.0);
  bench.forge = [](Frame& frame) {  // the drive scales to 25 where we take 12.57
    if (type_of(frame.id) == Type::kFeedback) {
      const std::uint16_t code = to_code(3.0, -25.0, 25.0);
      frame.data[0] = static_cast<std::uint8_t>(code >> 8U);
      frame.data[1] = static_cast<std::uint8_t>(code & 0xFFU);
    }
  };
  ASSERT_GT(bench.run_until(DriveCondition::kRefused), 0);
  EXPECT_TRUE(names(bench.driver.complaint(), "mechPos (parameter 0x7019)"));
  EXPECT_NEAR(bench.driver.complaint().found, 1.5, 0.02);
  EXPECT_NEAR(bench.driver.complaint().expected, 3.0, 1e-6);
  EXPECT_EQ(bench.driver.state().stamp_ns, 0);  // nothing it said was taken for a position
}

TEST(RobstrideStartUp, AWrappedPositionAgreesWithMechPos) {
  Bench bench;
  bench.drive.set_shaft(20.0, 0.0);
  ASSERT_GT(bench.run_until(DriveCondition::kDisabled), 0);
  EXPECT_NEAR(bench.driver.state().position_rad, 20.0 - 8.0 * std::numbers::pi, 1e-3);
}

TEST(RobstrideStartUp, AReadThatTheDriveRefusesIsNotAValue) {
  // Captured from a drive: identifier 110115FD, value 0. Its status byte says that it has failed.
  Bench bench;
  bench.forge = [](Frame& frame) {
    if (type_of(frame.id) == Type::kRead && frame.data[0] == 0x28) {
      frame.id |= 0x00010000;
      std::fill(frame.data.begin() + 4, frame.data.end(), std::uint8_t{0});
    }
  };
  ASSERT_GT(bench.run_until(DriveCondition::kRefused), 0);
  EXPECT_TRUE(names(bench.driver.complaint(), "canTimeout (parameter 0x7028)"));
  EXPECT_TRUE(std::isnan(bench.driver.complaint().found));
}

TEST(RobstrideStartUp, SettingsThatAreNotKeptAreRefusedByName) {
  struct Case {
    std::uint16_t index;
    double expected;
    const char* name;
  };
  for (const Case& one : {Case{0x7005, 0, "run_mode (parameter 0x7005)"},
                          Case{0x700B, 17.0, "limit_torque (parameter 0x700B)"},
                          Case{0x7028, 1000, "canTimeout (parameter 0x7028)"}}) {
    Bench bench;
    bench.forge = [&one](Frame& frame) {
      if (type_of(frame.id) == Type::kRead && frame.data[0] == (one.index & 0xFFU) &&
          frame.data[1] == one.index >> 8U) {
        frame.data[4] = 0x77;
        frame.data[5] = frame.data[6] = frame.data[7] = 0;
      }
    };
    ASSERT_GT(bench.run_until(DriveCondition::kRefused), 0) << one.name;
    EXPECT_TRUE(names(bench.driver.complaint(), one.name)) << bench.driver.complaint().quantity;
    EXPECT_NEAR(bench.driver.complaint().found, one.index == 0x700B ? 0.0 : 0x77, 1e-6);
    EXPECT_EQ(bench.driver.complaint().expected, one.expected);
    EXPECT_NE(bench.driver.complaint().fix, nullptr);
    EXPECT_EQ(bench.count(Type::kWrite), static_cast<std::size_t>(StartUp::kMaxWrites));
  }
}

TEST(RobstrideStartUp, FirmwareThatIsTooOldIsRefused) {
  DriveOptions options = bench_options();
  options.settings.values[kLeastFirmware] = 206.0;
  Bench good(options);
  EXPECT_GT(good.run_until(DriveCondition::kDisabled), 0);
  Bench old(options);
  old.drive.set_version(std::array<std::uint8_t, 4>{0, 0, 2, 5});
  ASSERT_GT(old.run_until(DriveCondition::kRefused), 0);
  EXPECT_TRUE(names(old.driver.complaint(), "firmware"));
  EXPECT_EQ(old.driver.complaint().found, 205.0);
  Bench silent(options);
  silent.drive.set_version(std::nullopt);
  ASSERT_GT(silent.run_until(DriveCondition::kRefused), 0);
  EXPECT_TRUE(names(silent.driver.complaint(), "firmware"));
  Bench whatever;
  whatever.drive.set_version(std::nullopt);
  EXPECT_GT(whatever.run_until(DriveCondition::kDisabled), 0);
  EXPECT_EQ(whatever.driver.firmware(), 0U);
}

TEST(RobstrideStartUp, OneRequestAtATimeRepeatedAfterItsTimeOut) {
  Bench bench;
  bench.cut = true;
  bench.run(100);
  EXPECT_EQ(bench.count(Type::kReport), 2U);  // once more when it tells that it was switched on
  EXPECT_EQ(bench.count(encode_stop(kLink, false)), 6U);
  EXPECT_EQ(bench.sent.size(), 8U);
  bench.cut = false;
  EXPECT_GT(bench.run_until(DriveCondition::kDisabled), 0);
}

TEST(RobstrideStartUp, LostAnswersDelayAndDoNotMislead) {
  Bench bench;
  bench.drive.set_shaft(1.0, 0.0);
  for (int i = 0; bench.driver.state().condition != DriveCondition::kDisabled && i < 2000; ++i) {
    bench.deaf = i % 3 != 0;  // two of three answers are lost
    bench.cycle();
    if (bench.driver.state().stamp_ns != 0) {
      EXPECT_NEAR(bench.driver.state().position_rad, 1.0, 4e-4);
    }
  }
  EXPECT_EQ(bench.driver.state().condition, DriveCondition::kDisabled);
}

TEST(RobstrideStartUp, AParameterThatIsNeverAnsweredIsRefusedByName) {
  Bench bench;
  bench.forge = [](Frame& frame) {
    if (type_of(frame.id) == Type::kRead && frame.data[0] == 0x0B) {
      frame.id = 0;  // nobody's
    }
  };
  ASSERT_GT(bench.run_until(DriveCondition::kRefused, {}, 2000), 0);
  EXPECT_TRUE(names(bench.driver.complaint(), "limit_torque (parameter 0x700B)"));
}

TEST(RobstrideStartUp, ADriveLeftRunningByAnotherIsStoppedFirst) {
  Bench bench;
  bench.ask(encode_enable(kLink));
  ASSERT_TRUE(bench.drive.enabled());
  bench.run(3);
  EXPECT_FALSE(bench.drive.enabled());
  EXPECT_GT(bench.run_until(DriveCondition::kDisabled), 0);
}

TEST(RobstrideStartUp, AFaultIsReportedAndLeftWhereItIsNotToBeCleared) {
  Bench bench;
  bench.drive.inject_error(2);
  ASSERT_GT(bench.run_until(DriveCondition::kError), 0);
  bench.run(100, enable());
  EXPECT_EQ(bench.driver.state().condition, DriveCondition::kError);
  EXPECT_EQ(bench.driver.state().error, 2);
  EXPECT_TRUE(names(bench.driver.complaint(), "fault bits"));
  EXPECT_EQ(bench.count(encode_stop(kLink, true)), 0U);
  EXPECT_EQ(bench.count(Type::kEnable), 0U);
  EXPECT_TRUE(bench.reported);
  bench.drive.power_cycle();  // as the complaint advises
  EXPECT_GT(bench.run_until(DriveCondition::kDisabled), 0);
  EXPECT_EQ(bench.driver.complaint().quantity, nullptr);
  EXPECT_EQ(bench.drive.parameter_raw(0x7028), 1000U);
}

TEST(RobstrideStartUp, AFaultIsClearedWhereThatIsAllowedAndTheCauseIsGone) {
  DriveOptions options = bench_options();
  options.clear_errors = true;
  Bench gone(options);
  gone.drive.inject_error(5);
  EXPECT_GT(gone.run_until(DriveCondition::kDisabled), 0);
  EXPECT_EQ(gone.count(encode_stop(kLink, true)), 1U);
  Bench stays(options);
  stays.drive.set_temperature(150.0);
  ASSERT_GT(stays.run_until(DriveCondition::kError), 0);
  stays.run(500);
  EXPECT_EQ(stays.count(encode_stop(kLink, true)), static_cast<std::size_t>(StartUp::kMaxClears));
  EXPECT_EQ(stays.driver.state().error, 3);
}

}  // namespace
}  // namespace geodesic::drivers::robstride::test
