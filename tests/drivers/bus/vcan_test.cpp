// SocketCAN on a virtual bus (GEODESIC_VCAN, default vcan0), which has to exist: tests/lab/uml
// makes one where the host has none. Runs as root of a network namespace, with and without vcan's
// echo.
#include <linux/can/error.h>
#include <net/if.h>

#include <cstdlib>
#include <set>

#include "drivers/bus/socketcan_bus.hpp"
#include "tests/drivers/bus/bus_testing.hpp"

namespace geodesic::drivers {
namespace {

using testing::error_text;
using testing::ids;
using testing::kMillisecond;
using testing::make_cycle;
using testing::make_fd_frame;
using testing::make_frame;
using testing::receive;
using testing::receive_for;
using testing::send_when_free;

std::string interface_name() {
  const char* const name = std::getenv("GEODESIC_VCAN");
  return name != nullptr ? name : "vcan0";
}

void run(const std::string& command) {
  ASSERT_EQ(std::system(command.c_str()), 0) << command;
}

class VcanBus : public ::testing::Test {
 protected:
  void SetUp() override {
    ASSERT_NE(::if_nametoindex(name_.c_str()), 0U)
        << "no interface " << name_ << ": run this test by tests/lab/uml, or: ip link add dev "
        << name_ << " type vcan; ip link set " << name_ << " mtu 72 up";
  }
  void TearDown() override {
    if (changed_) {
      run("tc qdisc del dev " + name_ + " root 2>/dev/null; ip link set " + name_ +
          " down && ip link set " + name_ + " mtu 72 up");
    }
  }
  void change(const std::string& command) {
    changed_ = true;
    run(command);
  }

  BusOptions options(const std::vector<IdFilter>& in = {}, const std::vector<IdFilter>& out = {}) {
    BusOptions result;
    result.interface = name_;
    result.fd = true;
    result.receive = in;
    result.transmit = out;
    return result;
  }
  std::unique_ptr<Bus> monitor() { return open_bus(options()); }
  std::unique_ptr<Bus> commander() { return open_bus(options(ids(0x11, 8), ids(0x01, 8))); }

