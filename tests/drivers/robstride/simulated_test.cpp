// The simulated RobStride drive by itself, spoken to in bytes, and held to the golden vectors.
#include "drivers/robstride/simulated.hpp"

#include <gtest/gtest.h>

#include <cmath>
#include <fstream>
#include <numbers>

#include "tests/drivers/robstride/bench.hpp"
#include "tests/drivers/vectors/row.hpp"

namespace geodesic::drivers::robstride::test {
namespace {

class RobstrideSimulated : public ::testing::Test {
 protected:
  std::optional<Frame> ask(const Frame& frame) {
    std::array<Frame, SimulatedDrive::kMaxReplies> reply;
    now_ns += 1'000'000;
    return drive.receive(frame, now_ns, reply) == 1 ? std::optional(reply[0]) : std::nullopt;
  }
  Feedback feedback(const Frame& frame) { return decode_feedback(*ask(frame), kRanges).value(); }
  Feedback state() {  // by a write of what is there, which stops nothing
    return feedback(encode_write(kLink, 0x700B, drive.parameter_raw(0x700B)));
  }
  static Frame control(const ControlCommand& command) {
    return *encode_control(kLink.motor, command, kRanges);
  }
  std::vector<Frame> said() {
    std::array<Frame, SimulatedDrive::kMaxReplies> out;
    const std::size_t count = drive.speak(now_ns, out);
    return {out.begin(), out.begin() + static_cast<std::ptrdiff_t>(count)};
  }

