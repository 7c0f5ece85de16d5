// moteus subframes: integers and their ends, varuints, what a reader does with rubbish.
#include "drivers/moteus/codec.hpp"

#include <gtest/gtest.h>

#include <cmath>
#include <limits>
#include <random>

#include "tests/drivers/moteus/bench.hpp"

namespace geodesic::drivers::moteus::test {
namespace {

constexpr double kInfinity = std::numeric_limits<double>::infinity();

TEST(MoteusCodec, IntegersRoundToNearestAndSaturate) {
  EXPECT_EQ(to_code(1.256, Quantity::kTorque, Resolution::kInt16), 126);
  EXPECT_EQ(to_code(-1.256, Quantity::kTorque, Resolution::kInt16), -126);
  EXPECT_EQ(to_code(3.3, Quantity::kPosition, Resolution::kInt16), 32767);
  EXPECT_EQ(to_code(-3.3, Quantity::kPosition, Resolution::kInt16), -32767);
  EXPECT_EQ(to_code(-1e300, Quantity::kScale, Resolution::kInt32), -2147483647);
  EXPECT_EQ(to_code(1.0, Quantity::kScale, Resolution::kInt16), 32767);
}

TEST(MoteusCodec, TheMostNegativeIntegerIsNaNBothWays) {
  for (const double none : {std::nan(""), kInfinity, -kInfinity}) {
    EXPECT_EQ(to_code(none, Quantity::kPosition, Resolution::kInt8), -128);
    EXPECT_EQ(to_code(none, Quantity::kTorque, Resolution::kInt16), -32768);
    EXPECT_EQ(to_code(none, Quantity::kTime, Resolution::kInt32),
              std::numeric_limits<std::int32_t>::min());
  }
  EXPECT_TRUE(std::isnan(from_code(-128, Quantity::kPosition, Resolution::kInt8)));
  EXPECT_TRUE(std::isnan(from_code(-32768, Quantity::kTorque, Resolution::kInt16)));
  EXPECT_EQ(from_code(-128, Quantity::kInteger, Resolution::kInt8), -128.0);
}

TEST(MoteusCodec, EveryCodeComesBack) {
  for (const Quantity quantity : {Quantity::kPosition, Quantity::kVelocity, Quantity::kTorque,
                                  Quantity::kScale, Quantity::kTime, Quantity::kPower}) {
    for (std::int32_t code = -32767; code <= 32767; code += 7) {
      ASSERT_EQ(
          to_code(from_code(code, quantity, Resolution::kInt16), quantity, Resolution::kInt16),
          code);
    }
  }
}

TEST(MoteusCodec, IdentifiersComeApartAndTogether) {
  EXPECT_EQ(to_id({0, 1, true, 0}), 0x8001U);
  EXPECT_EQ(to_id({1, 0, false, 0}), 0x0100U);
  EXPECT_EQ(to_id({0, 7, false, 0x123}), 0x01230007U);
  for (const std::uint32_t id : {0x8001U, 0x0100U, 0x01238A05U, 0x1FFFFF7FU & ~0x80U}) {
    EXPECT_EQ(to_id(from_id(id)), id);
  }
  EXPECT_FALSE(make_frame({7, 0, false, 0}).extended);
  EXPECT_TRUE(make_frame({8, 0, false, 0}).extended);
}

TEST(MoteusCodec, WhatDoesNotFitIsLeftOut) {
  std::array<Item, 20> items{};
  for (std::size_t i = 0; i < items.size(); ++i) {
    items[i] = {static_cast<Register>(0x100 + 2 * i), Resolution::kInt32, 1.0};
  }
  Frame frame = make_frame({0, 1, true, 0});
  EXPECT_FALSE(append_writes(frame, items));
  EXPECT_LE(frame.length, 64);
  Reader reader(frame);
  std::size_t count = 0;
  for (Entry entry; reader.next(entry); ++count) {
    EXPECT_EQ(entry.value, 1.0);
  }
  EXPECT_FALSE(reader.malformed());
  EXPECT_EQ(count, 9U);
}

TEST(MoteusCodec, ReadsErrorsStreamsLongCountsAndPadding) {
  Frame frame;
  frame.length = 24;
  frame.data = {0x30, 0xB0, 0x02, 0x02,                    // write error of 0x130: not writeable
                0x50,                                      // between subframes too
                0x31, 0x07, 0x01,                          // read error of 7: unknown
                0x20, 0x04, 0x0C, 0x02, 0x30, 0x28, 0x22,  // four int8 from 0x00C
                0x41, 0x01, 0x02, 'O',  'K',               // text
                0x42, 0x01, 0x30, 0x50};
  Reader reader(frame);
  Entry entry;
  ASSERT_TRUE(reader.next(entry));
  EXPECT_EQ(entry.kind, opcode::kWriteError);
  EXPECT_EQ(entry.number, 0x130U);
  EXPECT_EQ(entry.value, 2.0);
  ASSERT_TRUE(reader.next(entry));
  EXPECT_EQ(entry.kind, opcode::kReadError);
  EXPECT_EQ(entry.number, 7U);
  for (const double expected : {2.0, 24.0, 40.0, 34.0}) {
    ASSERT_TRUE(reader.next(entry));
    EXPECT_EQ(entry.kind, opcode::kReply);
    EXPECT_EQ(entry.value, expected);
  }
  ASSERT_TRUE(reader.next(entry));
  EXPECT_EQ(entry.text, "OK");
  ASSERT_TRUE(reader.next(entry));
  EXPECT_EQ(entry.kind, opcode::kClientPoll);
  EXPECT_EQ(entry.value, 48.0);
  EXPECT_FALSE(reader.next(entry));
  EXPECT_FALSE(reader.malformed());
}

TEST(MoteusCodec, AnyBytesEndInBoundedTime) {
  std::mt19937 random(7);
  int malformed = 0;
  for (int i = 0; i < 20'000; ++i) {
    Frame frame;
    frame.length = static_cast<std::uint8_t>(random() % 65);
    for (std::uint8_t& byte : frame.data) {
      byte = static_cast<std::uint8_t>(random() % (i % 2 == 0 ? 256 : 0x60));
    }
    Reader reader(frame);
    std::size_t count = 0;
    for (Entry entry; reader.next(entry); ++count) {
      ASSERT_LE(entry.text.size(), 64U);
    }
    ASSERT_LE(count, 64U * 512U);
    malformed += reader.malformed() ? 1 : 0;
    decode_report(frame);
  }
  EXPECT_GT(malformed, 10'000);
  EXPECT_LT(malformed, 20'000);
}

TEST(MoteusCodec, FormatsAreAsWideAsTheRangesAsk) {
  const Formats usual = formats_for(bench_options());
  EXPECT_EQ(usual.position, Resolution::kInt32);  // no range: any number of turns
  EXPECT_EQ(usual.velocity, Resolution::kInt16);
  EXPECT_EQ(usual.torque, Resolution::kInt16);
  EXPECT_EQ(reply_length(usual), 20U);
  EXPECT_EQ(command_length(usual, 50'000'000), 32U);
  DriveOptions options = bench_options();
  options.position_range_rad = 12.5;
  EXPECT_EQ(formats_for(options).position, Resolution::kInt16);
  EXPECT_EQ(reply_length(formats_for(options)), 16U);
  options.position_range_rad = 21.0;
  EXPECT_EQ(formats_for(options).position, Resolution::kInt32);
  options.velocity_range_rad_s = 52.0;
  options.torque_range_nm = 330.0;
  EXPECT_EQ(formats_for(options).velocity, Resolution::kInt32);
  EXPECT_EQ(formats_for(options).torque, Resolution::kInt32);
  const Formats floats = formats_for(with(kResolution, 1.0));
  EXPECT_EQ(floats.position, Resolution::kFloat);
  EXPECT_EQ(reply_length(floats), 24U);
  EXPECT_EQ(command_length(floats, 50'000'000), 48U);
}

}  // namespace
}  // namespace geodesic::drivers::moteus::test
