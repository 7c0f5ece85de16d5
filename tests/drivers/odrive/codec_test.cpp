// The codec by itself: bytes of frames that the vectors do not have, refusals, lengths.
#include "drivers/odrive/codec.hpp"

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <limits>

#include "tests/drivers/odrive/bench.hpp"

namespace geodesic::drivers::odrive::test {
namespace {

TEST(OdriveCodec, EveryMessageComesBackAsItWasSent) {
  for (const Message* message : kMessages) {
    if (message == &kRxSdo06 || message == &kTxSdo06) {
      continue;
    }
    std::vector<double> values;
    for (std::size_t i = 0; i < message->count(); ++i) {
      const Type type = message->fields[i].type;
      const bool real = type == Type::kF32 || type == Type::kI16Milli;
      values.push_back(type == Type::kFlag  ? 1.0
                       : real               ? -1.25 - static_cast<double>(i)
                       : type == Type::kI32 ? -70000.0
                                            : 200.0 + static_cast<double>(i));
    }
    const auto frame = encode(17, *message, values);
    ASSERT_TRUE(frame) << message->name;
    EXPECT_EQ(frame->id, 17U << 5U | static_cast<std::uint32_t>(message->command));
    EXPECT_EQ(frame->length, message->length);
    for (std::size_t i = 0; i < values.size(); ++i) {
      const auto back = decode(*frame, message->fields[i]);
      ASSERT_TRUE(back) << message->name;
      EXPECT_DOUBLE_EQ(*back, values[i]) << message->name << " " << message->fields[i].name;
    }
  }
}

TEST(OdriveCodec, FieldsOfAMessageLieApartAndWithinEightBytes) {
  for (const Message* message : kMessages) {
    for (std::size_t i = 0; i < message->count(); ++i) {
      const Field& a = message->fields[i];
      EXPECT_LE(a.bit + bits_of(a.type), 8U * message->length) << message->name;
      for (std::size_t k = 0; k < i; ++k) {
        const Field& b = message->fields[k];
        EXPECT_TRUE(a.bit >= b.bit + bits_of(b.type) || b.bit >= a.bit + bits_of(a.type))
            << message->name;
      }
    }
    EXPECT_EQ(find_message(message->in_06 ? Firmware::k06 : Firmware::k05,
                           static_cast<std::uint32_t>(message->command)),
              message);
  }
}

TEST(OdriveCodec, IntegersAreClampedAndRoundedToNearest) {
  const auto feed_forward = [](double value) {
    return *decode(*encode(1, kSetInputPosition, {0.0, value, 0.0}), kSetInputPosition.fields[1]);
  };
  EXPECT_NEAR(feed_forward(0.5), 0.5, 1e-12);  // the vendor's encoder: 0.499
  EXPECT_NEAR(feed_forward(0.0006), 0.001, 1e-12);
  EXPECT_NEAR(feed_forward(1000.0), 32.767, 1e-12);
  EXPECT_NEAR(feed_forward(-1000.0), -32.768, 1e-12);
  EXPECT_EQ(encode(1, kSetAxisState, {-3.0})->data[0], 0);
  EXPECT_EQ(encode(1, kSetAxisState, {1e20})->data[3], 0xFF);
}

TEST(OdriveCodec, WhatNoFieldCanHoldIsRefused) {
  for (const double bad : {std::nan(""), std::numeric_limits<double>::infinity(), -1e39}) {
    EXPECT_FALSE(encode(1, kSetInputTorque, {bad}));
    EXPECT_FALSE(encode(1, kSetInputPosition, {0.0, bad}));
    EXPECT_FALSE(encode(1, kSetLimits, {1.0, bad}));
  }
}

TEST(OdriveCodec, ShortAndRemoteFramesHaveNoFields) {
  Frame frame = *encode(1, kSetLimits, {1.0, 2.0});
  frame.length = 7;
  EXPECT_TRUE(decode(frame, kSetLimits.fields[0]));
  EXPECT_FALSE(decode(frame, kSetLimits.fields[1]));
  frame.length = 64;
  EXPECT_TRUE(decode(frame, kSetLimits.fields[1]));
  const Frame request = encode_request(3, Command::kEstimates);
  EXPECT_TRUE(request.remote);
  EXPECT_EQ(request.id, 0x069U);
  EXPECT_EQ(request.length, 0);
  EXPECT_FALSE(decode(request, kEstimates.fields[0]));
}

TEST(OdriveCodec, SdoCarriesEveryType) {
  const Frame write = encode_sdo_write(1, 0x1234, ParameterType::kU32, 20.0);
  EXPECT_EQ(write.length, 8);
  EXPECT_TRUE(std::equal(write.data.begin(), write.data.begin() + 8,
                         std::array{1, 0x34, 0x12, 0, 20, 0, 0, 0}.begin()));
  const Frame yes = encode_sdo_write(1, 201, ParameterType::kBool, 1.0);
  EXPECT_EQ(yes.length, 5);
  EXPECT_EQ(sdo_value(*decode_sdo(yes), ParameterType::kBool), 1.0);
  const Frame real = encode_sdo_write(1, 201, ParameterType::kFloat, 0.25);
  EXPECT_EQ(sdo_value(*decode_sdo(real), ParameterType::kFloat), 0.25);
  Frame cut = real;
  cut.length = 3;
  EXPECT_FALSE(decode_sdo(cut));
}

}  // namespace
}  // namespace geodesic::drivers::odrive::test
