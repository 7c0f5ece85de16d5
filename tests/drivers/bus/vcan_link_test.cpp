// What the kernel does with an interface that is brought up, held still, unplugged and put back: on
// a virtual one (GEODESIC_VCAN, default vcan0), as root of a network namespace.
#include <net/if.h>

#include <cstdlib>

#include "drivers/bus/can_link.hpp"
#include "drivers/bus/socketcan_bus.hpp"
#include "rt/seal.hpp"
#include "tests/drivers/bus/held_bus.hpp"

namespace geodesic::drivers {
namespace {

using testing::error_text;
using testing::eventually;
using testing::hold_for_a_second;
using testing::ids;
using testing::kMillisecond;
using testing::make_cycle;
using testing::make_frame;
using testing::receive;
using testing::receive_for;
using testing::send_when_free;
using testing::Tender;

void run(const std::string& command) {
  ASSERT_EQ(std::system(command.c_str()), 0) << command;
}

std::string text_of(const std::vector<BusNews>& news) {
  std::string text;
  for (const BusNews& one : news) text += (one.warning ? "! " : "") + one.text + "\n";
  return text;
}

/// An interface of its own, that may be destroyed.
class VcanLink : public ::testing::Test {
 protected:
  void SetUp() override { make(); }
  void TearDown() override { run("ip link del " + name_ + " 2>/dev/null || true"); }
  void make() { run("ip link add dev " + name_ + " mtu 16 type vcan"); }
  void up() { run("ip link set " + name_ + " mtu 72 up"); }

  BusOptions options() {
    BusOptions result;
    result.name = "arm";
    result.interface = name_;
    result.fd = true;
    result.bring_up = true;
    return result;
  }
  std::unique_ptr<Bus> monitor() { return open_bus(options()); }
  std::unique_ptr<Bus> commander() {
    BusOptions result = options();
    result.receive = ids(0x11, 8);
    result.transmit = ids(0x01, 8);
    return open_bus(result);
  }