  Simulated drive{bench_options()};
  std::int64_t now_ns = 0;
};

/// Rows of the vectors of this kind, each with a drive that was set up for it.
template <typename Check>
int for_rows(bool command, const char* key, const Check& check) {
  std::ifstream file(GEODESIC_TEST_DATA "/vectors/robstride.csv");
  int rows = 0;
  for (const drivers::test::Row& row : drivers::test::read_rows(file, "robstride.csv")) {
    if (row.command != command || !row.has(key) || row.has("protocol")) {
      continue;
    }
    DriveOptions options = bench_options();
    options.id = static_cast<std::uint32_t>(row.number("motor_id"));
    options.position_range_rad = row.number("pmax");
    options.velocity_range_rad_s = row.number("vmax");
    options.torque_range_nm = row.number("tmax");
    if (row.has("kpmax")) {
      options.settings.values[kStiffnessRange] = row.number("kpmax");
      options.settings.values[kDampingRange] = row.number("kdmax");
    }
    check(row, options);
    ++rows;
  }
  return rows;
}

TEST(RobstrideSimulatedVectors, CommandsMakeTheTorqueThatTheySay) {
  const int rows =
      for_rows(true, "t_ff", [](const drivers::test::Row& row, const DriveOptions& options) {
        Simulated drive(options);
        std::array<Frame, 4> reply;
        const Link link{.motor = static_cast<std::uint8_t>(options.id), .host = 0xFD};
        ASSERT_EQ(drive.receive(encode_enable(link), 0, reply), 1U);
        const double p = std::clamp(row.number("p_des"), -row.number("pmax"), row.number("pmax"));
        const double v = std::clamp(row.number("v_des"), -row.number("vmax"), row.number("vmax"));
        const double kp = std::clamp(row.number("kp"), 0.0, row.number("kpmax"));
        const double kd = std::clamp(row.number("kd"), 0.0, row.number("kdmax"));
        const double t = std::clamp(row.number("t_ff"), -row.number("tmax"), row.number("tmax"));
        // Where the loops make nothing the torque shows, and one code aside each of them.
        drive.set_shaft(p, v);
        ASSERT_EQ(drive.receive(row.frame, 1000, reply), 1U) << row.description;
        const double codes = (2.0 * row.number("tmax") + kp * 2.0 * row.number("pmax") +
                              kd * 2.0 * row.number("vmax")) /
                             65535.0;
        EXPECT_NEAR(drive.torque_nm(1000), t, codes * 1.01) << row.description;
        if (kp > 0.0 && kd > 0.0 && std::abs(p) < row.number("pmax")) {
          const double away = 0.1 * row.number("tmax") / kp;
          drive.set_shaft(p + std::copysign(away, t), v);
          EXPECT_NEAR(drive.torque_nm(1000), t - kp * std::copysign(away, t), codes * 1.02);
        }
      });
  EXPECT_GE(rows, 12);
}

TEST(RobstrideSimulatedVectors, FeedbackHasTheCodesOfTheVectors) {
  const int rows =
      for_rows(false, "temperature", [](const drivers::test::Row& row, DriveOptions options) {
        Simulated drive(options);
        const Link link{.motor = static_cast<std::uint8_t>(options.id), .host = 0xFD};
        const Ranges ranges = ranges_of(options);
        std::array<Frame, 4> reply;
        drive.set_shaft(row.number("position") + 1e-5, row.number("velocity") + 1e-5);
        drive.set_temperature(row.number("temperature") + 0.01);
        if (row.number("mode") == 2.0) {
          drive.receive(encode_enable(link), 0, reply);
          const auto command =
              encode_control(link.motor, {.torque_nm = row.number("torque")}, ranges);
          ASSERT_EQ(drive.receive(*command, 1000, reply), 1U);
        } else {
          drive.inject_error(1);
          ASSERT_EQ(drive.receive(encode_stop(link, false), 1000, reply), 1U);
        }
        EXPECT_EQ(reply[0].id, row.frame.id) << row.description;
        for (std::size_t at = 0; at < 8; at += 2) {
          if (at == 4 && row.number("mode") != 2.0) {
            continue;  // a drive that is stopped makes no torque
          }
          const int ours = reply[0].data[at] * 256 + reply[0].data[at + 1];
          const int theirs = row.frame.data[at] * 256 + row.frame.data[at + 1];
          EXPECT_LE(std::abs(ours - theirs), 1) << row.description << ", byte " << at;
        }
      });
  EXPECT_GE(rows, 6);
}

TEST_F(RobstrideSimulated, AnswersTheReferenceRequestsInBytes) {
  drive.set_shaft(-1.25, 0.0);
  Frame request;
  request.id = 0x1100FD05;
  request.extended = true;
  request.length = 8;
  request.data = {0x19, 0x70, 0, 0, 0, 0, 0, 0};
  Frame expected = request;
  expected.id = 0x110005FD;
  expected.data = {0x19, 0x70, 0, 0, 0x00, 0x00, 0xA0, 0xBF};
  EXPECT_EQ(ask(request), expected);
  request.data = {0x34, 0x12, 0, 0, 0, 0, 0, 0};  // no such parameter
  expected.id = 0x110105FD;
  expected.data = request.data;
  EXPECT_EQ(ask(request), expected);
  request.id = 0x0000FD05;
  const auto identity = ask(request);
  ASSERT_TRUE(identity);
  EXPECT_EQ(identity->id, 0x000005FEU);
}

TEST_F(RobstrideSimulated, HearsOnlyItsOwnFramesAndFormat) {
  EXPECT_TRUE(ask(control({})));
  Frame frame = control({});
  frame.id ^= 1U;
  EXPECT_FALSE(ask(frame));
  for (bool Frame::*flag : {&Frame::fd, &Frame::remote, &Frame::error}) {
    frame = control({});
    frame.*flag = true;
    EXPECT_FALSE(ask(frame));
  }
  frame = control({});
  frame.length = 4;
  EXPECT_FALSE(ask(frame));
  frame = control({});
  frame.id = 5;
  frame.extended = false;
  EXPECT_FALSE(ask(frame));
}

TEST_F(RobstrideSimulated, MakesTorqueOnlyWhileItRunsInOperationControl) {
  ask(control({.torque_nm = 3.0}));
  EXPECT_EQ(drive.torque_nm(now_ns), 0.0);
  EXPECT_EQ(feedback(encode_enable(kLink)).mode, 2);
  EXPECT_NEAR(drive.torque_nm(now_ns), 3.0, 1e-3);  // what it was told while it was stopped
  ask(encode_write(kLink, 0x7005, 3));
  EXPECT_EQ(drive.torque_nm(now_ns), 0.0);
  ask(encode_write(kLink, 0x7005, 0));
  EXPECT_EQ(feedback(encode_stop(kLink, false)).mode, 0);
  EXPECT_EQ(drive.torque_nm(now_ns), 0.0);
}

TEST_F(RobstrideSimulated, SaturatesAtItsLimit) {
  ask(encode_enable(kLink));
  ask(control({.torque_nm = 17.0}));
  EXPECT_EQ(drive.torque_nm(now_ns), 17.0);
  ask(encode_write(kLink, 0x700B, Bench::raw(4.0)));
  EXPECT_EQ(drive.torque_nm(now_ns), 4.0);
  ask(encode_write(kLink, 0x700B, Bench::raw(100.0)));  // it knows what it can
  EXPECT_EQ(drive.parameter_raw(0x700B), Bench::raw(17.0));
}

TEST_F(RobstrideSimulated, ReportsInTruncatedCodes) {
  for (double position = -12.4; position < 12.4; position += 0.0317) {
    drive.set_shaft(position, position);
    const double error = position - state().position_rad;
    EXPECT_GE(error, -1e-5) << position;
    EXPECT_LE(error, 25.14 / 65535.0 + 1e-5) << position;
  }
}

TEST_F(RobstrideSimulated, WrapsAtFourPiAndTellsMechPosUnwrapped) {
  drive.set_shaft(13.0, 0.0);
  EXPECT_NEAR(state().position_rad, 13.0 - 8.0 * std::numbers::pi, 1e-3);
  EXPECT_NEAR(decode_parameter(*ask(encode_read(kLink, 0x7019)))->real(), 13.0, 1e-6);
  Simulated old(bench_options(true));
  old.set_shaft(13.0, 0.0);
  std::array<Frame, 4> reply;
  ASSERT_EQ(old.receive(encode_stop(kLink, false), 0, reply), 1U);
  EXPECT_TRUE(decode_feedback(reply[0], kRanges)->at_end);
}

TEST_F(RobstrideSimulated, KnowsOnlyOneTurnAfterPowerUp) {
  drive.set_shaft(4.0, 0.0);
  drive.power_cycle();
  EXPECT_NEAR(state().position_rad, 4.0 - 2.0 * std::numbers::pi, 1e-3);
  drive.set_parameter(0x7029, 0);  // 0 to 2 pi
  drive.set_shaft(-0.1, 0.0);
  drive.power_cycle();
  EXPECT_NEAR(state().position_rad, 2.0 * std::numbers::pi - 0.1, 1e-3);
}

TEST_F(RobstrideSimulated, ZeroAndParametersAreKeptOnceSaved) {
  drive.set_shaft(1.0, 0.0);
  ask(encode_zero(kLink));
  EXPECT_NEAR(state().position_rad, 0.0, 1e-3);
  ask(encode_write(kLink, 0x7028, 2000));
  drive.power_cycle();
  EXPECT_NEAR(state().position_rad, 1.0, 1e-3);
  EXPECT_EQ(drive.parameter_raw(0x7028), 0U);
  ask(encode_zero(kLink));
  ask(encode_write(kLink, 0x7028, 2000));
  ask(encode_save(kLink));
  drive.power_cycle();
  EXPECT_NEAR(state().position_rad, 0.0, 1e-3);
  EXPECT_EQ(drive.parameter_raw(0x7028), 2000U);
}

TEST_F(RobstrideSimulated, TheWatchdogStopsItAndItNeedsToBeEnabledAgain) {
  ask(encode_write(kLink, 0x7028, 200));  // 10 ms
  ask(encode_enable(kLink));
  ask(control({.torque_nm = 3.0}));
  now_ns += 8'000'000;
  EXPECT_NEAR(drive.torque_nm(now_ns), 3.0, 1e-3);
  ask(encode_read(kLink, 0x7019));  // asking is no command
  now_ns += 2'000'000;
  EXPECT_EQ(drive.torque_nm(now_ns), 0.0);
  EXPECT_EQ(feedback(control({.torque_nm = 3.0})).mode, 0);
  EXPECT_EQ(drive.torque_nm(now_ns), 0.0);
  ask(encode_enable(kLink));
  EXPECT_TRUE(drive.enabled());
  ask(encode_write(kLink, 0x7028, 0));  // as it comes: off
  now_ns += 100'000'000'000;
  EXPECT_NEAR(drive.torque_nm(now_ns), 3.0, 1e-3);
}

TEST_F(RobstrideSimulated, FaultsStopItUntilTheyAreCleared) {
  ask(encode_enable(kLink));
  drive.inject_error(2);
  EXPECT_FALSE(drive.enabled());
  EXPECT_EQ(state().faults, 2);
  EXPECT_EQ(feedback(encode_enable(kLink)).mode, 0);
  EXPECT_EQ(feedback(encode_stop(kLink, false)).faults, 2);
  EXPECT_EQ(feedback(encode_stop(kLink, true)).faults, 0);
  EXPECT_EQ(feedback(encode_enable(kLink)).mode, 2);
}

TEST_F(RobstrideSimulated, HeatIsAFaultThatCannotBeClearedWhileItLasts) {
  drive.set_temperature(136.0);
  EXPECT_EQ(state().faults, 4);
  EXPECT_NEAR(state().temperature_c, 136.0, 1e-9);
  EXPECT_EQ(feedback(encode_stop(kLink, true)).faults, 4);
  drive.set_temperature(60.0);
  EXPECT_EQ(feedback(encode_stop(kLink, false)).faults, 4);
  EXPECT_EQ(feedback(encode_stop(kLink, true)).faults, 0);
}

TEST_F(RobstrideSimulated, SpeaksUnaskedOfItsStartAndItsFaultsAndByATimer) {
  ASSERT_EQ(said().size(), 1U);
  EXPECT_TRUE(said().empty());
  drive.power_cycle();
  const std::vector<Frame> start = said();
  ASSERT_EQ(start.size(), 1U);
  EXPECT_EQ(decode_identity(start[0]), 5);
  drive.inject_error(kFirstReported + 4);
  const std::vector<Frame> report = said();
  ASSERT_EQ(report.size(), 1U);
  EXPECT_EQ(decode_fault_report(report[0])->faults, 0x10U);
  EXPECT_FALSE(ask(encode_reports(kLink, true)));
  std::size_t reports = 0;
  for (int i = 0; i < 100; ++i) {
    now_ns += 1'000'000;
    reports += said().size();
  }
  EXPECT_EQ(reports, 10U);  // every 10 ms, as it comes
  ask(encode_reports(kLink, false));
  now_ns += 100'000'000;
  EXPECT_TRUE(said().empty());
}

TEST_F(RobstrideSimulated, TellsItsVersionWhenItIsStopped) {
  const Frame answer = ask(encode_version_query(kLink)).value();
  EXPECT_EQ(decode_version(answer), 206U);
  drive.set_version(std::nullopt);
  EXPECT_FALSE(decode_version(ask(encode_version_query(kLink)).value()));
}

}  // namespace
}  // namespace geodesic::drivers::robstride::test
