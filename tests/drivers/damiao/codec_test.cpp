// The Damiao codec by itself: rounding, bounds, refusals, and that a code survives both ways.
#include "drivers/damiao/codec.hpp"

#include <gtest/gtest.h>

#include <array>
#include <cmath>
#include <limits>

namespace geodesic::drivers::damiao {
namespace {

constexpr Ranges kRanges{12.5, 30.0, 10.0};

TEST(DamiaoCodec, EveryCodeSurvivesDecodingAndEncoding) {
  for (const double range : {10.0, 12.5, 28.0, 54.0, 200.0}) {
    for (std::uint32_t code = 0; code < 1U << 16U; ++code) {
      ASSERT_EQ(to_code(from_code(code, -range, range, 16), -range, range, 16), code);
    }
    for (std::uint32_t code = 0; code < 1U << 12U; ++code) {
      ASSERT_EQ(to_code(from_code(code, -range, range, 12), -range, range, 12), code);
    }
  }
}

TEST(DamiaoCodec, RoundsToTheNearestCode) {
  const double step = 2.0 * kRanges.torque_nm / 4095.0;
  for (int i = -2000; i <= 2000; ++i) {
    const double torque = 0.00487 * i;
    const double decoded = from_code(to_code(torque, -10.0, 10.0, 12), -10.0, 10.0, 12);
    EXPECT_LE(std::abs(decoded - torque), step * 0.5 * (1.0 + 1e-9)) << torque;
  }
}

TEST(DamiaoCodec, IsUsableAtCompileTime) {
  static_assert(to_code(0.0, 0.0, 5.0, 12) == 0);
  static_assert(to_code(99.0, 0.0, 5.0, 12) == 0xFFF);
  static_assert(to_code(-99.0, 0.0, 5.0, 12) == 0);
  static_assert(find_register(21)->integer == false);
  static_assert(find_register(200) == nullptr);
}

TEST(DamiaoCodec, FieldsCoverEveryBitOnce) {
  const auto covered = [](auto... fields) {
    std::uint64_t seen = 0;
    for (const Field field : {fields...}) {
      const std::uint64_t mask = ((std::uint64_t{1} << field.bits) - 1U)
                                 << (64U - field.first - field.bits);
      EXPECT_EQ(seen & mask, 0U);
      seen |= mask;
    }
    return seen;
  };
  EXPECT_EQ(covered(mit::kPosition, mit::kVelocity, mit::kStiffness, mit::kDamping, mit::kTorque),
            ~std::uint64_t{0});
  EXPECT_EQ(covered(report::kStatus, report::kMotor, report::kPosition, report::kVelocity,
                    report::kTorque, report::kMosfetTemperature, report::kRotorTemperature),
            ~std::uint64_t{0});
}

TEST(DamiaoCodec, FdFramesSwitchTheBitRate) {
  const auto frame = encode_mit(3, true, {}, kRanges);
  ASSERT_TRUE(frame);
  EXPECT_TRUE(frame->fd);
  EXPECT_TRUE(frame->bit_rate_switch);
  EXPECT_EQ(frame->length, 8);
  EXPECT_TRUE(encode_state_request(3, true).bit_rate_switch);
  EXPECT_FALSE(encode_state_request(3, false).fd);
}

TEST(DamiaoCodec, OtherModesRefuseWhatNoFloatCanHold) {
  const double infinity = std::numeric_limits<double>::infinity();
  EXPECT_FALSE(encode_position_velocity(1, false, {NAN, 1.0}));
  EXPECT_FALSE(encode_position_velocity(1, false, {1.0, 1e300}));
  EXPECT_FALSE(encode_velocity(1, false, infinity));
  EXPECT_FALSE(encode_position_force(1, false, {1.0, NAN, 0.5}));
  EXPECT_TRUE(encode_position_force(1, false, {1.0, 1e300, -1.0}));
}

TEST(DamiaoCodec, ShortFramesAreNotDecoded) {
  Frame frame = encode_state_request(1, false);
  frame.length = 7;
  EXPECT_FALSE(decode_report(frame, kRanges));
  EXPECT_FALSE(decode_mit(frame, kRanges));
  EXPECT_FALSE(decode_register(frame));
  EXPECT_FALSE(decode_special(frame));
  EXPECT_FALSE(decode_velocity(frame));
  EXPECT_FALSE(decode_position_velocity(frame));
  EXPECT_FALSE(decode_position_force(frame));
}

TEST(DamiaoCodec, OnlyTheFourSpecialFramesAreSpecial) {
  Frame frame = encode_special(1, false, Special::kEnable);
  for (std::uint8_t last = 0xFF; last >= 0xFA; --last) {
    frame.data[7] = last;
    EXPECT_EQ(decode_special(frame).has_value(), last >= 0xFB && last <= 0xFE) << int{last};
    EXPECT_NE(decode_special(frame).has_value(), decode_mit(frame, kRanges).has_value());
  }
  frame.data[7] = 0xFC;
  frame.data[3] = 0xFE;
  EXPECT_FALSE(decode_special(frame));
}

}  // namespace
}  // namespace geodesic::drivers::damiao
