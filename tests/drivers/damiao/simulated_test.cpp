// The simulated Damiao drive by itself, spoken to in bytes.
#include "drivers/damiao/simulated.hpp"

#include <gtest/gtest.h>

#include <numbers>

#include "tests/drivers/damiao/bench.hpp"

namespace geodesic::drivers::damiao::test {
namespace {

constexpr Ranges kRanges{12.5, 30.0, 10.0};

class DamiaoSimulated : public ::testing::Test {
 protected:
  std::optional<Frame> ask(const Frame& frame) {
    std::array<Frame, 1> reply;
    now_ns += 1'000'000;
    return drive.receive(frame, now_ns, reply) == 1 ? std::optional(reply[0]) : std::nullopt;
  }
  StateReport state() {
    return decode_report(ask(encode_state_request(5, false)).value(), kRanges).value();
  }
  std::uint8_t special(Special which) {
    return decode_report(ask(encode_special(5, false, which)).value(), kRanges)->status;
  }
  Frame mit(const MitCommand& command) const { return *encode_mit(5, false, command, kRanges); }

  Simulated drive{bench_options()};
  std::int64_t now_ns = 0;
};

TEST_F(DamiaoSimulated, AnswersTheReferenceRequestsInBytes) {
  Frame request;
  request.id = 0x7FF;
  request.length = 8;
  request.data = {0x05, 0x00, 0x33, 0x15, 0, 0, 0, 0};
  Frame expected = request;
  expected.id = 0x15;
  expected.data = {0x05, 0x00, 0x33, 0x15, 0x00, 0x00, 0x48, 0x41};
  EXPECT_EQ(ask(request), expected);
  request.data = {0x05, 0x00, 0x55, 0x09, 0x40, 0x1F, 0, 0};
  expected.data = request.data;
  EXPECT_EQ(ask(request), expected);
  request.data[0] = 0x06;
  EXPECT_FALSE(ask(request));
  request.data = {0x05, 0x00, 0x33, 0x63, 0, 0, 0, 0};  // no register 99
  EXPECT_FALSE(ask(request));
}

TEST_F(DamiaoSimulated, HearsOnlyItsOwnIdentifiersAndFormat) {
  Frame frame = mit({});
  EXPECT_TRUE(ask(frame));
  frame.id = 6;
  EXPECT_FALSE(ask(frame));
  frame = mit({});
  frame.fd = true;
  EXPECT_FALSE(ask(frame));
  frame = mit({});
  frame.extended = true;
  EXPECT_FALSE(ask(frame));
  frame = mit({});
  frame.length = 4;
  EXPECT_FALSE(ask(frame));
  EXPECT_FALSE(ask(*encode_velocity(5, false, 1.0)));  // it is in MIT mode
}

TEST_F(DamiaoSimulated, MakesTorqueOnlyWhileEnabledAndInMitMode) {
  ask(mit({.torque_nm = 3.0}));
  EXPECT_EQ(drive.torque_nm(now_ns), 0.0);
  EXPECT_EQ(special(Special::kEnable), 1);
  EXPECT_EQ(drive.torque_nm(now_ns), 0.0);
  ask(mit({.torque_nm = 3.0}));
  EXPECT_NEAR(drive.torque_nm(now_ns), 3.0, 0.005);
  ask(encode_write(5, false, 10, 2));
  ask(mit({.torque_nm = -3.0}));
  EXPECT_NEAR(drive.torque_nm(now_ns), 3.0, 0.005);
  EXPECT_EQ(special(Special::kDisable), 0);
  EXPECT_EQ(drive.torque_nm(now_ns), 0.0);
  EXPECT_EQ(special(Special::kEnable), 1);
  EXPECT_EQ(drive.torque_nm(now_ns), 0.0);
}

TEST_F(DamiaoSimulated, SaturatesAtTmax) {
  special(Special::kEnable);
  drive.set_shaft(-5.0, 0.0);
  ask(mit({.position_rad = 5.0, .stiffness_nm_rad = 100.0, .torque_nm = 5.0}));
  EXPECT_EQ(drive.torque_nm(now_ns), 10.0);
  EXPECT_EQ(state().torque_nm, 10.0);
}

TEST_F(DamiaoSimulated, ReportsInTruncatedCodes) {
  for (double position = -12.4; position < 12.4; position += 0.0317) {
    drive.set_shaft(position, position);
    const double error = position - state().position_rad;
    EXPECT_GE(error, -1e-5) << position;
    EXPECT_LE(error, 25.0 / 65535.0 + 1e-5) << position;
  }
}

TEST_F(DamiaoSimulated, WrapsPositionAtPmax) {
  drive.set_shaft(12.6, 0.0);
  EXPECT_NEAR(state().position_rad, 12.6 - 25.0, 1e-3);
  drive.set_shaft(-12.6, 0.0);
  EXPECT_NEAR(state().position_rad, -12.6 + 25.0, 1e-3);
}

TEST_F(DamiaoSimulated, KnowsOnlyOneTurnAfterPowerUp) {
  drive.set_shaft(4.0, 0.0);
  EXPECT_NEAR(state().position_rad, 4.0, 1e-3);
  drive.power_cycle();
  EXPECT_NEAR(state().position_rad, 4.0 - 2.0 * std::numbers::pi, 1e-3);
}

TEST_F(DamiaoSimulated, SetsZeroForGood) {
  drive.set_shaft(1.0, 0.0);
  special(Special::kSetZero);
  EXPECT_NEAR(state().position_rad, 0.0, 1e-3);
  drive.power_cycle();
  drive.set_shaft(1.5, 0.0);
  EXPECT_NEAR(state().position_rad, 0.5, 1e-3);
}

TEST_F(DamiaoSimulated, WatchdogLatchesUntilClearedAndEnabled) {
  ask(encode_write(5, false, 9, 200));  // 10 ms
  special(Special::kEnable);
  ask(mit({.torque_nm = 3.0}));
  now_ns += 8'000'000;
  EXPECT_NEAR(drive.torque_nm(now_ns), 3.0, 0.005);
  EXPECT_EQ(state().status, 1);  // asking is no command
  now_ns += 2'000'000;
  EXPECT_EQ(drive.torque_nm(now_ns), 0.0);
  EXPECT_EQ(state().status, 13);
  EXPECT_EQ(special(Special::kEnable), 13);
  EXPECT_EQ(special(Special::kDisable), 13);
  ask(mit({.torque_nm = 3.0}));
  EXPECT_EQ(drive.torque_nm(now_ns), 0.0);
  EXPECT_EQ(special(Special::kClearError), 0);
  EXPECT_EQ(special(Special::kEnable), 1);
}

TEST_F(DamiaoSimulated, TimeoutZeroIsNoWatchdog) {
  ask(encode_write(5, false, 9, 0));
  special(Special::kEnable);
  ask(mit({.torque_nm = 3.0}));
  now_ns += 100'000'000'000;
  EXPECT_NEAR(drive.torque_nm(now_ns), 3.0, 0.005);
}

TEST_F(DamiaoSimulated, RegistersAreVolatileUntilSaved) {
  ask(encode_write(5, false, 9, 1234));
  ask(encode_write(5, false, 14, 1));  // read only
  EXPECT_EQ(drive.register_raw(9), 1234U);
  EXPECT_NE(drive.register_raw(14), 1U);
  drive.power_cycle();
  EXPECT_EQ(drive.register_raw(9), 8000U);
  ask(encode_write(5, false, 9, 1234));
  special(Special::kEnable);
  EXPECT_FALSE(ask(encode_save(5, false)));  // only while disabled
  special(Special::kDisable);
  EXPECT_TRUE(ask(encode_save(5, false)));
  drive.power_cycle();
  EXPECT_EQ(drive.register_raw(9), 1234U);
}

TEST_F(DamiaoSimulated, HeatIsAnErrorThatCannotBeClearedWhileItLasts) {
  special(Special::kEnable);
  drive.set_temperature(99.0);
  EXPECT_EQ(state().status, 1);
  drive.set_temperature(101.0);
  EXPECT_EQ(state().status, 12);
  EXPECT_EQ(state().rotor_c, 101.0);
  EXPECT_EQ(special(Special::kClearError), 12);
  drive.set_temperature(60.0);
  EXPECT_EQ(state().status, 12);
  EXPECT_EQ(special(Special::kClearError), 0);
}

TEST_F(DamiaoSimulated, EightTimesFfIsACommandAndNoSpecialFrame) {
  special(Special::kEnable);
  Frame frame = encode_special(5, false, Special::kDisable);
  frame.data[7] = 0xFF;
  ask(frame);
  EXPECT_TRUE(drive.enabled());
  EXPECT_EQ(drive.torque_nm(now_ns), 10.0);
}

TEST_F(DamiaoSimulated, BitRateRegisterTakesEffectAfterAPowerCycle) {
  ask(encode_write(5, false, 35, 9));
  ask(encode_save(5, false));
  EXPECT_TRUE(ask(encode_state_request(5, false)));
  drive.power_cycle();
  EXPECT_FALSE(ask(encode_state_request(5, false)));
  EXPECT_TRUE(ask(encode_state_request(5, true))->bit_rate_switch);
}

}  // namespace
}  // namespace geodesic::drivers::damiao::test
