// The socket bus: hub and clients in one process, as simulator and daemon use them in two.
#include "drivers/bus/socket_bus.hpp"

#include <linux/can/error.h>
#include <sys/socket.h>
#include <sys/stat.h>

#include <filesystem>
#include <fstream>
#include <set>
#include <thread>

#include "drivers/bus/bit_timing.hpp"
#include "drivers/bus/socket_bus_hub.hpp"
#include "tests/drivers/bus/bus_testing.hpp"

namespace geodesic::drivers {
namespace {

using testing::error_text;
using testing::eventually;
using testing::ids;
using testing::kMillisecond;
using testing::make_cycle;
using testing::make_fd_frame;
using testing::make_frame;
using testing::receive;
using testing::receive_for;
using testing::send_when_free;

namespace fs = std::filesystem;

class SocketBusTest : public ::testing::Test {
 protected:
  SocketBusTest() {
    std::string name = (fs::temp_directory_path() / "geodesic-bus-XXXXXX").string();
    folder_ = ::mkdtemp(name.data());
    path_ = (folder_ / "bus").string();
  }
  void TearDown() override { fs::remove_all(folder_); }

  void serve(bool paced = false, std::int64_t bit_rate = 1'000'000) {
    hub_.emplace(SocketBusHubOptions{.path = path_, .paced = paced, .bit_rate = bit_rate});
  }
  std::unique_ptr<Bus> monitor() { return connect({}, {}); }
  /// Commands 0x01.. and hears 0x11..
  std::unique_ptr<Bus> commander() { return connect(ids(0x11, 8), ids(0x01, 8)); }
  std::unique_ptr<Bus> connect(const std::vector<IdFilter>& in, const std::vector<IdFilter>& out) {
    BusOptions options;
    options.interface = "unix:" + path_;
    options.fd = true;
    options.receive = in;
    options.transmit = out;
    return open_bus(options);
  }