  std::string name_ = "vcan40";
};

TEST_F(VcanLink, IsSetUpWhereThatIsAllowed) {
  BusOptions wanted = options();
  wanted.queue = 77;
  wanted.transmit = ids(0x01, 8);
  BusOptions checked = wanted;
  checked.bring_up = false;
  EXPECT_EQ(
      error_text([&] { open_bus(checked); }),
      "arm: interface vcan40 is down and otherwise than configured: carries classic CAN only "
      "(mtu 16), but CAN FD (mtu 72) is configured; queue of 1000 frames, configured 77; fix: "
      "ip link set vcan40 txqueuelen 77 mtu 72 up");
  const auto bus = open_bus(wanted);
  KernelLinkPort port;
  int error = 0;
  const auto link = port.read(name_, error);
  ASSERT_TRUE(link.has_value());
  EXPECT_TRUE(link->up);
  EXPECT_EQ(link->mtu, 72);
  EXPECT_EQ(link->queue, 77);
  EXPECT_EQ(link->kind, "vcan");
  EXPECT_NE(text_of(bus->take_news()).find("set up as configured"), std::string::npos);
  const auto names = port.all();
  EXPECT_TRUE(std::any_of(names.begin(), names.end(),
                          [&](const CanLink& one) { return one.name == name_; }));
}

TEST_F(VcanLink, WhatTheLineSaysHelps) {
  BusOptions checked = options();
  checked.bring_up = false;
  checked.queue = 50;
  checked.transmit = ids(0x01, 8);
  const std::string text = error_text([&] { open_bus(checked); });
  const std::size_t fix = text.find("fix: ");
  ASSERT_NE(fix, std::string::npos) << text;
  run(text.substr(fix + 5));
  open_bus(checked);
}

TEST_F(VcanLink, RemoteFramesCross) {
  const auto a = monitor();
  const auto b = monitor();
  Frame remote = make_frame(0x123);
  remote.remote = true;
  remote.length = 6;
  ASSERT_EQ(a->send({&remote, 1}), 1U);
  const auto got = receive(*b, 1);
  ASSERT_EQ(got.size(), 1U);
  EXPECT_EQ(got[0].frame, remote);
}

TEST_F(VcanLink, OwnRemoteFramesAreConfirmedToo) {
  const auto host = commander();
  Frame remote = make_frame(0x02);
  remote.remote = true;
  for (int i = 0; i < 10; ++i) {
    ASSERT_TRUE(send_when_free(*host, {&remote, 1})) << i;
  }
  EXPECT_FALSE(host->state().foreign_commander);
}

TEST_F(VcanLink, HeldForASecondItDeliversNoOldCommand) {
  const auto host = commander();
  const auto drive = monitor();
  Tender tender(*host);
  const auto result = hold_for_a_second(*host, *drive, [this](bool held) {
    run("tc qdisc " + std::string(held ? "add" : "change") + " dev " + name_ + " root tbf rate " +
        (held ? "128bit burst 32" : "10mbit burst 3200") + " limit 10000");
  });
  tender.stop();
  // Without echo, vcan gives a copy to the others before the queue: nothing is old there, ever.
  EXPECT_GE(result.arrived_before, 50U);
  EXPECT_GE(result.arrived_after, 50U);
  EXPECT_LT(result.oldest_ns, 60 * kMillisecond + result.longest_pause_ns);
  EXPECT_GT(host->health().purged, 0U);
  EXPECT_FALSE(host->state().down) << "a purge is no failure of the link";
  const std::string news = text_of(host->take_news());
  EXPECT_NE(news.find("! arm: vcan40: nothing has left for"), std::string::npos) << news;
}

TEST_F(VcanLink, SetDownBySomebodyItIsLeftDown) {
  const auto host = commander();
  host->tend();
  ASSERT_TRUE(send_when_free(*host, make_cycle(0x01, 7, 1)));
  run("ip link set " + name_ + " down");
  for (const std::int64_t end = rt::now_ns() + 400 * kMillisecond; rt::now_ns() < end;) {
    host->send(make_cycle(0x01, 7, 2));
    receive_for(*host, 5 * kMillisecond);
    host->tend();
  }
  EXPECT_TRUE(host->state().down);
  const std::string news = text_of(host->take_news());
  EXPECT_NE(news.find("! arm: somebody set interface vcan40 down; it is left so; fix: ip link set "
                      "vcan40 mtu 72 up"),
            std::string::npos)
      << news;
  run("ip link set " + name_ + " up");
  EXPECT_TRUE(send_when_free(*host, make_cycle(0x01, 7, 3)));
  EXPECT_FALSE(host->state().down);
}

TEST_F(VcanLink, UnpluggedAndBackItIsOpenedAnewBehindTheSeal) {
  const auto host = commander();
  const int descriptor = host->descriptor();
  const unsigned index = ::if_nametoindex(name_.c_str());
  Tender tender(*host);
  std::atomic<bool> stop{false};
  std::atomic<bool> down{false};
  std::atomic<std::uint64_t> refused{0};
  std::atomic<int> sealing{-1};
  rt::Seal seal;
  ASSERT_FALSE(seal.prepare({{descriptor}}).has_value());
  // The real-time thread: sends and receives, sealed, whatever happens.
  std::thread loop([&] {
    sealing.store(seal.apply());
    const std::vector<Frame> cycle = make_cycle(0x01, 7, 1);
    std::array<ReceivedFrame, 32> answers;
    while (!stop.load()) {
      host->send(cycle);
      host->receive(answers);
      down.store(host->state().down);
      const timespec until = [] {
        const std::int64_t at = rt::now_ns() + 2 * kMillisecond;
        return timespec{at / 1'000'000'000, at % 1'000'000'000};
      }();
      ::clock_nanosleep(CLOCK_MONOTONIC, TIMER_ABSTIME, &until, nullptr);
    }
    refused.store(seal.refused());
    rt::exit_thread();
  });
  EXPECT_TRUE(eventually([&] { return sealing.load() >= 0; }));
  EXPECT_EQ(sealing.load(), rt::kSealBuilt ? 0 : sealing.load());
  for (int times = 0; times < 2; ++times) {
    run("ip link del " + name_);
    EXPECT_TRUE(eventually([&] { return down.load(); }));
    ::usleep(150'000);  // some tries in vain
    make();             // down and classic, as an adapter is when it comes back
    EXPECT_TRUE(eventually([&] { return !down.load(); }));
    const auto drive = monitor();
    EXPECT_GE(receive(*drive, 14).size(), 14U) << "commands flow again";
  }
  stop.store(true);
  loop.join();
  tender.stop();
  EXPECT_EQ(refused.load(), 0U);
  EXPECT_NE(::if_nametoindex(name_.c_str()), index);
  EXPECT_EQ(host->descriptor(), descriptor);
  EXPECT_EQ(host->health().reopened, 2U);
  EXPECT_EQ(host->health().device, name_);
  const std::string news = text_of(host->take_news());
  EXPECT_NE(news.find("! arm: interface vcan40 has gone"), std::string::npos) << news;
  EXPECT_NE(news.find("arm: interface vcan40 is back and open again"), std::string::npos) << news;
}

}  // namespace
}  // namespace geodesic::drivers
