// The parts of a bus that need no socket: books, error frames, stamps, arbitration, wire format.
#include "drivers/bus/traffic.hpp"

#include <linux/can/error.h>

#include <memory>
#include <random>

#include "drivers/bus/arbitration.hpp"
#include "drivers/bus/can_frame.hpp"
#include "drivers/bus/error_frame.hpp"
#include "drivers/bus/socket_bus_wire.hpp"
#include "drivers/bus/stamp_clock.hpp"
#include "drivers/bus/unix_address.hpp"
#include "tests/drivers/bus/bus_testing.hpp"

namespace geodesic::drivers {
namespace {

using testing::ids;
using testing::make_fd_frame;
using testing::make_frame;

Frame error_frame(std::uint32_t error_class, int status = 0) {
  Frame frame = make_frame(error_class, {0, status, 0, 0, 0, 0, 0, 0});
  frame.error = true;
  frame.extended = true;
  return frame;
}

BusOptions commander() {
  BusOptions options;
  options.receive = ids(0x11, 4);
  options.transmit = ids(0x01, 4);
  return options;
}

TEST(Traffic, KeepsWhatIsWantedAndTellsForeignCommandsApart) {
  Traffic traffic(commander(), 16);
  traffic.arrived(make_frame(0x11), 10);
  traffic.arrived(make_frame(0x01), 20);
  traffic.arrived(make_frame(0x300), 30);
  std::array<ReceivedFrame, 4> out;
  ASSERT_EQ(traffic.take(out), 1U);
  EXPECT_EQ(out[0].frame.id, 0x11U);
  EXPECT_EQ(out[0].stamp_ns, 10);
  EXPECT_EQ(traffic.counters().foreign_commands, 1U);
  EXPECT_EQ(traffic.counters().received, 1U);
  EXPECT_TRUE(traffic.state().foreign_commander);
}

TEST(Traffic, ForgetsAForeignCommanderWhoHasBeenSilentForASecond) {
  Traffic traffic(commander(), 16);
  traffic.arrived(make_frame(0x01), 1'000);
  traffic.begin_send(999'000'000);
  EXPECT_TRUE(traffic.state().foreign_commander);
  traffic.begin_send(1'000'002'000);
  EXPECT_FALSE(traffic.state().foreign_commander);
}

TEST(Traffic, ADriveMayAnswerOnTheIdentifierItIsCommandedBy) {
  BusOptions options = commander();
  options.receive = options.transmit;
  Traffic traffic(options, 16);
  traffic.arrived(make_frame(0x01), 10);
  EXPECT_FALSE(traffic.state().foreign_commander);
  EXPECT_EQ(traffic.counters().received, 1U);
}

TEST(Traffic, ExtendedAndStandardIdentifiersAreDifferent) {
  BusOptions options;
  options.receive = {{.id = 0x11, .extended = true}};
  Traffic traffic(options, 16);
  traffic.arrived(make_frame(0x11), 10);
  Frame extended = make_frame(0x11);
  extended.extended = true;
  traffic.arrived(extended, 20);
  std::array<ReceivedFrame, 4> out;
  ASSERT_EQ(traffic.take(out), 1U);
  EXPECT_TRUE(out[0].frame.extended);
}

TEST(Traffic, HoldsABoundedNumberOfFrames) {
  BusOptions monitor;
  Traffic traffic(monitor, 4);
  for (std::uint32_t i = 0; i < 6; ++i) {
    traffic.arrived(make_frame(i), 0);
  }
  EXPECT_EQ(traffic.room(), 0U);
  EXPECT_EQ(traffic.counters().receive_dropped, 2U);
  std::array<ReceivedFrame, 3> out;
  EXPECT_EQ(traffic.take(out), 3U);
  EXPECT_EQ(out[2].frame.id, 2U);
  EXPECT_EQ(traffic.room(), 3U);
}

TEST(Traffic, CountsWhatIsUnderWay) {
  Traffic traffic(commander(), 16);
  traffic.handed_over(4, 4, 4, 100);
  EXPECT_EQ(traffic.in_flight(), 4U);
  traffic.confirmed();
  EXPECT_EQ(traffic.in_flight(), 3U);
  traffic.skipped(4);
  EXPECT_TRUE(traffic.state().stalled);
  EXPECT_EQ(traffic.counters().send_skipped, 4U);
  traffic.confirmed();
  traffic.confirmed();
  traffic.confirmed();
  traffic.confirmed();  // one too many changes nothing
  EXPECT_EQ(traffic.in_flight(), 0U);
  traffic.handed_over(2, 4, 2, 200);
  EXPECT_FALSE(traffic.state().stalled);
  EXPECT_EQ(traffic.counters().sent, 6U);
  EXPECT_EQ(traffic.counters().send_failed, 2U);
}

TEST(Traffic, DoubtsAnUnconfirmedCycleOnceOnly) {
  Traffic traffic(commander(), 16);
  traffic.handed_over(4, 4, 4, 100);
  EXPECT_TRUE(traffic.doubt_in_flight());
  EXPECT_EQ(traffic.in_flight(), 0U);
  traffic.handed_over(4, 4, 4, 200);
  EXPECT_FALSE(traffic.doubt_in_flight());
  EXPECT_EQ(traffic.in_flight(), 4U);
  traffic.confirmed();  // the bus moves
  EXPECT_TRUE(traffic.doubt_in_flight());
}

TEST(Traffic, ConfirmationsOfAForgottenCycleAreNotTakenForTheNextOnes) {
  Traffic traffic(commander(), 16);
  traffic.handed_over(2, 2, 2, 100);
  ASSERT_TRUE(traffic.doubt_in_flight());
  traffic.handed_over(2, 2, 2, 200);
  traffic.confirmed();  // the held frames leave after all, first in first out
  traffic.confirmed();
  EXPECT_EQ(traffic.in_flight(), 2U) << "a third cycle would go behind the second";
  traffic.confirmed();
  traffic.confirmed();
  EXPECT_EQ(traffic.in_flight(), 0U);
}

TEST(Traffic, LostConfirmationsDelayOneCycleMoreAndNoOtherAfterIt) {
  Traffic traffic(commander(), 16);
  traffic.handed_over(2, 2, 2, 100);
  traffic.confirmed();  // the other one is lost
  ASSERT_TRUE(traffic.doubt_in_flight());
  traffic.handed_over(2, 2, 2, 200);
  traffic.confirmed();
  traffic.confirmed();
  EXPECT_EQ(traffic.in_flight(), 1U);
  ASSERT_TRUE(traffic.doubt_in_flight());
  for (int cycle = 3; cycle < 10; ++cycle) {
    traffic.handed_over(2, 2, 2, cycle * 100);
    traffic.confirmed();
    traffic.confirmed();
    EXPECT_EQ(traffic.in_flight(), 0U) << cycle;
  }
}

TEST(Traffic, ABusOffEndsWhenAFrameHandedOverAfterItHasLeft) {
  Traffic traffic(commander(), 16);
  traffic.handed_over(1, 1, 1, 100);
  traffic.arrived(error_frame(CAN_ERR_BUSOFF), 150);
  traffic.confirmed();  // handed over before
  EXPECT_TRUE(traffic.state().bus_off);
  traffic.handed_over(1, 1, 1, 200);
  EXPECT_TRUE(traffic.state().bus_off);
  traffic.confirmed();
  EXPECT_FALSE(traffic.state().bus_off);
}

TEST(Traffic, FramesThatHadWaitedDoNotBringALinkUp) {
  Traffic traffic(commander(), 16);
  traffic.went_down(1000);
  traffic.arrived(make_frame(0x11), 900);
  EXPECT_TRUE(traffic.state().down);
  traffic.arrived(make_frame(0x11), 1100);
  EXPECT_FALSE(traffic.state().down);
}

TEST(ErrorFrame, BusOffUntilRestarted) {
  control::BusState state;
  EXPECT_FALSE(apply_error_frame(error_frame(CAN_ERR_BUSOFF), state));
  EXPECT_TRUE(state.bus_off);
  EXPECT_TRUE(apply_error_frame(error_frame(CAN_ERR_RESTARTED), state));
  EXPECT_FALSE(state.bus_off);
}

TEST(ErrorFrame, PassiveUntilBetter) {
  for (const int passive : {CAN_ERR_CRTL_RX_PASSIVE, CAN_ERR_CRTL_TX_PASSIVE}) {
    for (const int better :
         {CAN_ERR_CRTL_ACTIVE, CAN_ERR_CRTL_RX_WARNING, CAN_ERR_CRTL_TX_WARNING}) {
      control::BusState state;
      apply_error_frame(error_frame(CAN_ERR_CRTL, passive), state);
      EXPECT_TRUE(state.error_passive);
      apply_error_frame(error_frame(CAN_ERR_CRTL, CAN_ERR_CRTL_RX_OVERFLOW), state);
      EXPECT_TRUE(state.error_passive);
      apply_error_frame(error_frame(CAN_ERR_CRTL, better), state);
      EXPECT_FALSE(state.error_passive);
    }
  }
}

TEST(ErrorFrame, ShowsToMonitorsAloneAndNeverAsAnElevenBitIdentifier) {
  BusOptions monitor;
  Traffic seen(monitor, 4);
  Traffic unseen(commander(), 4);
  canfd_frame raw{};
  encode_can_frame(error_frame(CAN_ERR_CRTL, CAN_ERR_CRTL_TX_PASSIVE), raw);
  Frame decoded;
  ASSERT_TRUE(decode_can_frame(raw, CAN_MTU, decoded));
  EXPECT_TRUE(decoded.error);
  EXPECT_TRUE(decoded.extended);
  seen.arrived(decoded, 1);
  unseen.arrived(decoded, 1);
  EXPECT_EQ(seen.room(), 3U);
  EXPECT_EQ(unseen.room(), 4U);
  EXPECT_TRUE(unseen.state().error_passive);
  EXPECT_EQ(unseen.counters().error_frames, 1U);
  EXPECT_EQ(unseen.counters().received, 0U);
}

TEST(CanFrame, SurvivesTheKernelsForm) {
  Frame extended = make_frame(0x1ABCDEF0, {1, 2, 3});
  extended.extended = true;
  for (const Frame& frame : {make_frame(0x7FF, {9, 8, 7, 6, 5, 4, 3, 2}), extended,
                             make_fd_frame(0x123, 64), make_fd_frame(0x7, 0)}) {
    canfd_frame raw{};
    const std::size_t bytes = encode_can_frame(frame, raw);
    EXPECT_EQ(bytes, frame.fd ? CANFD_MTU : CAN_MTU);
    Frame back;
    ASSERT_TRUE(decode_can_frame(raw, bytes, back));
    EXPECT_EQ(back, frame);
  }
  canfd_frame raw{};
  raw.can_id = CAN_RTR_FLAG | 5U;
  raw.len = 8;
  Frame remote;
  ASSERT_TRUE(decode_can_frame(raw, CAN_MTU, remote));
  EXPECT_TRUE(remote.remote);
  EXPECT_EQ(remote.id, 5U);
  EXPECT_EQ(remote.length, 8);
  canfd_frame again{};
  remote.data[0] = 9;  // carries none
  EXPECT_EQ(encode_can_frame(remote, again), CAN_MTU);
  EXPECT_EQ(again.can_id, raw.can_id);
  EXPECT_EQ(again.len, 8);
  EXPECT_EQ(again.data[0], 0);
  EXPECT_FALSE(decode_can_frame(raw, 3, remote));
}

TEST(StampClock, AgeIsTakenFromTheWallClock) {
  StampClock clock;
  clock.read(1'000'000, 77'000'000);
  clock.emptied();
  clock.read(2'000'000, 78'000'000);
  EXPECT_EQ(clock.monotonic(77'900'000), 1'900'000);
}

TEST(StampClock, AStepOfTheWallClockMovesAStampNoFurtherThanTheLastRead) {
  StampClock clock;
  clock.read(1'000'000, 77'000'000);
  clock.emptied();
  constexpr std::int64_t kHour = 3'600'000'000'000;
  clock.read(2'000'000, 78'000'000 + kHour);  // forward: the frame seems an hour old
  EXPECT_EQ(clock.monotonic(77'900'000), 1'000'000);
  clock.read(2'000'000, 78'000'000 - kHour);  // backward: it seems to come from the future
  EXPECT_EQ(clock.monotonic(77'900'000), 2'000'000);
}

TEST(Arbitration, LowerIdentifiersWinAndStandardOnesBeforeExtendedOfTheSameBase) {
  Frame extended = make_frame(0x100U << 18);
  extended.extended = true;
  Frame later = extended;
  later.id += 1;
  EXPECT_LT(arbitration_key(make_frame(0x0FF)), arbitration_key(make_frame(0x100)));
  EXPECT_LT(arbitration_key(make_frame(0x100)), arbitration_key(extended));
  EXPECT_LT(arbitration_key(extended), arbitration_key(later));
  EXPECT_LT(arbitration_key(later), arbitration_key(make_frame(0x101)));
  Frame remote = make_frame(0x100);
  remote.remote = true;
  EXPECT_LT(arbitration_key(make_frame(0x100)), arbitration_key(remote));
  EXPECT_LT(arbitration_key(remote), arbitration_key(extended));
  Frame remote_extended = extended;
  remote_extended.remote = true;
  EXPECT_LT(arbitration_key(extended), arbitration_key(remote_extended));
  EXPECT_LT(arbitration_key(remote_extended), arbitration_key(later));
}

TEST(Traffic, ARemoteFrameIsNoAnswer) {
  Frame remote = make_frame(0x11);
  remote.remote = true;
  remote.length = 8;
  Traffic host(commander(), 16);
  host.arrived(remote, 10);
  EXPECT_EQ(host.counters().received, 0U);
  BusOptions drive;  // a simulated one
  drive.receive = ids(0x11, 1);
  Traffic asked(drive, 16);
  asked.arrived(remote, 10);
  EXPECT_EQ(asked.counters().received, 1U);
}

TEST(Traffic, APurgeForgetsWhatWasUnderWayAndTheControllersTroubles) {
  Traffic traffic(commander(), 16);
  traffic.handed_over(4, 4, 4, 100);
  traffic.arrived(error_frame(CAN_ERR_BUSOFF), 150);
  traffic.purged();
  EXPECT_EQ(traffic.in_flight(), 0U);
  EXPECT_FALSE(traffic.state().bus_off);
}

TEST(Traffic, PatienceGrowsWithTheBitsUnderWay) {
  BusOptions slow = commander();
  slow.bit_rate = 10'000;
  Traffic traffic(slow, 16);
  traffic.handed_over(4, 4, 4, 100);
  EXPECT_GT(traffic.patience_ns(), 4 * 15'000'000);  // 4 frames take over 40 ms
  Traffic fast(commander(), 16);
  fast.handed_over(4, 4, 4, 100);
  EXPECT_LT(fast.patience_ns(), 17'000'000);
}

TEST(SocketBusWire, CarriesABatchWhole) {
  auto writer = std::make_unique<WireWriter>();
  Frame extended = make_frame(0x1ABCDEF0, {1, 2, 3});
  extended.extended = true;
  const std::vector<Frame> frames = {make_frame(1, {1}), extended, make_fd_frame(0x55, 64)};
  for (const Frame& frame : frames) {
    writer->add(frame, 42);
  }
  writer->add_confirmation(43);
  WireReader reader(writer->finish(0, 7));
  ASSERT_TRUE(reader.valid());
  EXPECT_EQ(reader.header().dropped, 7U);
  WireReader::Item item;
  for (const Frame& frame : frames) {
    ASSERT_TRUE(reader.next(item));
    EXPECT_EQ(item.frame, frame);
    EXPECT_EQ(item.stamp_ns, 42);
    EXPECT_FALSE(item.confirmation);
  }
  ASSERT_TRUE(reader.next(item));
  EXPECT_TRUE(item.confirmation);
  EXPECT_FALSE(reader.next(item));
}

TEST(SocketBusWire, SurvivesAnyBytes) {
  std::mt19937 random(3);
  for (int round = 0; round < 20000; ++round) {
    std::vector<std::byte> bytes(random() % 300);
    for (std::byte& byte : bytes) {
      byte = static_cast<std::byte>(random());
    }
    WireMessageHeader header;
    header.frames = static_cast<std::uint16_t>(random());
    if (bytes.size() >= sizeof header && round % 2 == 0) {
      std::memcpy(bytes.data(), &header, sizeof header);
    }
    WireReader reader(bytes);
    WireReader::Item item;
    int items = 0;
    while (reader.next(item)) {
      EXPECT_LE(item.frame.length, 64);
      ++items;
    }
    EXPECT_LT(items, 20);
  }
}

TEST(UnixAddress, LongNamesFitAndStayDifferent) {
  const std::string base(200, 'x');
  const UnixAddress one = UnixAddress::abstract(base + "1");
  const UnixAddress two = UnixAddress::abstract(base + "2");
  ASSERT_LE(one.size(), sizeof(sockaddr_un));
  EXPECT_NE(std::memcmp(one.get(), two.get(), one.size()), 0);
  EXPECT_FALSE(UnixAddress::path(base).has_value());
  EXPECT_FALSE(UnixAddress::path("").has_value());
  EXPECT_EQ(socket_bus_path("unix:/tmp/a"), "/tmp/a");
  EXPECT_FALSE(is_socket_bus("can0"));
}

}  // namespace
}  // namespace geodesic::drivers
