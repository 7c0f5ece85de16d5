// The model of a cycle on the wire, against a simulation that goes along the wire in small steps,
// and its order of commands against all orders there are.
#include "drivers/bus/schedule.hpp"

#include <gtest/gtest.h>

#include <algorithm>
#include <numeric>
#include <random>

namespace geodesic::drivers {
namespace {

constexpr std::int64_t kStepNs = 200;  // one bit at 5 Mbit/s

WireFrame command(std::uint32_t key, std::int64_t duration_ns) {
  return {.key = key, .duration_ns = duration_ns};
}

WireFrame reply(std::uint32_t key, std::int64_t duration_ns, std::size_t answers,
                std::int64_t latency_ns) {
  return {key, duration_ns, true, answers, latency_ns};
}

/// Everybody looks at the wire every 200 ns; who has something to say says it when it is free.
std::vector<WireTime> step_by_step(const std::vector<WireFrame>& frames) {
  std::vector<WireTime> times(frames.size(), WireTime{-1, -1, -1});
  constexpr std::size_t kNobody = WireFrame::kNothing;
  std::size_t talking = kNobody;
  std::size_t left = frames.size();
  for (std::int64_t now = 0; left > 0; now += kStepNs) {
    if (talking != kNobody && times[talking].start_ns + frames[talking].duration_ns == now) {
      times[talking].end_ns = now;
      talking = kNobody;
      --left;
    }
    std::size_t loudest = kNobody;
    bool host_spoke = false;  // only the foremost of its frames is in its controller
    for (std::size_t i = 0; i < frames.size(); ++i) {
      const bool mine = !frames[i].reply;
      if (times[i].start_ns >= 0 || (mine && host_spoke)) continue;
      host_spoke = host_spoke || mine;
      if (frames[i].reply && frames[i].answers != WireFrame::kNothing) {
        const std::int64_t called = times[frames[i].answers].end_ns;
        if (called < 0 || now < called + frames[i].latency_ns) continue;
      }
      if (times[i].ready_ns < 0) times[i].ready_ns = now;
      if (loudest == kNobody || frames[i].key < frames[loudest].key) loudest = i;
    }
    if (talking == kNobody && loudest != kNobody) {
      times[loudest].start_ns = now;
      talking = loudest;
    }
  }
  return times;
}

/// A bus of drives at random, each with a command and a reply; keys are all different.
std::vector<WireFrame> random_cycle(std::mt19937& random, std::size_t drives) {
  const auto pick = [&random](std::int64_t low, std::int64_t high) {
    return std::uniform_int_distribution<std::int64_t>(low, high)(random);
  };
  std::vector<std::uint32_t> keys(2 * drives);
  std::iota(keys.begin(), keys.end(), 1U);
  std::shuffle(keys.begin(), keys.end(), random);
  std::vector<WireFrame> frames;
  for (std::size_t i = 0; i < drives; ++i) {
    frames.push_back(command(keys[i], kStepNs * pick(240, 700)));
  }
  for (std::size_t i = 0; i < drives; ++i) {
    const bool unasked = pick(0, 9) == 0;
    frames.push_back(reply(keys[drives + i], kStepNs * pick(240, 700),
                           unasked ? WireFrame::kNothing : i, kStepNs * pick(0, 2500)));
  }
  return frames;
}

TEST(Schedule, TwoDrivesByHand) {
  // 100 us a frame, 150 us to answer; replies win over commands.
  const std::vector<WireFrame> frames{command(10, 100),      command(11, 100),
                                      command(12, 100),      reply(1, 100, 0, 150),
                                      reply(2, 100, 1, 150), reply(3, 100, 2, 150)};
  const Timeline line = lay_out(frames);
  const std::vector<std::int64_t> starts{0, 100, 200, 300, 400, 500};
  for (std::size_t i = 0; i < frames.size(); ++i) EXPECT_EQ(line.frames[i].start_ns, starts[i]);
  EXPECT_EQ(line.frames[3].ready_ns, 250);
  EXPECT_EQ(line.end_ns, 600);
  EXPECT_EQ(line.idle_ns(), 0);
  EXPECT_EQ(line.gap_ns, 100);
  EXPECT_EQ(line.collisions, 0U);
}

TEST(Schedule, TheWireIdlesWhileTheLastDriveThinks) {
  const Timeline line = lay_out(std::vector{command(1, 100), reply(2, 100, 0, 250)});
  EXPECT_EQ(line.frames[1].start_ns, 350);
  EXPECT_EQ(line.idle_ns(), 250);
  EXPECT_EQ(line.busy_ns, 200);
}

TEST(Schedule, TwoRepliesOfOneIdentifierThatWaitTogetherCollide) {
  // Both are ready while the third command is on the wire.
  const std::vector<WireFrame> frames{command(1, 100), command(2, 100), command(3, 300),
                                      reply(9, 100, 0, 200), reply(9, 100, 1, 100)};
  EXPECT_EQ(lay_out(frames).collisions, 1U);
  std::vector<WireFrame> apart = frames;
  apart[4].latency_ns = 1000;
  EXPECT_EQ(lay_out(apart).collisions, 0U);
  std::vector<WireFrame> of_one_drive = frames;
  of_one_drive[3].sender = of_one_drive[4].sender = 0;
  EXPECT_EQ(lay_out(of_one_drive).collisions, 0U);
}

TEST(Schedule, AgreesWithGoingAlongTheWire) {
  std::mt19937 random(5);
  for (int round = 0; round < 60; ++round) {
    const std::vector<WireFrame> frames = random_cycle(random, 1 + random() % 9);
    const Timeline line = lay_out(frames);
    const std::vector<WireTime> expected = step_by_step(frames);
    std::int64_t end = 0;
    for (std::size_t i = 0; i < frames.size(); ++i) {
      EXPECT_EQ(line.frames[i].start_ns, expected[i].start_ns) << round << ", frame " << i;
      EXPECT_EQ(line.frames[i].end_ns, expected[i].end_ns) << round << ", frame " << i;
      end = std::max(end, expected[i].end_ns);
    }
    EXPECT_EQ(line.end_ns, end);
  }
}

TEST(Schedule, NothingIsLaterThanTheBoundWhateverTheFramesHold) {
  std::mt19937 random(6);
  for (int round = 0; round < 300; ++round) {
    std::vector<WireFrame> frames = random_cycle(random, 1 + random() % 12);
    std::int64_t latency = 0;
    for (const WireFrame& frame : frames) latency = std::max(latency, frame.latency_ns);
    const std::int64_t bound = lay_out(frames).busy_ns + latency;
    for (int contents = 0; contents < 10; ++contents) {
      for (WireFrame& frame : frames) {
        frame.duration_ns -= static_cast<std::int64_t>(random() % 20) * kStepNs;
        frame.duration_ns = std::max(frame.duration_ns, 200 * kStepNs);
      }
      EXPECT_LE(lay_out(frames).end_ns, bound);
    }
  }
}

/// Ends when the drives of a cycle (see random_cycle) are sent to in that order.
std::int64_t end_in(const std::vector<WireFrame>& frames, std::span<const std::size_t> order) {
  std::vector<WireFrame> sorted;
  for (const std::size_t i : order) sorted.push_back(frames[i]);
  for (std::size_t i = 0; i < order.size(); ++i) {
    WireFrame answer = frames[order.size() + order[i]];
    if (answer.answers != WireFrame::kNothing) answer.answers = i;
    sorted.push_back(answer);
  }
  return lay_out(sorted).end_ns;
}

TEST(Schedule, TheOrderIsAsGoodAsTheBestOfAll) {
  std::mt19937 random(7);
  int missed = 0;
  std::int64_t lost = 0;
  for (int round = 0; round < 40; ++round) {
    const std::vector<WireFrame> frames = random_cycle(random, 5);
    std::vector<std::size_t> order(5);
    std::iota(order.begin(), order.end(), 0U);
    const std::vector<std::size_t> given = order;
    std::int64_t best = end_in(frames, order);
    while (std::next_permutation(order.begin(), order.end())) {
      best = std::min(best, end_in(frames, order));
    }
    const OrderCost cost = [&](std::span<const std::size_t> o) { return end_in(frames, o); };
    const std::vector<std::vector<std::size_t>> candidates{given};
    const std::vector<std::size_t> found = best_order(candidates, cost);
    EXPECT_TRUE(std::is_permutation(found.begin(), found.end(), given.begin(), given.end()));
    EXPECT_LE(end_in(frames, found), end_in(frames, given));
    missed += end_in(frames, found) > best ? 1 : 0;
    lost = std::max(lost, (end_in(frames, found) - best) * 100 / best);
  }
  EXPECT_LE(missed, 4);  // a descent may end in a valley
  EXPECT_LE(lost, 5);    // per cent
}

TEST(Schedule, AmongEqualsTheFirstOrderStands) {
  const std::vector<std::vector<std::size_t>> candidates{{2, 0, 1}, {0, 1, 2}};
  const OrderCost cost = [](std::span<const std::size_t>) { return std::int64_t{7}; };
  EXPECT_EQ(best_order(candidates, cost), candidates.front());
}

}  // namespace
}  // namespace geodesic::drivers
