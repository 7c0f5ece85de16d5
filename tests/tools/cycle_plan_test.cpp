// A planned cycle against the simulated wire, frame by frame; the order of commands; what comes in
// part of the cycles only.
#include "drivers/cycle_plan.hpp"

#include <gtest/gtest.h>

#include <algorithm>
#include <map>
#include <numeric>
#include <random>

#include "drivers/bus/arbitration.hpp"
#include "tools/sim/wire_model.hpp"

namespace geodesic::drivers {
namespace {

constexpr std::int64_t kRate = 1'000'000;
constexpr std::int64_t kDataRate = 5'000'000;

JointOptions joint(std::uint32_t id, std::uint32_t reply_id, std::size_t bus = 0) {
  JointOptions options;
  options.bus = bus;
  options.drive.family = "damiao";
  options.drive.id = id;
  options.drive.reply_id = reply_id;
  options.drive.position_range_rad = 12.5;
  options.drive.velocity_range_rad_s = 30.0;
  options.drive.torque_range_nm = 10.0;
  return options;
}

BusOptions bus_named(const char* name, bool fd) {
  BusOptions bus;
  bus.name = name;
  bus.interface = "can0";
  bus.fd = fd;
  return bus;
}

ArmOptions bus_of(const std::vector<std::pair<std::uint32_t, std::uint32_t>>& ids, bool fd) {
  ArmOptions options;
  options.buses.push_back(bus_named("arm", fd));
  for (const auto& [id, reply] : ids) options.joints.push_back(joint(id, reply));
  return options;
}

Frame random_frame(std::mt19937& random, std::uint32_t id, bool fd) {
  Frame frame;
  frame.id = id;
  frame.fd = fd;
  frame.bit_rate_switch = fd;
  frame.extended = id > 0x7FF;
  frame.length = static_cast<std::uint8_t>(fd ? 8 * (1 + random() % 3) : random() % 9);
  for (std::uint8_t& byte : frame.data) byte = random() % 3 == 0 ? 0xFF : 0;
  return frame;
}

TEST(CyclePlan, TheModelIsTheSimulatedWire) {
  std::mt19937 random(3);
  for (int round = 0; round < 50; ++round) {
    const bool fd = round % 2 == 1;
    const std::size_t drives = 1 + random() % 8;
    std::vector<std::uint32_t> ids(2 * drives);
    std::iota(ids.begin(), ids.end(), 0x7F0U);  // some of 11 bits, some of 29
    std::shuffle(ids.begin(), ids.end(), random);
    std::vector<Frame> frames;
    std::vector<WireFrame> model;
    for (std::size_t i = 0; i < 2 * drives; ++i) {
      frames.push_back(random_frame(random, ids[i], fd));
      const bool reply = i >= drives;
      model.push_back({arbitration_key(frames[i]), frame_time_ns(frames[i], kRate, kDataRate),
                       reply, reply ? i - drives : WireFrame::kNothing,
                       reply ? static_cast<std::int64_t>(random() % 400'000) : 0});
    }
    const Timeline line = lay_out(model);

    tools::WireModel wire(kRate, kDataRate);
    for (std::size_t i = 0; i < drives; ++i) wire.push_host(frames[i], 0);
    std::size_t delivered = 0;
    for (auto due = wire.next_end_ns(); due; due = wire.next_end_ns(), ++delivered) {
      const auto delivery = *wire.pop(*due);
      const auto place = std::find_if(frames.begin(), frames.end(), [&](const Frame& frame) {
        return frame.id == delivery.frame.id;
      });
      const auto i = static_cast<std::size_t>(place - frames.begin());
      EXPECT_EQ(line.frames[i].end_ns, delivery.end_ns) << round << ", frame " << i;
      if (i < drives) {
        wire.push_reply(frames[drives + i], delivery.end_ns + model[drives + i].latency_ns);
      }
    }
    EXPECT_EQ(delivered, 2 * drives);
  }
}

TEST(CyclePlan, TheConfiguredOrderStandsWhereNothingIsGained) {
  const ArmOptions options =
      bus_of({{5, 0x15}, {2, 0x12}, {8, 0x18}, {1, 0x11}, {7, 0x17}, {3, 0x13}}, true);
  EXPECT_EQ(sending_order(options), (std::vector<std::size_t>{0, 1, 2, 3, 4, 5}));
}

TEST(CyclePlan, RepliesThatWouldPushInAreKeptForLater) {
  // Command and reply of a drive are neighbours: sent in this order, each reply wins over the next
  // command, and the last drive is waited for. From the highest down, all commands go first.
  const std::vector<std::pair<std::uint32_t, std::uint32_t>> ids{
      {0x2E, 0x29}, {0x4E, 0x49}, {0x6E, 0x69}, {0x8E, 0x89},
      {0xAE, 0xA9}, {0xCE, 0xC9}, {0xEE, 0xE9}};
  for (const bool fd : {false, true}) {
    const ArmOptions options = bus_of(ids, fd);
    const CyclePlan plan = plan_cycle(options, 0, 100.0);
    EXPECT_EQ(plan.worst.idle_ns(), 0);
    EXPECT_EQ(plan.best.idle_ns(), 0);
    EXPECT_GE(plan.reachable_hz(), 0.95 * plan.limit_hz());
    EXPECT_LE(plan.worst.gap_ns, 2 * plan.frames.front().wire.duration_ns);  // evenly
    // As configured the wire would wait.
    std::vector<WireFrame> plain;
    for (std::size_t i = 0; i < ids.size(); ++i) {
      plain.push_back({ids[i].first << 19, plan.frames.front().wire.duration_ns, false});
    }
    for (std::size_t i = 0; i < ids.size(); ++i) {
      plain.push_back(
          {ids[i].second << 19, plan.frames.front().wire.duration_ns, true, i, kUsualLatencyNs});
    }
    EXPECT_GT(lay_out(plain).idle_ns(), 0);
  }
}

TEST(CyclePlan, EveryBusHasItsOwnOrderAndLeader) {
  ArmOptions options;
  options.buses.push_back(bus_named("left", false));
  options.buses.push_back(bus_named("right", false));
  options.joints = {joint(1, 0x11, 0), joint(1, 0x11, 1), joint(2, 0x12, 0), joint(2, 0x12, 1)};
  const std::vector<std::size_t> order = sending_order(options);
  EXPECT_EQ(order, (std::vector<std::size_t>{0, 2, 1, 3}));
  for (std::size_t i = 0; i < 4; ++i) EXPECT_EQ(is_leader(options, order, i), i >= 2);
  EXPECT_TRUE(is_leader(options, {3, 1, 2, 0}, 0));
  const CyclePlan plan = plan_cycle(options, 1, 1000.0);
  EXPECT_EQ(plan.order, (std::vector<std::size_t>{1, 3}));
  EXPECT_EQ(plan.frames.size(), 4U);
  EXPECT_EQ(plan.budget.frames, 4U);
}

TEST(CyclePlan, NeverLaterThanItsBound) {
  for (const bool fd : {false, true}) {
    const CyclePlan plan = plan_cycle(bus_of({{1, 0x11}, {2, 0x12}}, fd), 0, 1000.0, 300'000);
    EXPECT_EQ(plan.latency_ns, 300'000);
    EXPECT_LE(plan.worst.end_ns, plan.bound_ns());
    EXPECT_LE(plan.best.end_ns, plan.worst.end_ns);
    EXPECT_GT(plan.worst.idle_ns(), 0);
    EXPECT_EQ(plan.budget.worst_ns, plan.worst.busy_ns);
    EXPECT_EQ(plan.budget.best_ns, plan.best.busy_ns);
  }
}

/// Every family, drives numbered from 1; those that a configuration must say more of are held to
/// their rate by bench.rates.
TEST(CyclePlan, FramesOfEveryFamilyFindTheirPlace) {
  for (const Family& family : families()) {
    ArmOptions options;
    options.buses.push_back(bus_named("arm", true));
    for (std::uint32_t id = 1; id <= 7; ++id) {
      options.joints.push_back(joint(id, 0x100 + id));
      options.joints.back().drive.family = family.name;
      for (std::size_t i = 0; i < family.settings.size(); ++i) {
        if (family.settings[i].required) options.joints.back().drive.settings.values[i] = 1.0;
      }
    }
    const CyclePlan plan = plan_cycle(options, 0, 200.0);
    EXPECT_EQ(plan.order.size(), 7U) << family.name;
    EXPECT_GE(plan.frames.size(), 14U) << family.name;
    EXPECT_GE(plan.reachable_hz(), 0.90 * plan.limit_hz()) << family.name;
    std::map<std::size_t, std::pair<int, int>> count;  // commands and replies of each joint
    for (std::size_t i = 0; i < plan.frames.size(); ++i) {
      const PlannedFrame& one = plan.frames[i];
      (one.frame.reply ? count[one.joint].second : count[one.joint].first) += 1;
      EXPECT_GT(plan.worst.frames[i].end_ns, 0) << family.name << ", " << one.frame.what;
      EXPECT_EQ(plan.worst.frames[i].end_ns - plan.worst.frames[i].start_ns, one.wire.duration_ns);
      if (one.frame.reply && one.wire.answers != WireFrame::kNothing) {
        EXPECT_LT(one.wire.answers, plan.frames.size());
        EXPECT_FALSE(plan.frames[one.wire.answers].frame.reply) << family.name;
      }
    }
    for (const auto& [joint, both] : count) {
      EXPECT_GE(both.first, 1) << family.name << " " << joint;
      EXPECT_GE(both.second, 1) << family.name << " " << joint;
    }
  }
}

}  // namespace
}  // namespace geodesic::drivers