  fs::path folder_;
  std::string path_;
  std::optional<SocketBusHub> hub_;
};

TEST_F(SocketBusTest, GivesEachFrameToAllOthersWhole) {
  serve();
  const auto a = monitor();
  const auto b = monitor();
  const auto c = monitor();
  const std::vector<Frame> frames = {make_frame(0x10, {1, 2, 3}), make_fd_frame(0x20, 64)};
  EXPECT_EQ(a->send(frames), 2U);
  for (Bus* bus : {b.get(), c.get()}) {
    const auto got = receive(*bus, 2);
    ASSERT_EQ(got.size(), 2U);
    EXPECT_EQ(got[0].frame, frames[0]);
    EXPECT_EQ(got[1].frame, frames[1]);
  }
  EXPECT_TRUE(receive_for(*a, 20 * kMillisecond).empty());
  EXPECT_EQ(a->counters().sent, 2U);
  EXPECT_EQ(b->counters().received, 2U);
}

TEST_F(SocketBusTest, StampsAreMonotonicAndNow) {
  serve();
  const auto a = monitor();
  const auto b = monitor();
  std::int64_t last = rt::now_ns();
  for (int cycle = 0; cycle < 20; ++cycle) {
    const std::int64_t before = rt::now_ns();
    ASSERT_EQ(a->send(make_cycle(0x10, 3, cycle)), 3U);
    for (const ReceivedFrame& frame : receive(*b, 3)) {
      EXPECT_GE(frame.stamp_ns, before);
      EXPECT_GE(frame.stamp_ns, last);
      EXPECT_LE(frame.stamp_ns, rt::now_ns());
      last = frame.stamp_ns;
    }
  }
}

TEST_F(SocketBusTest, LetsInWhatIsNamedAndSeesForeignCommands) {
  serve();
  const auto host = commander();
  const auto other = monitor();
  const std::vector<Frame> frames = {make_frame(0x11), make_frame(0x300), make_frame(0x02)};
  other->send(frames);
  const auto got = receive(*host, 1);
  ASSERT_EQ(got.size(), 1U);
  EXPECT_EQ(got[0].frame.id, 0x11U);
  EXPECT_TRUE(eventually([&] {
    receive_for(*host, kMillisecond);
    return host->counters().foreign_commands == 1;
  }));
  EXPECT_TRUE(host->state().foreign_commander);
}

TEST_F(SocketBusTest, OwnCommandsAreNotForeignAndNeverShow) {
  serve();
  const auto host = commander();
  for (int cycle = 0; cycle < 50; ++cycle) {
    ASSERT_TRUE(send_when_free(*host, make_cycle(0x01, 8, cycle)));
  }
  EXPECT_TRUE(receive_for(*host, 20 * kMillisecond).empty());
  EXPECT_FALSE(host->state().foreign_commander);
  EXPECT_EQ(host->counters().sent, 400U);
}

TEST_F(SocketBusTest, WaitingFramesLeaveInOrderOfIdentifier) {
  serve();
  const auto a = monitor();
  const auto b = monitor();
  const auto reader = monitor();
  hub_->hold(true);
  Frame extended = make_frame(0x100U << 18);
  extended.extended = true;
  const std::vector<Frame> first = {make_frame(0x300), extended, make_frame(0x010)};
  const std::vector<Frame> second = {make_frame(0x100), make_frame(0x200, {1}),
                                     make_frame(0x200, {2})};
  a->send(first);
  b->send(second);
  ::usleep(50'000);
  hub_->hold(false);
  const auto got = receive(*reader, 6);
  ASSERT_EQ(got.size(), 6U);
  const std::vector<Frame> expected = {first[2],  second[0], first[1],
                                       second[1], second[2], first[0]};
  for (std::size_t i = 0; i < expected.size(); ++i) {
    EXPECT_EQ(got[i].frame, expected[i]) << i;
  }
}

TEST_F(SocketBusTest, PacedFramesTakeTheirBitTime) {
  serve(true);
  const auto a = monitor();
  const auto b = monitor();
  std::vector<Frame> frames = make_cycle(0x10, 10, 3);
  frames.push_back(make_fd_frame(0x40, 64));
  a->send(frames);
  const auto got = receive(*b, frames.size());
  ASSERT_EQ(got.size(), frames.size());
  for (std::size_t i = 1; i < got.size(); ++i) {
    EXPECT_EQ(got[i].stamp_ns - got[i - 1].stamp_ns,
              frame_time_ns(got[i].frame, 1'000'000, 5'000'000));
  }
}

TEST_F(SocketBusTest, ABusHeldForAMomentIsSkippedAndDeliversOneCycleAtMost) {
  serve();
  const auto host = commander();
  const auto drive = monitor();
  hub_->hold(true);
  EXPECT_EQ(host->send(make_cycle(0x01, 8, 1)), 8U);
  for (int cycle = 2; cycle <= 50; ++cycle) {
    EXPECT_EQ(host->send(make_cycle(0x01, 8, cycle)), 0U);
    EXPECT_TRUE(host->state().stalled);
  }
  EXPECT_EQ(host->counters().send_skipped, 49U * 8U);
  hub_->hold(false);
  const auto got = receive(*drive, 8, 200 * kMillisecond);
  EXPECT_TRUE(got.empty() || got.size() == 8U);  // empty: this machine stood still meanwhile
  for (const ReceivedFrame& frame : got) {
    EXPECT_EQ(frame.frame.data[0], 1);
  }
  EXPECT_TRUE(send_when_free(*host, make_cycle(0x01, 8, 51)));
  EXPECT_FALSE(host->state().stalled);
  EXPECT_EQ(receive(*drive, 8).size(), 8U);
}

TEST_F(SocketBusTest, ASlowBusKeepsOneCycleUnderWay) {
  serve(true, 20'000);  // 8 frames take about 30 ms
  BusOptions options;
  options.interface = "unix:" + path_;
  options.bit_rate = 20'000;
  options.receive = ids(0x11, 8);
  options.transmit = ids(0x01, 8);
  const auto host = open_bus(options);
  const auto drive = monitor();
  int cycle = 0;
  const std::int64_t end = rt::now_ns() + 200 * kMillisecond;
  while (rt::now_ns() < end) {
    host->send(make_cycle(0x01, 8, ++cycle));
    ::usleep(1000);
  }
  EXPECT_GT(host->counters().send_skipped, 8U * 10U);
  EXPECT_LE(host->counters().sent, 8U * 9U);
  EXPECT_EQ(host->counters().send_failed, 0U);
  EXPECT_EQ(receive(*drive, host->counters().sent).size(), host->counters().sent);
}

TEST_F(SocketBusTest, ErrorFramesTellTheState) {
  serve();
  const auto host = commander();
  const auto other = monitor();
  Frame bus_off = make_frame(CAN_ERR_BUSOFF, {0, 0, 0, 0, 0, 0, 0, 0});
  bus_off.error = true;
  other->send({&bus_off, 1});
  EXPECT_TRUE(eventually([&] {
    receive_for(*host, kMillisecond);
    return host->state().bus_off;
  }));
  Frame restarted = bus_off;
  restarted.id = CAN_ERR_RESTARTED;
  other->send({&restarted, 1});
  EXPECT_TRUE(eventually([&] {
    receive_for(*host, kMillisecond);
    return !host->state().bus_off;
  }));
  EXPECT_EQ(host->counters().error_frames, 2U);
}

TEST_F(SocketBusTest, ABusHasOneCommander) {
  serve();
  const auto host = commander();
  const std::string text = error_text([&] { commander(); });
  EXPECT_NE(text.find("commanded already by process " + std::to_string(::getpid())),
            std::string::npos)
      << text;
  monitor();  // who only listens may
}

TEST_F(SocketBusTest, TheHubsEndIsSeenAndANewOneIsFound) {
  serve();
  const auto host = commander();
  hub_.reset();
  EXPECT_FALSE(fs::exists(path_));
  EXPECT_TRUE(eventually([&] {
    receive_for(*host, kMillisecond);
    return host->state().down;
  }));
  pollfd polled{.fd = host->descriptor(), .events = POLLIN, .revents = 0};
  EXPECT_EQ(::poll(&polled, 1, 0), 0) << "a dead bus must not keep its reader awake";
  EXPECT_EQ(host->send(make_cycle(0x01, 8, 1)), 0U);
  EXPECT_EQ(host->counters().send_failed, 8U);
  serve();
  EXPECT_TRUE(send_when_free(*host, make_cycle(0x01, 8, 2)));
  EXPECT_FALSE(host->state().down);
}

TEST_F(SocketBusTest, ATendedBusIsConnectedAgainByWhoTendsAlone) {
  serve();
  const auto host = commander();
  host->tend();
  const int descriptor = host->descriptor();
  for (int round = 0; round < 3; ++round) {
    hub_.reset();
    EXPECT_TRUE(eventually([&] {
      receive_for(*host, kMillisecond);
      return host->state().down;
    }));
    serve();
    for (int i = 0; i < 200; ++i) {  // however often: a sealed thread could not connect
      EXPECT_EQ(host->send(make_cycle(0x01, 8, 1)), 0U);
    }
    EXPECT_TRUE(host->state().down);
    EXPECT_TRUE(eventually([&] {
      host->tend();
      return host->send(make_cycle(0x01, 8, 2)) > 0;
    }));
    EXPECT_FALSE(host->state().down);
    EXPECT_EQ(host->descriptor(), descriptor);
  }
}

TEST_F(SocketBusTest, NobodyServing) {
  BusOptions options;
  options.interface = "unix:" + path_;
  const std::string text = error_text([&] { open_bus(options); });
  EXPECT_NE(text.find("geodesic bus unix:" + path_), std::string::npos) << text;
  options.interface = "unix:/" + std::string(200, 'x');
  EXPECT_NE(error_text([&] { open_bus(options); }).find("107 bytes"), std::string::npos);
  EXPECT_FALSE(socket_bus_served(path_));
}

TEST_F(SocketBusTest, APathHasOneHubAndADeadOnesFileIsReplaced) {
  serve();
  EXPECT_TRUE(socket_bus_served("unix:" + path_));
  EXPECT_NE(error_text([&] {
              SocketBusHub(SocketBusHubOptions{.path = path_});
            }).find("another hub serves it already"),
            std::string::npos);
  EXPECT_TRUE(socket_bus_served(path_)) << "the refused hub must leave the other's file alone";
  hub_.reset();

  const int dead = ::socket(AF_UNIX, SOCK_SEQPACKET, 0);
  const auto address = UnixAddress::path(path_);
  ASSERT_EQ(::bind(dead, address->get(), address->size()), 0);
  ::close(dead);
  ASSERT_TRUE(fs::exists(path_));
  serve();
  EXPECT_TRUE(socket_bus_served(path_));
}

TEST_F(SocketBusTest, OtherFilesAndMissingFoldersAreRefused) {
  std::ofstream(path_) << "mine";
  EXPECT_NE(error_text([&] { serve(); }).find("not a socket"), std::string::npos);
  EXPECT_TRUE(fs::exists(path_));
  path_ = (folder_ / "missing" / "bus").string();
  EXPECT_NE(error_text([&] { serve(); }).find("mkdir -p"), std::string::npos);
}

TEST_F(SocketBusTest, AStrangerWhoSpeaksSomethingElseIsShownTheDoor) {
  serve();
  const auto a = monitor();
  const auto b = monitor();
  const int stranger = ::socket(AF_UNIX, SOCK_SEQPACKET, 0);
  const auto address = UnixAddress::path(path_);
  ASSERT_EQ(::connect(stranger, address->get(), address->size()), 0);
  ASSERT_GT(::send(stranger, "hello", 5, MSG_NOSIGNAL), 0);
  char byte = 0;
  EXPECT_LE(::recv(stranger, &byte, 1, 0), 0);
  ::close(stranger);
  a->send(make_cycle(0x10, 1, 0));
  EXPECT_EQ(receive(*b, 1).size(), 1U);
}

TEST_F(SocketBusTest, AClientThatDoesNotReadLosesFramesAndIsTold) {
  serve();
  const auto sleeper = commander();
  const auto other = monitor();
  for (int cycle = 0; cycle < 5000; ++cycle) {
    ASSERT_TRUE(send_when_free(*other, make_cycle(0x11, 8, cycle)));
  }
  EXPECT_TRUE(eventually([&] { return hub_->counters().dropped > 0; }));
  // Its own frames' confirmations are lost in the flood; it must find its way back.
  sleeper->send(make_cycle(0x01, 8, 0));
  EXPECT_TRUE(eventually([&] {
    receive_for(*sleeper, kMillisecond);
    return sleeper->counters().receive_dropped > 0;
  }));
  EXPECT_TRUE(send_when_free(*sleeper, make_cycle(0x01, 8, 1)));
}

TEST_F(SocketBusTest, RefusesWhatIsNoCanFrame) {
  serve();
  const auto host = commander();
  Frame odd = make_fd_frame(0x01, 64);
  odd.length = 13;
  EXPECT_EQ(host->send({&odd, 1}), 0U);
  EXPECT_EQ(host->counters().send_failed, 1U);
  EXPECT_EQ(host->counters().last_errno, EINVAL);
}

TEST_F(SocketBusTest, ReceiveIsBoundedByTheCallersRoom) {
  serve();
  const auto a = monitor();
  const auto b = monitor();
  a->send(make_cycle(0x10, 40, 0));
  ASSERT_TRUE(eventually([&] { return hub_->counters().carried == 40; }));
  std::array<ReceivedFrame, 16> out;
  std::size_t total = 0;
  EXPECT_TRUE(eventually([&] {
    const std::size_t n = b->receive(out);
    total += n;
    return total == 40;
  }));
}

TEST_F(SocketBusTest, SleepsWhileAClientThatHungUpCannotBeReadYet) {
  serve();
  auto flooder = monitor();
  hub_->hold(true);
  std::vector<Frame> batch(Bus::kMaxBatch, make_frame(0x300));
  for (int i = 0; i < 40; ++i) flooder->send(batch);  // more than the hub lets wait
  flooder.reset();
  const auto busy_ns = [] {
    timespec used{};
    ::clock_gettime(CLOCK_PROCESS_CPUTIME_ID, &used);
    return used.tv_sec * std::int64_t{1'000'000'000} + used.tv_nsec;
  };
  std::this_thread::sleep_for(std::chrono::milliseconds(100));
  const std::int64_t before = busy_ns();
  std::this_thread::sleep_for(std::chrono::milliseconds(400));
  EXPECT_LT(busy_ns() - before, 20 * kMillisecond) << "the hub spins";
  hub_->hold(false);
  EXPECT_TRUE(eventually([&] { return hub_->counters().clients == 0; }));
}

}  // namespace
}  // namespace geodesic::drivers
