// The MyActuator codec by itself: rounding, bounds, refusals, and that a code survives both ways.
#include "drivers/myactuator/codec.hpp"

#include <gtest/gtest.h>

#include <cmath>

#include "tests/drivers/myactuator/bench.hpp"

namespace geodesic::drivers::myactuator::test {
namespace {

TEST(MyactuatorCodec, EveryCodeSurvivesDecodingAndEncoding) {
  for (const double range : {12.5, 12.566, 24.0, 45.0}) {
    for (std::uint32_t code = 0; code < 1U << 16U; ++code) {
      ASSERT_EQ(to_code(from_code(code, -range, range, 16), -range, range, 16), code);
    }
  }
  for (int code = -32768; code <= 32767; ++code) {
    const Frame frame = *encode_torque(1, code * 0.01);
    ASSERT_NEAR(*decode_torque(frame), code * 0.01, 1e-9);
  }
}

TEST(MyactuatorCodec, SaturatesAndRefuses) {
  EXPECT_NEAR(*decode_torque(*encode_torque(1, 1e9)), 327.67, 1e-9);
  EXPECT_NEAR(*decode_torque(*encode_torque(1, -1e9)), -327.68, 1e-9);
  EXPECT_NEAR(*decode_torque(*encode_torque(1, 0.006)), 0.01, 1e-12);
  EXPECT_NEAR(*decode_speed(*encode_speed(1, 1e12)), 21474836.47, 1e-3);
  EXPECT_EQ(decode_position(*encode_position(1, {0.0, 1e9}))->speed_limit_deg_s, 65535.0);
  EXPECT_FALSE(encode_torque(1, NAN));
  EXPECT_FALSE(encode_speed(1, INFINITY));
  EXPECT_FALSE(encode_position(1, {NAN, 0.0}));
  EXPECT_FALSE(encode_position(1, {0.0, NAN}));
}

TEST(MyactuatorCodec, ShortFramesAndOtherCommandsAreNotDecoded) {
  Frame frame = encode_request(1, Command::kAngle);
  EXPECT_TRUE(decode_angle(frame));
  EXPECT_FALSE(decode_status1(frame));
  EXPECT_FALSE(decode_status3(frame));
  EXPECT_FALSE(decode_loop_reply(frame));
  EXPECT_FALSE(decode_torque(frame));
  EXPECT_FALSE(decode_speed(frame));
  EXPECT_FALSE(decode_position(frame));
  frame.length = 4;
  EXPECT_FALSE(decode_angle(frame));
  EXPECT_FALSE(command_of(frame));
  EXPECT_FALSE(decode_motion(frame, kRanges));
  EXPECT_FALSE(decode_motion_reply(frame, kRanges));
}

TEST(MyactuatorCodec, TheLowestErrorBitIsTheCode) {
  EXPECT_EQ(error_code(0), 0);
  EXPECT_EQ(error_code(0x0002), 2);
  EXPECT_EQ(error_code(0x5000), 13);
  EXPECT_EQ(error_code(0x8000), 16);
}

TEST(MyactuatorCodec, StiffnessAndDampingHaveRangesOfTheirOwn) {
  Ranges ranges = kRanges;
  ranges.damping_nm_s_rad = 50.0;  // protocol V4.4
  const auto frame = encode_motion(1, {.damping_nm_s_rad = 25.0}, ranges);
  EXPECT_NEAR(decode_motion(*frame, ranges)->damping_nm_s_rad, 25.0, 0.01);
  EXPECT_NEAR(decode_motion(*frame, kRanges)->damping_nm_s_rad, 2.5, 0.001);
}

}  // namespace
}  // namespace geodesic::drivers::myactuator::test
