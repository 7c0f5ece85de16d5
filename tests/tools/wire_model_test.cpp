// The simulated wire against bit timing: one frame at a time, arbitration, the drives' latency.
#include "tools/sim/wire_model.hpp"

#include <gtest/gtest.h>

#include "drivers/bus/bit_timing.hpp"

namespace geodesic::tools {
namespace {

constexpr std::int64_t kRate = 1'000'000;
constexpr std::int64_t kDataRate = 5'000'000;

drivers::Frame frame(std::uint32_t id, bool extended = false) {
  drivers::Frame result;
  result.id = id;
  result.extended = extended;
  result.length = 8;
  result.data = {1, 2, 3, 4, 5, 6, 7, 8};
  return result;
}

std::int64_t time_of(const drivers::Frame& sent) {
  return drivers::frame_time_ns(sent, kRate, kDataRate);
}

TEST(WireModel, OneFrameTakesItsBits) {
  WireModel wire(kRate, kDataRate);
  EXPECT_FALSE(wire.next_end_ns().has_value());
  wire.push_host(frame(1), 1000);
  ASSERT_TRUE(wire.next_end_ns().has_value());
  EXPECT_EQ(*wire.next_end_ns(), 1000 + time_of(frame(1)));
  EXPECT_FALSE(wire.pop(1000 + time_of(frame(1)) - 1).has_value());
  const auto delivery = wire.pop(1000 + time_of(frame(1)));
  ASSERT_TRUE(delivery.has_value());
  EXPECT_FALSE(delivery->reply);
  EXPECT_EQ(delivery->frame.id, 1U);
  EXPECT_EQ(wire.waiting(), 0U);
}

TEST(WireModel, HostFramesKeepTheirOrderAndRepliesArbitrate) {
  WireModel wire(kRate, kDataRate);
  wire.push_host(frame(5), 0);
  wire.push_host(frame(3), 0);
  wire.push_host(frame(0x20), 0);
  std::int64_t end = time_of(frame(5));
  ASSERT_EQ(wire.pop(end)->frame.id, 5U);
  wire.push_reply(frame(0x15), end);
  end += time_of(frame(3));  // 3 beats the reply 0x15
  ASSERT_EQ(wire.pop(end)->frame.id, 3U);
  end += time_of(frame(0x15));  // the reply beats 0x20
  const auto reply = wire.pop(end);
  ASSERT_TRUE(reply.has_value());
  EXPECT_TRUE(reply->reply);
  EXPECT_EQ(reply->frame.id, 0x15U);
  end += time_of(frame(0x20));
  EXPECT_EQ(wire.pop(end)->frame.id, 0x20U);
}

TEST(WireModel, WhatIsReadyLaterDoesNotInterruptWhatHasBegun) {
  WireModel wire(kRate, kDataRate);
  wire.push_host(frame(0x700), 0);
  wire.push_reply(frame(0x001), 10'000);  // ready while 0x700 is on the wire
  EXPECT_EQ(*wire.next_end_ns(), time_of(frame(0x700)));
  EXPECT_EQ(wire.pop(1'000'000)->frame.id, 0x700U);
  EXPECT_EQ(*wire.next_end_ns(), time_of(frame(0x700)) + time_of(frame(0x001)));
}

TEST(WireModel, SevenDrivesAnswerWithinTheBudget) {
  // A cycle of 7 commands handed over at once; each drive answers 100 us after its command.
  constexpr std::int64_t kLatency = 100'000;
  WireModel wire(kRate, kDataRate);
  std::int64_t bits = 0;
  for (std::uint32_t id = 1; id <= 7; ++id) {
    wire.push_host(frame(id), 0);
    bits += time_of(frame(id)) + time_of(frame(id + 0x10));
  }
  std::int64_t end = 0;
  std::int64_t before = 0;
  int replies = 0;
  while (const auto delivery = wire.pop(10'000'000)) {
    before = end;
    end = delivery->end_ns;
    EXPECT_GE(end - before, time_of(delivery->frame));  // never two at a time
    if (delivery->reply) {
      ++replies;
    } else {
      wire.push_reply(frame(delivery->frame.id + 0x10), end + kLatency);
    }
  }
  EXPECT_EQ(replies, 7);
  // The wire is never idle in between: latency hides behind the other commands.
  EXPECT_EQ(end, bits);
}

}  // namespace
}  // namespace geodesic::tools
