// The thread that looks after the buses: it tends them, and what they tell comes out in order.
#include "tools/geodesicd/bus_keeper.hpp"

#include <gtest/gtest.h>
#include <sys/eventfd.h>
#include <unistd.h>

#include <chrono>

#include "rt/capabilities.hpp"
#include "tests/tools/geodesicd_fixture.hpp"

namespace geodesic::tools {
namespace {

/// Tells something new each time it is tended.
class TellingBus final : public drivers::Bus {
 public:
  ~TellingBus() override { ::close(descriptor_); }
  std::size_t send(std::span<const drivers::Frame> frames) noexcept override {
    return frames.size();
  }
  std::size_t receive(std::span<drivers::ReceivedFrame> /*out*/) noexcept override { return 0; }
  int descriptor() const noexcept override { return descriptor_; }
  void tend() noexcept override { ++tended_; }
  drivers::LinkHealth health() const override {
    drivers::LinkHealth health;
    health.device = "can7";
    health.restarts = static_cast<std::uint32_t>(tended_);
    return health;
  }
  std::vector<drivers::BusNews> take_news() override {
    return {{tended_ % 2 == 0, std::to_string(tended_)}};
  }
  const control::BusState& state() const noexcept override { return state_; }
  const drivers::BusCounters& counters() const noexcept override { return counters_; }

 private:
  int descriptor_ = ::eventfd(0, EFD_NONBLOCK | EFD_CLOEXEC);
  int tended_ = 0;
  control::BusState state_;
  drivers::BusCounters counters_;
};

class BusKeeperTest : public testing::Test {
 protected:
  BusKeeperTest() {
    std::vector<std::unique_ptr<drivers::Bus>> buses;
    buses.push_back(std::make_unique<TellingBus>());
    arm_ = std::make_unique<drivers::Arm>(robot_.arm, std::move(buses));
  }
  config::Robot robot_ = small_robot();
  std::unique_ptr<drivers::Arm> arm_;
};

TEST_F(BusKeeperTest, TendsAndPassesOnWhatIsTold) {
  BusKeeper keeper(*arm_, robot_.arm.buses);
  std::vector<drivers::BusNews> all;
  for (int i = 0; i < 1000 && all.size() < 5; ++i) {
    for (drivers::BusNews& one : keeper.take_news()) all.push_back(std::move(one));
    std::this_thread::sleep_for(std::chrono::milliseconds(5));
  }
  ASSERT_GE(all.size(), 5U);
  for (std::size_t i = 0; i < all.size(); ++i) {
    EXPECT_EQ(all[i].text, std::to_string(i + 1)) << "in order, none twice";
  }
  EXPECT_EQ(keeper.health()[0].device, "can7");
  EXPECT_GE(keeper.health()[0].restarts, 5U);
}

TEST_F(BusKeeperTest, WhatNobodyReadsIsBounded) {
  BusKeeper keeper(*arm_, robot_.arm.buses);
  for (int i = 0; i < 2000 && keeper.health()[0].restarts < 300; ++i) {
    std::this_thread::sleep_for(std::chrono::milliseconds(5));
  }
  EXPECT_EQ(keeper.take_news().size(), 256U);
}

TEST_F(BusKeeperTest, KeepsNoCapabilityForASocketBus) {
  std::vector<drivers::BusOptions> buses = robot_.arm.buses;
  buses[0].interface = "unix:/tmp/none";
  buses[0].bring_up = true;
  EXPECT_EQ(BusKeeper(*arm_, buses).privileged_thread(), 0);
  buses[0].interface = "can0";
  buses[0].bring_up = false;
  EXPECT_EQ(BusKeeper(*arm_, buses).privileged_thread(), 0);
}

}  // namespace
}  // namespace geodesic::tools
