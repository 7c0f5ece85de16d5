// Bit timing against figures of the specifications and against a second, naive way of counting.
#include "drivers/bus/bit_timing.hpp"

#include <gtest/gtest.h>

#include <random>
#include <string>

#include "tests/drivers/bus/bus_testing.hpp"

namespace geodesic::drivers {
namespace {

using testing::make_fd_frame;
using testing::make_frame;

constexpr std::int64_t kMega = 1'000'000;

std::string bits_of(std::uint32_t value, int width) {
  std::string text;
  for (int i = width - 1; i >= 0; --i) {
    text += (value >> i & 1U) != 0 ? '1' : '0';
  }
  return text;
}

std::string data_bits(const Frame& frame) {
  std::string text;
  for (const std::uint8_t byte : frame.payload()) {
    text += bits_of(byte, 8);
  }
  return text;
}

// Polynomial division as one does it on paper: the remainder of bits * x^15.
std::string crc15(std::string bits) {
  const std::string divisor = "1100010110011001";  // x^15 + 0x4599
  const std::size_t message = bits.size();
  bits += std::string(15, '0');
  for (std::size_t i = 0; i < message; ++i) {
    if (bits[i] == '1') {
      for (std::size_t k = 0; k < divisor.size(); ++k) {
        bits[i + k] = bits[i + k] == divisor[k] ? '0' : '1';
      }
    }
  }
  return bits.substr(message);
}

std::string stuff(const std::string& bits, bool at_the_end) {
  std::string out;
  for (std::size_t i = 0; i < bits.size(); ++i) {
    out += bits[i];
    const bool last = i + 1 == bits.size();
    if (out.size() >= 5 && (!last || at_the_end) &&
        out.substr(out.size() - 5) == std::string(5, out.back())) {
      out += out.back() == '0' ? '1' : '0';
    }
  }
  return out;
}

int naive_classic_bits(const Frame& frame) {
  const std::string identifier =
      frame.extended ? bits_of(frame.id >> 18, 11) + "11" + bits_of(frame.id & 0x3FFFF, 18) + "000"
                     : bits_of(frame.id, 11) + "000";
  const std::string content = "0" + identifier + bits_of(frame.length, 4) + data_bits(frame);
  return static_cast<int>(stuff(content + crc15(content), true).size()) + 13;
}

TEST(BitTiming, ClassicFrameOfEightBytesHas111To135Bits) {
  EXPECT_EQ(frame_bits(8, false, false, false, Stuffing::kBest), (FrameBits{111, 0}));
  EXPECT_EQ(frame_bits(8, false, false, false, Stuffing::kWorst), (FrameBits{135, 0}));
  EXPECT_EQ(frame_bits(8, true, false, false, Stuffing::kBest), (FrameBits{131, 0}));
  EXPECT_EQ(frame_bits(8, true, false, false, Stuffing::kWorst), (FrameBits{160, 0}));
  EXPECT_EQ(frame_time_ns(8, false, false, false, kMega, 5 * kMega, Stuffing::kWorst), 135'000);
}

TEST(BitTiming, FdFrameOfEightBytesTakes49To57Microseconds) {
  EXPECT_EQ(frame_bits(8, false, true, true, Stuffing::kBest), (FrameBits{30, 96}));
  EXPECT_EQ(frame_bits(8, false, true, true, Stuffing::kWorst), (FrameBits{34, 113}));
  EXPECT_EQ(frame_time_ns(8, false, true, true, kMega, 5 * kMega, Stuffing::kBest), 49'200);
  EXPECT_EQ(frame_time_ns(8, false, true, true, kMega, 5 * kMega, Stuffing::kWorst), 56'600);
}

TEST(BitTiming, WithoutBitRateSwitchEveryBitIsNominal) {
  EXPECT_EQ(frame_bits(8, false, true, false, Stuffing::kBest), (FrameBits{126, 0}));
  EXPECT_EQ(frame_bits(8, false, true, false, Stuffing::kWorst), (FrameBits{147, 0}));
}

TEST(BitTiming, LongFdFramesHaveTheLongerChecksum) {
  // 16 bytes: CRC 17 and 6 fixed stuff bits; 20 bytes: CRC 21 and 7.
  const int shorter = frame_bits(16, false, true, true, Stuffing::kBest).data;
  const int longer = frame_bits(20, false, true, true, Stuffing::kBest).data;
  EXPECT_EQ(shorter, 5 + 128 + 4 + 17 + 6);
  EXPECT_EQ(longer, 5 + 160 + 4 + 21 + 7);
}

TEST(BitTiming, LengthsAreRoundedUpToThoseThatExist) {
  EXPECT_EQ(can_length(9, true), 12U);
  EXPECT_EQ(can_length(33, true), 48U);
  EXPECT_EQ(can_length(64, true), 64U);
  EXPECT_EQ(can_length(0, true), 0U);
  EXPECT_TRUE(is_can_length(24, true));
  EXPECT_FALSE(is_can_length(24, false));
  EXPECT_FALSE(is_can_length(9, true));
  EXPECT_EQ(frame_bits(9, false, true, true, Stuffing::kWorst),
            frame_bits(12, false, true, true, Stuffing::kWorst));
}

TEST(BitTiming, ExactClassicLengthAgreesWithCountingOnPaper) {
  std::mt19937 random(1);
  for (int round = 0; round < 3000; ++round) {
    Frame frame;
    frame.extended = round % 2 == 1;
    frame.id = static_cast<std::uint32_t>(random()) & (frame.extended ? 0x1FFFFFFFU : 0x7FFU);
    frame.length = static_cast<std::uint8_t>(random() % 9);
    for (std::uint8_t& byte : frame.data) {
      // Long runs on every third frame: they are what stuffing is about.
      byte = static_cast<std::uint8_t>(round % 3 == 0 ? (random() & 1U) * 0xFFU : random());
    }
    EXPECT_EQ(frame_bits(frame).nominal, naive_classic_bits(frame));
  }
}

TEST(BitTiming, AllZeroFrameByHand) {
  // 34 zeros (the CRC of zeros is zero): each run of five equal bits takes one stuff bit.
  const Frame frame = make_frame(0);
  EXPECT_EQ(frame_bits(frame).nominal, 34 + 34 / 5 + 13);
}

TEST(BitTiming, ExactFdLengthByHand) {
  // id 0x555, 1010.. data: no run of five anywhere but in 0 1 0000 (IDE, RRS, ... ) of the control.
  Frame frame = make_fd_frame(0x555, 8);
  frame.data.fill(0xAA);
  // SOF 0, id 10101010101, RRS 0, IDE 0, FDF 1, res 0, BRS 1 | ESI 0, DLC 1000, 10101010...
  EXPECT_EQ(frame_bits(frame), (FrameBits{30, 96}));
  // Five dominant bits end the data: the fixed stuff bit of the CRC field takes their stuff bit's
  // place.
  frame.data[7] = 0xA0;
  EXPECT_EQ(frame_bits(frame), (FrameBits{30, 96}));
  frame.data[7] = 0x05;
  frame.data[6] = 0xA0;  // ...10100000 00000101: ten zeros in a row, a stuff bit after each five
  EXPECT_EQ(frame_bits(frame), (FrameBits{30, 98}));
}

TEST(BitTiming, EveryFrameLiesBetweenBestAndWorst) {
  std::mt19937 random(2);
  constexpr std::array<std::uint8_t, 16> kLengths = {0, 1,  2,  3,  4,  5,  6,  7,
                                                     8, 12, 16, 20, 24, 32, 48, 64};
  for (int round = 0; round < 5000; ++round) {
    Frame frame;
    frame.fd = round % 2 == 1;
    frame.bit_rate_switch = frame.fd && round % 4 == 1;
    frame.extended = random() % 2 == 1;
    frame.id = static_cast<std::uint32_t>(random()) & (frame.extended ? 0x1FFFFFFFU : 0x7FFU);
    frame.length = kLengths[random() % (frame.fd ? 16U : 9U)];
    for (std::uint8_t& byte : frame.data) {
      byte = static_cast<std::uint8_t>(round % 3 == 0 ? (random() & 1U) * 0xF8U : random());
    }
    const std::int64_t exact = frame_time_ns(frame, kMega, 5 * kMega);
    const auto bound = [&](Stuffing stuffing) {
      return frame_time_ns(frame.length, frame.extended, frame.fd, frame.bit_rate_switch, kMega,
                           5 * kMega, stuffing);
    };
    EXPECT_GE(exact, bound(Stuffing::kBest));
    EXPECT_LE(exact, bound(Stuffing::kWorst));
  }
}

TEST(BusBudget, SevenClassicJointsReach529HzAndNoMore) {
  const CycleFrames frames{.count = 14};
  const BusBudget all = bus_budget({&frames, 1}, 500.0, kMega, 5 * kMega, 1.0);
  EXPECT_NEAR(all.max_rate_hz, 529.1, 0.1);
  EXPECT_EQ(all.worst_ns, 14 * 135'000);
  EXPECT_EQ(all.best_ns, 14 * 111'000);
  EXPECT_NEAR(1e9 / static_cast<double>(all.best_ns), 643.5, 0.1);
  EXPECT_TRUE(all.carried);
  EXPECT_FALSE(bus_budget({&frames, 1}, 530.0, kMega, 5 * kMega, 1.0).carried);
}

TEST(BusBudget, EightFdDrivesHoldOneKilohertz) {
  const CycleFrames frames{.count = 16, .fd = true, .bit_rate_switch = true};
  const BusBudget budget = bus_budget({&frames, 1}, 1000.0, kMega, 5 * kMega);
  EXPECT_EQ(budget.frames, 16U);
  EXPECT_EQ(budget.period_ns, 1'000'000);
  EXPECT_EQ(budget.worst_ns, 905'600);
  EXPECT_NEAR(budget.worst_load, 0.9056, 1e-9);
  EXPECT_TRUE(budget.carried);
  EXPECT_NEAR(budget.max_rate_hz, 0.95e9 / 905'600, 1e-6);
}

TEST(BusBudget, KindsOfFramesAddUpAndNothingLoadsNothing) {
  const std::array<CycleFrames, 2> frames = {CycleFrames{.count = 2, .bytes = 4},
                                             CycleFrames{.count = 1, .bytes = 8, .extended = true}};
  const BusBudget budget = bus_budget(frames, 100.0, kMega, kMega, 1.0);
  EXPECT_EQ(budget.best_ns, 2 * (47 + 32) * 1000 + 131'000);
  EXPECT_EQ(budget.frames, 3U);
  const BusBudget nothing = bus_budget({}, 100.0, kMega, kMega);
  EXPECT_TRUE(nothing.carried);
  EXPECT_EQ(nothing.worst_load, 0.0);
}

}  // namespace
}  // namespace geodesic::drivers
