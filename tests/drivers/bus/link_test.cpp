// What is wanted of an interface, what is done about it and what is told of it, against a kernel
// that is made up: it refuses what the real one refuses.
#include <fmt/format.h>

#include "drivers/bus/link_keeper.hpp"
#include "drivers/bus/link_plan.hpp"
#include "drivers/bus/link_setup.hpp"
#include "tests/drivers/bus/bus_testing.hpp"

namespace geodesic::drivers {
namespace {

using testing::error_text;
using testing::ids;
using testing::kMillisecond;

/// One interface.
class MadeUpKernel final : public LinkPort {
 public:
  CanLink link;
  bool there = true;
  bool allowed = true;
  int refuse_setting = 0;  ///< errno
  std::vector<std::string> calls;

  std::optional<CanLink> read(const std::string& name, int& error) override {
    error = there && name == link.name ? 0 : ENODEV;
    return error == 0 ? std::optional(link) : std::nullopt;
  }
  NetlinkVerdict change(int index, const LinkChange& change) override {
    EXPECT_EQ(index, link.index);
    if (!allowed) return {EPERM, {}};
    if ((change.touches_controller() || change.mtu) && link.up) return {EBUSY, {}};
    if (change.touches_controller() && refuse_setting != 0) {
      return {refuse_setting, "bit-timing not yet defined"};
    }
    calls.push_back(fmt::format("{}{}{}{}", change.up ? (*change.up ? "up " : "down ") : "",
                                change.touches_controller() ? "controller " : "",
                                change.queue ? "queue " : "", change.mtu ? "mtu " : ""));
    if (change.bit_rate) link.nominal = {*change.bit_rate, change.sample_point.value_or(0.75), 0};
    if (change.data_bit_rate) {
      link.data = {*change.data_bit_rate, change.data_sample_point.value_or(0.75), 0};
    }
    link.fd = change.fd.value_or(link.fd);
    link.mtu = change.mtu.value_or(change.fd ? (*change.fd ? 72 : 16) : link.mtu);
    if (change.restart_ms) link.restart_ms = change.restart_ms;
    link.queue = change.queue.value_or(link.queue);
    link.up = change.up.value_or(link.up);
    return {};
  }
};

/// As an adapter is that was just plugged in.
MadeUpKernel plugged_in() {
  MadeUpKernel kernel;
  kernel.link.index = 5;
  kernel.link.name = "can0";
  kernel.link.kind = "can";
  kernel.link.can = true;
  kernel.link.echoes = true;
  kernel.link.mtu = 16;
  kernel.link.queue = 10;
  kernel.link.restart_ms = 0;
  kernel.link.controller = LinkHealth{};
  kernel.link.controller->state = ControllerState::kStopped;
  return kernel;
}

BusOptions commander() {
  BusOptions options;
  options.name = "arm";
  options.interface = "can0";
  options.bring_up = true;
  options.receive = ids(0x11, 2);
  options.transmit = ids(0x01, 2);
  return options;
}

BusOptions fd_commander() {
  BusOptions options = commander();
  options.fd = true;
  options.sample_point = 0.8;
  options.data_sample_point = 0.75;
  options.restart_ms = 50;
  options.queue = 32;
  return options;
}

TEST(LinkSetup, SetsUpWhatIsDown) {
  MadeUpKernel kernel = plugged_in();
  std::vector<BusNews> news;
  const CanLink link = prepare_link(kernel, fd_commander(), "can0", news);
  EXPECT_TRUE(link.up && link.fd);
  EXPECT_EQ(link.nominal.bit_rate, 1'000'000);
  EXPECT_EQ(link.nominal.sample_point, 0.8);
  EXPECT_EQ(link.data.bit_rate, 5'000'000);
  EXPECT_EQ(link.restart_ms, 50);
  EXPECT_EQ(link.queue, 32);
  EXPECT_EQ(kernel.calls, (std::vector<std::string>{"controller queue ", "up "}));
  ASSERT_EQ(news.size(), 1U);
  EXPECT_FALSE(news[0].warning);
  EXPECT_NE(news[0].text.find("ip link set can0 txqueuelen 32 up type can bitrate 1000000 "
                              "sample-point 0.800 dbitrate 5000000 dsample-point 0.750 fd on "
                              "restart-ms 50"),
            std::string::npos)
      << news[0].text;
}

TEST(LinkSetup, WhatTheFileLeavesOpenHasGoodDefaults) {
  MadeUpKernel kernel = plugged_in();
  std::vector<BusNews> news;
  const CanLink link = prepare_link(kernel, commander(), "can0", news);
  EXPECT_EQ(link.restart_ms, 100);
  EXPECT_EQ(link.queue, 64);
  EXPECT_FALSE(link.fd);
}

TEST(LinkSetup, WhatIsRightIsLeftAlone) {
  MadeUpKernel kernel = plugged_in();
  std::vector<BusNews> news;
  prepare_link(kernel, commander(), "can0", news);
  kernel.calls.clear();
  kernel.link.queue = 200;  // by somebody, and the file does not say
  kernel.link.restart_ms = 0;
  news.clear();
  prepare_link(kernel, commander(), "can0", news);
  EXPECT_TRUE(kernel.calls.empty());
  EXPECT_TRUE(news.empty());
}

TEST(LinkSetup, WhatIsUpOtherwiseIsTakenDownFirst) {
  MadeUpKernel kernel = plugged_in();
  std::vector<BusNews> news;
  prepare_link(kernel, commander(), "can0", news);
  kernel.link.nominal.bit_rate = 500'000;
  kernel.calls.clear();
  prepare_link(kernel, commander(), "can0", news);
  EXPECT_EQ(kernel.calls, (std::vector<std::string>{"down ", "controller ", "up "}));
  EXPECT_EQ(kernel.link.nominal.bit_rate, 1'000'000);
}

TEST(LinkSetup, AQueueIsChangedWhileItIsUp) {
  MadeUpKernel kernel = plugged_in();
  std::vector<BusNews> news;
  BusOptions options = commander();
  prepare_link(kernel, options, "can0", news);
  kernel.calls.clear();
  options.queue = 20;
  prepare_link(kernel, options, "can0", news);
  EXPECT_EQ(kernel.calls, (std::vector<std::string>{"queue "}));
}

TEST(LinkSetup, WhoMayNotIsToldTheLine) {
  MadeUpKernel kernel = plugged_in();
  kernel.allowed = false;
  std::vector<BusNews> news;
  EXPECT_EQ(error_text([&] { prepare_link(kernel, fd_commander(), "can0", news); }),
            "arm: interface can0 is down and otherwise than configured: queue of 10 frames, "
            "configured 32 (not set up by this program: it lacks CAP_NET_ADMIN); fix: ip link set "
            "can0 txqueuelen 32 up type can bitrate 1000000 sample-point 0.800 dbitrate 5000000 "
            "dsample-point 0.750 fd on restart-ms 50");
  kernel.link.up = true;
  kernel.link.nominal = {500'000, 0.875, 0};
  kernel.link.restart_ms = 0;
  kernel.link.queue = 32;
  BusOptions classic = fd_commander();
  classic.fd = false;
  classic.bring_up = false;
  EXPECT_EQ(
      error_text([&] { prepare_link(kernel, classic, "can0", news); }),
      "arm: interface can0 is otherwise than configured: bit rate 500000, configured 1000000; "
      "sample point 0.875, configured 0.800; restart-ms 0, configured 50; fix: ip link set "
      "can0 down && ip link set can0 txqueuelen 32 up type can bitrate 1000000 sample-point "
      "0.800 restart-ms 50");
  classic.bit_rate = 500'000;
  classic.sample_point.reset();
  classic.restart_ms.reset();
  classic.queue = 64;
  EXPECT_EQ(error_text([&] { prepare_link(kernel, classic, "can0", news); }),
            "arm: interface can0 is otherwise than configured: queue of 32 frames, configured 64; "
            "fix: ip link set can0 txqueuelen 64");
  EXPECT_TRUE(kernel.calls.empty());
}

TEST(LinkSetup, FdIsChecked) {
  MadeUpKernel kernel = plugged_in();
  kernel.link.up = true;
  kernel.link.nominal = {1'000'000, 0.75, 0};
  std::vector<BusNews> news;
  BusOptions options = commander();
  options.fd = true;
  options.bring_up = false;
  EXPECT_NE(
      error_text([&] { prepare_link(kernel, options, "can0", news); })
          .find("CAN FD is off, configured on; fix: ip link set can0 down && ip link set can0 "
                "txqueuelen 64 up type can bitrate 1000000 dbitrate 5000000 fd on"),
      std::string::npos);
  kernel.link.fd = true;
  kernel.link.data = {2'000'000, 0.75, 0};
  EXPECT_NE(error_text([&] {
              prepare_link(kernel, options, "can0", news);
            }).find("data bit rate 2000000, configured 5000000"),
            std::string::npos);
}

TEST(LinkSetup, WhatTheControllerCannotIsSaidInTheKernelsWords) {
  MadeUpKernel kernel = plugged_in();
  kernel.refuse_setting = EINVAL;
  std::vector<BusNews> news;
  const std::string text = error_text([&] { prepare_link(kernel, commander(), "can0", news); });
  EXPECT_NE(text.find("setting it up was refused by the kernel: bit-timing not yet defined "
                      "(Invalid argument)"),
            std::string::npos)
      << text;
  EXPECT_FALSE(kernel.link.up) << "it came up with the old bit rate";
}

TEST(LinkSetup, MonitorsJudgeNoBitRate) {
  MadeUpKernel kernel = plugged_in();
  kernel.link.up = true;
  kernel.link.nominal = {250'000, 0.75, 0};
  std::vector<BusNews> news;
  BusOptions monitor;
  monitor.interface = "can0";
  EXPECT_EQ(prepare_link(kernel, monitor, "can0", news).nominal.bit_rate, 250'000);
  kernel.link.up = false;
  EXPECT_NE(error_text([&] { prepare_link(kernel, monitor, "can0", news); }).find("can0 is down"),
            std::string::npos);
}

TEST(LinkSetup, ASamplePointIsTheSameWithinAQuantum) {
  MadeUpKernel kernel = plugged_in();
  kernel.link.up = true;
  BusOptions options = commander();
  options.sample_point = 0.8;
  kernel.link.nominal = {1'000'000, 0.75, 16};
  EXPECT_TRUE(link_differences(kernel.link, options).empty());
  kernel.link.nominal = {1'000'000, 0.75, 80};
  EXPECT_FALSE(link_differences(kernel.link, options).empty());
  kernel.link.nominal = {1'000'000, 0.875, 8};
  EXPECT_TRUE(link_differences(kernel.link, options).empty());
}

TEST(LinkSetup, ASimilarRateIsTheSame) {
  MadeUpKernel kernel = plugged_in();
  kernel.link.up = true;
  kernel.link.nominal = {999'000, 0.75, 0};
  EXPECT_TRUE(link_differences(kernel.link, commander()).empty());
  kernel.link.nominal = {990'000, 0.75, 0};
  EXPECT_FALSE(link_differences(kernel.link, commander()).empty());
  kernel.link.nominal = {};  // set by other means: nobody knows
  EXPECT_TRUE(link_differences(kernel.link, commander()).empty());
}

class Keeper : public ::testing::Test {
 protected:
  Keeper() {
    std::vector<BusNews> news;
    prepare_link(kernel_, options_, "can0", news);
    kernel_.link.controller->state = ControllerState::kActive;
    kernel_.calls.clear();
  }
  /// What a look finds after `change`.
  std::string news_of(LinkKeeper& keeper, const std::function<void(LinkHealth&)>& change = {}) {
    if (change) change(*kernel_.link.controller);
    now_ns_ += 200 * kMillisecond;
    keeper.look(now_ns_, received_);
    std::string text;
    for (const BusNews& one : keeper.take_news()) {
      text += fmt::format("{}{}\n", one.warning ? "! " : "", one.text);
    }
    return text;
  }

  BusOptions options_ = commander();
  MadeUpKernel kernel_ = plugged_in();
  std::int64_t now_ns_ = 1'000'000'000;
  std::uint64_t received_ = 0;
};

TEST_F(Keeper, WarnsBeforeBusOffAndTellsTheWayBack) {
  LinkKeeper keeper(options_, kernel_, kernel_.link);
  EXPECT_EQ(news_of(keeper), "");
  std::string text = news_of(keeper, [](LinkHealth& health) {
    health.state = ControllerState::kWarning;
    health.transmit_errors = 96;
  });
  EXPECT_NE(text.find("! arm: can0 is error-warning: transmit errors 96, receive errors 0; bus-off "
                      "comes at 256"),
            std::string::npos)
      << text;
  EXPECT_EQ(news_of(keeper), "") << "told once";
  text = news_of(keeper, [](LinkHealth& health) { health.state = ControllerState::kPassive; });
  EXPECT_NE(text.find("error-passive"), std::string::npos) << text;
  EXPECT_EQ(keeper.health().state, ControllerState::kPassive);
  text = news_of(keeper, [](LinkHealth& health) {
    health.state = ControllerState::kBusOff;
    health.bus_offs = 1;
  });
  EXPECT_NE(text.find("! arm: can0 left the bus (bus-off, 1 times so far), it restarts 100 ms "
                      "later"),
            std::string::npos)
      << text;
  text = news_of(keeper, [](LinkHealth& health) { health.state = ControllerState::kActive; });
  EXPECT_NE(text.find("can0 is error-active again"), std::string::npos) << text;
}

TEST_F(Keeper, ABusOffBetweenTwoLooksIsNotMissed) {
  LinkKeeper keeper(options_, kernel_, kernel_.link);
  const std::string text = news_of(keeper, [](LinkHealth& health) { health.bus_offs = 2; });
  EXPECT_NE(text.find("left the bus (bus-off, 2 times so far)"), std::string::npos) << text;
}

TEST_F(Keeper, AControllerThatStaysAwayHasItsLine) {
  kernel_.link.restart_ms = 0;
  options_.bring_up = false;
  LinkKeeper keeper(options_, kernel_, kernel_.link);
  EXPECT_TRUE(keeper.stays_off());
  const std::string text =
      news_of(keeper, [](LinkHealth& health) { health.state = ControllerState::kBusOff; });
  EXPECT_NE(text.find("stays away; fix: ip link set can0 type can restart"), std::string::npos)
      << text;
}

TEST_F(Keeper, PurgesByDownAndUp) {
  LinkKeeper keeper(options_, kernel_, kernel_.link);
  EXPECT_TRUE(keeper.purge(now_ns_, 20 * kMillisecond));
  EXPECT_EQ(kernel_.calls, (std::vector<std::string>{"down ", "up "}));
  EXPECT_EQ(keeper.health().purged, 1U);
  EXPECT_NE(news_of(keeper).find("! arm: can0: nothing has left for 20 ms; taken down and up"),
            std::string::npos);
  EXPECT_TRUE(keeper.purge(now_ns_, 20 * kMillisecond));
  EXPECT_EQ(news_of(keeper), "") << "told once in ten seconds";
}

TEST_F(Keeper, WhatSomebodySetDownIsLeftDown) {
  LinkKeeper keeper(options_, kernel_, kernel_.link);
  kernel_.link.up = false;
  EXPECT_FALSE(keeper.purge(now_ns_, 20 * kMillisecond));
  EXPECT_FALSE(kernel_.link.up);
  const std::string text = news_of(keeper);
  EXPECT_NE(
      text.find("! arm: somebody set interface can0 down; it is left so; fix: ip link set can0 "
                "txqueuelen 64 up type can bitrate 1000000 restart-ms 100"),
      std::string::npos)
      << text;
  kernel_.link.up = true;
  EXPECT_NE(news_of(keeper).find("up again"), std::string::npos);
}

TEST_F(Keeper, WhoMayNotPurgeTriesOnceAndSaysWhatItMeans) {
  kernel_.allowed = false;
  LinkKeeper keeper(options_, kernel_, kernel_.link);
  EXPECT_TRUE(keeper.may_change());
  EXPECT_FALSE(keeper.purge(now_ns_, 20 * kMillisecond));
  EXPECT_FALSE(keeper.may_change());
  EXPECT_NE(news_of(keeper).find("one cycle of old commands may still reach the drives"),
            std::string::npos);
}

TEST_F(Keeper, ABabblingNodeIsSeenThoughItsFramesAreFiltered) {
  LinkKeeper keeper(options_, kernel_, kernel_.link);
  std::string all;
  for (int look = 0; look < 20; ++look) {  // 4 s: 400 of ours, 600 foreign ones, each second
    kernel_.link.received += 200;
    received_ += 80;
    all += news_of(keeper);
  }
  EXPECT_EQ(all, "");
  EXPECT_NEAR(keeper.health().foreign_frames_hz, 600.0, 1.0);
  for (int look = 0; look < 20; ++look) {
    kernel_.link.received += 1'000;
    all += news_of(keeper);
  }
  EXPECT_NE(all.find("! arm: 5000 frames a second on can0 are nobody's of this robot, 56 % of what "
                     "the bus can carry: a node babbles"),
            std::string::npos)
      << all;
}

}  // namespace
}  // namespace geodesic::drivers
