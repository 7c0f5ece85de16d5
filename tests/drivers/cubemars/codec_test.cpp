// The CubeMars codec by itself: rounding, bounds, refusals, and that a code survives both ways.
#include "drivers/cubemars/codec.hpp"

#include <gtest/gtest.h>

#include <cmath>
#include <limits>

namespace geodesic::drivers::cubemars {
namespace {

constexpr Ranges kRanges{12.5, 50.0, 18.0};

TEST(CubemarsCodec, EveryCodeSurvivesDecodingAndEncoding) {
  for (const double range : {8.0, 12.5, 18.0, 76.0, 144.0}) {
    for (std::uint32_t code = 0; code < 1U << 16U; ++code) {
      ASSERT_EQ(to_code(from_code(code, -range, range, 16), -range, range, 16), code);
    }
    for (std::uint32_t code = 0; code < 1U << 12U; ++code) {
      ASSERT_EQ(to_code(from_code(code, -range, range, 12), -range, range, 12), code);
    }
  }
}

TEST(CubemarsCodec, TheTopOfARangeDoesNotFlowIntoTheNextField) {
  const auto frame = encode_mit(1, {12.5, 50.0, 500.0, 0.0, 18.0}, kRanges);
  ASSERT_TRUE(frame);
  EXPECT_EQ(extract(*frame, mit::kPosition), 0xFFFFU);
  EXPECT_EQ(extract(*frame, mit::kVelocity), 0xFFFU);
  EXPECT_EQ(extract(*frame, mit::kDamping), 0U);
  EXPECT_EQ(extract(*frame, mit::kTorque), 0xFFFU);
}

TEST(CubemarsCodec, RepliesOfEveryLengthAreReadAsFarAsTheyGo) {
  Frame frame;
  frame.data = {5, 0xFF, 0xFF, 0x80, 0x08, 0x00, 0x99, 0x01};
  for (std::uint8_t length = 0; length <= 8; ++length) {
    frame.length = length;
    const auto reply = decode_reply(frame, kRanges);
    ASSERT_EQ(reply.has_value(), length >= 6) << int{length};
    if (reply) {
      EXPECT_EQ(reply->motor, 5);
      EXPECT_DOUBLE_EQ(reply->position_rad, 12.5);
      EXPECT_EQ(reply->voltage_v.has_value(), length == 7);
      EXPECT_EQ(reply->temperature_raw.has_value(), length == 8);
      EXPECT_EQ(reply->error, length == 8 ? 1 : 0);
    }
  }
  frame.length = 7;
  EXPECT_DOUBLE_EQ(*decode_reply(frame, kRanges)->voltage_v, 24.0);
}

TEST(CubemarsCodec, ServoCommandsSaturateAndRefuse) {
  EXPECT_FALSE(encode_servo(1, {Function::kCurrent, NAN}));
  EXPECT_FALSE(encode_servo(1, {Function::kStatus, 1.0}));
  EXPECT_FALSE(encode_servo(1, {Function::kPositionSpeed, 1.0}));
  EXPECT_FALSE(encode_position_speed(1, {NAN, 0.0, 0.0}));
  const auto most = decode_servo(encode_servo(1, {Function::kCurrent, 1e12}).value());
  EXPECT_NEAR(most->value, 2147483.647, 1e-6);
  const auto least = decode_servo(encode_servo(1, {Function::kSpeed, -1e12}).value());
  EXPECT_EQ(least->value, -2147483648.0);
  const auto profile = decode_position_speed(*encode_position_speed(1, {0.0, 1e9, -1e9}));
  EXPECT_EQ(profile->speed_erpm, 327670.0);
  EXPECT_EQ(profile->acceleration_erpm_s, -327680.0);
  const auto rounded = encode_servo(1, {Function::kCurrent, 0.0006});
  EXPECT_EQ(rounded->data[3], 1);
}

TEST(CubemarsCodec, FramesOfOtherLengthsAreNotDecoded) {
  Frame frame = encode_special(1, Special::kEnter);
  frame.length = 7;
  EXPECT_FALSE(decode_special(frame));
  EXPECT_FALSE(decode_mit(frame, kRanges));
  EXPECT_FALSE(decode_status(frame));
  Frame servo = *encode_servo(1, {Function::kCurrent, 1.0});
  servo.length = 8;
  EXPECT_FALSE(decode_servo(servo));
  servo.length = 4;
  servo.extended = false;
  EXPECT_FALSE(decode_servo(servo));
  EXPECT_FALSE(decode_position_speed(servo));
}

TEST(CubemarsCodec, OnlyTheThreeSpecialFramesAreSpecial) {
  Frame frame = encode_special(1, Special::kEnter);
  for (std::uint8_t last = 0xFF; last >= 0xFA; --last) {
    frame.data[7] = last;
    EXPECT_EQ(decode_special(frame).has_value(), last >= 0xFC && last <= 0xFE) << int{last};
    EXPECT_NE(decode_special(frame).has_value(), decode_mit(frame, kRanges).has_value());
  }
}

}  // namespace
}  // namespace geodesic::drivers::cubemars