  std::string name_ = interface_name();
  bool changed_ = false;
};

TEST_F(VcanBus, FramesCrossWholeAndOwnOnesNeverShow) {
  const auto a = monitor();
  const auto b = monitor();
  Frame extended = make_frame(0x1ABCDEF0, {1, 2, 3});
  extended.extended = true;
  const std::vector<Frame> frames = {make_frame(0x10, {1, 2, 3, 4, 5, 6, 7, 8}), extended,
                                     make_fd_frame(0x20, 64), make_fd_frame(0x21, 12)};
  EXPECT_EQ(a->send(frames), frames.size());
  const auto got = receive(*b, frames.size());
  ASSERT_EQ(got.size(), frames.size());
  for (std::size_t i = 0; i < frames.size(); ++i) {
    EXPECT_EQ(got[i].frame, frames[i]) << i;
  }
  EXPECT_TRUE(receive_for(*a, 20 * kMillisecond).empty());
  EXPECT_EQ(a->counters().sent, frames.size());
  EXPECT_EQ(b->counters().received, frames.size());
}

TEST_F(VcanBus, LetsInWhatIsNamed) {
  const auto host = commander();
  const auto other = monitor();
  other->send(std::vector<Frame>{make_frame(0x300), make_frame(0x12), make_frame(0x19)});
  Frame extended = make_frame(0x12);
  extended.extended = true;
  other->send({&extended, 1});
  const auto got = receive_for(*host, 50 * kMillisecond);
  ASSERT_EQ(got.size(), 1U);
  EXPECT_EQ(got[0].frame.id, 0x12U);
  EXPECT_FALSE(host->state().foreign_commander);
}

TEST_F(VcanBus, ForeignCommandsAreSeenAndOwnOnesAreNot) {
  const auto host = commander();
  const auto other = monitor();
  for (int cycle = 0; cycle < 20; ++cycle) {
    ASSERT_TRUE(send_when_free(*host, make_cycle(0x01, 8, cycle)));
    receive_for(*host, kMillisecond);
  }
  EXPECT_FALSE(host->state().foreign_commander);
  EXPECT_EQ(host->counters().sent, 160U);
  other->send(make_cycle(0x03, 1, 0));
  EXPECT_TRUE(receive_for(*host, 20 * kMillisecond).empty());
  EXPECT_TRUE(host->state().foreign_commander);
  EXPECT_EQ(host->counters().foreign_commands, 1U);
}

TEST_F(VcanBus, StampsAreMonotonicAndNow) {
  const auto a = monitor();
  const auto b = monitor();
  std::int64_t last = 0;
  for (int cycle = 0; cycle < 50; ++cycle) {
    const std::int64_t before = rt::now_ns();
    ASSERT_EQ(a->send(make_cycle(0x10, 4, cycle)), 4U);
    const std::int64_t after = rt::now_ns();
    ::usleep(2000);
    std::array<ReceivedFrame, 8> out;
    const std::int64_t reading = rt::now_ns();
    ASSERT_EQ(b->receive(out), 4U);
    // Two clocks are read one after the other in there, and this machine may be interrupted between
    // them: a stamp may be too young by as long as that took.
    const std::int64_t blur = kMillisecond + rt::now_ns() - reading;
    for (std::size_t i = 0; i < 4; ++i) {
      EXPECT_GE(out[i].stamp_ns, before - kMillisecond);
      EXPECT_LE(out[i].stamp_ns, after + blur);
      EXPECT_GE(out[i].stamp_ns, last - blur);
      last = out[i].stamp_ns;
    }
  }
}

TEST_F(VcanBus, ErrorFramesTellTheState) {
  const auto host = commander();
  const auto other = monitor();
  const auto tell = [&](std::uint32_t error_class, int status) {
    Frame frame = make_frame(error_class, {0, status, 0, 0, 0, 0, 0, 0});
    frame.error = true;
    ASSERT_EQ(other->send({&frame, 1}), 1U);
    EXPECT_TRUE(receive_for(*host, 10 * kMillisecond).empty());
  };
  tell(CAN_ERR_CRTL, CAN_ERR_CRTL_TX_PASSIVE);
  EXPECT_TRUE(host->state().error_passive);
  tell(CAN_ERR_BUSOFF, 0);
  EXPECT_TRUE(host->state().bus_off);
  tell(CAN_ERR_RESTARTED, 0);
  EXPECT_FALSE(host->state().bus_off);
  EXPECT_FALSE(host->state().error_passive);
  EXPECT_EQ(host->counters().error_frames, 3U);
}

// The whole reason for owning the queue: a bus that is held still and released must not replay.
TEST_F(VcanBus, AHeldBusIsSkippedAndDeliversOneCycleAtMost) {
  const auto host = commander();
  const auto drive = monitor();
  // Two frames pass, then one a second: the rest of the cycle waits.
  change("tc qdisc add dev " + name_ + " root tbf rate 128bit burst 32 limit 10000");
  EXPECT_EQ(host->send(make_cycle(0x01, 7, 1)), 7U);
  const std::int64_t end = rt::now_ns() + 300 * kMillisecond;
  int cycle = 1;
  while (rt::now_ns() < end) {
    EXPECT_EQ(host->send(make_cycle(0x01, 7, ++cycle)), 0U);
    EXPECT_TRUE(host->state().stalled);
    std::array<ReceivedFrame, 16> ignored;
    host->receive(ignored);
    ::usleep(2000);
  }
  EXPECT_EQ(host->counters().send_skipped, static_cast<std::uint64_t>(cycle - 1) * 7U);
  change("tc qdisc change dev " + name_ + " root tbf rate 1mbit burst 320 limit 10000");
  const auto got = receive(*drive, 7);
  ASSERT_EQ(got.size(), 7U);
  for (const ReceivedFrame& frame : got) {
    EXPECT_EQ(frame.frame.data[0], 1);
  }
  EXPECT_TRUE(receive_for(*drive, 20 * kMillisecond).empty());
  EXPECT_TRUE(send_when_free(*host, make_cycle(0x01, 7, 200)));
  EXPECT_FALSE(host->state().stalled);
}

// A frame lost on its way takes its confirmation with it; the host must not wait for ever.
TEST_F(VcanBus, LostFramesDoNotStopTheHost) {
  const auto host = commander();
  change("tc qdisc add dev " + name_ + " root netem loss 20%");
  for (int cycle = 0; cycle < 20; ++cycle) {
    ASSERT_TRUE(send_when_free(*host, make_cycle(0x01, 7, cycle)));
  }
}

TEST_F(VcanBus, AFullQueueFailsAndIsNotTriedAgain) {
  const auto host = commander();
  // About ten frames a second, room for few: the rest of the batch is refused with ENOBUFS.
  change("tc qdisc add dev " + name_ + " root tbf rate 2kbit burst 80 limit 160");
  const std::size_t sent = host->send(make_cycle(0x01, 8, 1));
  const BusCounters& counters = host->counters();
  std::size_t skipped_after = 0;
  for (int cycle = 2; cycle < 10; ++cycle) {
    skipped_after += host->send(make_cycle(0x01, 8, cycle)) == 0 ? 1 : 0;
  }
  EXPECT_EQ(counters.sent + counters.send_failed + counters.send_skipped, 9U * 8U);
  EXPECT_GT(skipped_after, 0U);
  EXPECT_GT(sent, 0U);
}

TEST_F(VcanBus, ALinkThatGoesDownIsSeenAndComesBack) {
  const auto host = commander();
  const auto drive = monitor();
  ASSERT_TRUE(send_when_free(*host, make_cycle(0x01, 7, 1)));
  change("ip link set " + name_ + " down");
  receive_for(*host, 5 * kMillisecond);
  EXPECT_TRUE(host->state().down);
  EXPECT_EQ(host->send(make_cycle(0x01, 7, 2)), 0U);
  EXPECT_TRUE(host->state().down);
  EXPECT_EQ(host->counters().last_errno, ENETDOWN);
  change("ip link set " + name_ + " up");
  EXPECT_TRUE(send_when_free(*host, make_cycle(0x01, 7, 3)));
  EXPECT_FALSE(host->state().down);
  std::set<int> cycles;
  for (const ReceivedFrame& frame : receive(*drive, 14)) {
    cycles.insert(frame.frame.data[0]);
  }
  EXPECT_EQ(cycles, (std::set<int>{1, 3}));
}

TEST_F(VcanBus, AFloodIsCountedAndTheQueueFindsItsWayBack) {
  const auto host = commander();
  const auto other = monitor();
  ASSERT_TRUE(send_when_free(*host, make_cycle(0x01, 7, 1)));
  const std::vector<Frame> flood = make_cycle(0x11, 8, 0);
  for (int i = 0; i < 1000; ++i) {
    other->send(flood);
  }
  host->send(make_cycle(0x01, 7, 2));  // with echo, its confirmations find the queue full
  EXPECT_FALSE(receive_for(*host, 50 * kMillisecond).empty());
  other->send(flood);  // the count of losses comes with the next frame
  receive_for(*host, 10 * kMillisecond);
  EXPECT_GT(host->counters().receive_dropped, 0U);
  EXPECT_TRUE(send_when_free(*host, make_cycle(0x01, 7, 3)));
}

TEST_F(VcanBus, ABusHasOneCommander) {
  const auto host = commander();
  const std::string text = error_text([&] { commander(); });
  EXPECT_NE(
      text.find("bus " + name_ + " is commanded already by process " + std::to_string(::getpid())),
      std::string::npos)
      << text;
  monitor();
}

TEST_F(VcanBus, RefusalsNameTheCommandThatHelps) {
  BusOptions missing = options();
  missing.interface = "vcan77";
  EXPECT_NE(error_text([&] { open_bus(missing); })
                .find("interface vcan77 does not exist (No such device); fix: ip link add dev "
                      "vcan77 type vcan && ip link set vcan77 mtu 72 up"),
            std::string::npos);
  BusOptions not_can = options();
  not_can.interface = "lo";
  EXPECT_NE(error_text([&] { open_bus(not_can); }).find("lo is not a CAN interface"),
            std::string::npos);
  BusOptions too_long = options();
  too_long.interface = "a-name-of-more-than-15";
  EXPECT_NE(error_text([&] { open_bus(too_long); }).find("no interface name"), std::string::npos);

  change("ip link set " + name_ + " down && ip link set " + name_ + " mtu 16");
  const std::string classic = error_text([&] { monitor(); });
  EXPECT_NE(classic.find("mtu 16"), std::string::npos) << classic;
  EXPECT_NE(classic.find("ip link set " + name_ + " mtu 72"), std::string::npos) << classic;
  BusOptions down = options();
  down.fd = false;
  const std::string text = error_text([&] { open_bus(down); });
  EXPECT_NE(text.find("is down; fix: ip link set " + name_ + " up"), std::string::npos) << text;
}

}  // namespace
}  // namespace geodesic::drivers
