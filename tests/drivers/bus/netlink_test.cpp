// Netlink messages: ours against those that iproute2 sends for the same wish, the kernel's as it
// sent them, and bytes that make no sense.
#include <linux/can/netlink.h>
#include <linux/rtnetlink.h>

#include <map>
#include <random>

#include "drivers/bus/can_link.hpp"
#include "tests/drivers/bus/bus_testing.hpp"
#include "tests/drivers/bus/recorded_links.hpp"

namespace geodesic::drivers {
namespace {

std::vector<std::byte> bytes_of(std::string_view hex) {
  std::vector<std::byte> bytes;
  for (std::size_t i = 0; i + 1 < hex.size(); i += 2) {
    bytes.push_back(static_cast<std::byte>(std::stoi(std::string(hex.substr(i, 2)), nullptr, 16)));
  }
  return bytes;
}

std::string hex_of(std::span<const std::byte> bytes) {
  std::string hex;
  for (const std::byte byte : bytes) {
    constexpr std::string_view kDigits = "0123456789abcdef";
    hex += kDigits[std::to_integer<std::size_t>(byte) >> 4];
    hex += kDigits[std::to_integer<std::size_t>(byte) & 15];
  }
  return hex;
}

using Leaves = std::map<std::string, std::string>;

/// Attributes by their path of types; their order means nothing.
void add_leaves(std::span<const std::byte> bytes, const std::string& path, Leaves& leaves) {
  for (const NetlinkAttribute& item : netlink_attributes(bytes)) {
    const std::string here = path + "/" + std::to_string(item.type);
    const bool nest = here == "/18" || here == "/18/2";  // IFLA_LINKINFO, IFLA_INFO_DATA
    if (nest) {
      add_leaves(item.data, here, leaves);
    } else if (here == "/18/1") {
      leaves[here] = item.text();  // iproute2 sends no NUL, nor is one asked for
    } else {
      leaves[here] = hex_of(item.data);
    }
  }
}

Leaves leaves_of(std::span<const std::byte> bytes) {
  Leaves leaves;
  const auto messages = netlink_messages(bytes);
  EXPECT_EQ(messages.size(), 1U);
  if (messages.empty() || messages.front().body.size() < sizeof(ifinfomsg)) return leaves;
  leaves["type"] = std::to_string(messages[0].header.nlmsg_type);
  leaves["flags"] = std::to_string(messages[0].header.nlmsg_flags);
  leaves["head"] = hex_of(messages[0].body.first(sizeof(ifinfomsg)));
  add_leaves(messages[0].body.subspan(sizeof(ifinfomsg)), "", leaves);
  return leaves;
}

// Recorded from iproute2 6.1 (`ip link set lo ...`, index 1).
TEST(Netlink, SetsUpAsIproute2Does) {
  LinkChange change;
  change.up = true;
  change.queue = 64;
  change.bit_rate = 1'000'000;
  change.sample_point = 0.8;
  change.data_bit_rate = 5'000'000;
  change.data_sample_point = 0.75;
  change.fd = true;
  change.restart_ms = 100;
  // txqueuelen 64 up type can bitrate 1000000 sample-point 0.800 dbitrate 5000000
  // dsample-point 0.750 fd on restart-ms 100
  EXPECT_EQ(
      leaves_of(change_link_message(1, change, 7)),
      leaves_of(bytes_of("94000000100005009b99036b00000000000000000100000001000000010000000800"
                         "0d00400000006c0012000700010063616e0060000200080006006400000024000100"
                         "40420f00200300000000000000000000000000000000000000000000000000002400"
                         "0900404b4c00ee0200000000000000000000000000000000000000000000000000000"
                         "c0005002000000020000000")));
  // up type can bitrate 500000 restart-ms 0
  LinkChange slow;
  slow.up = true;
  slow.bit_rate = 500'000;
  slow.restart_ms = 0;
  EXPECT_EQ(
      leaves_of(change_link_message(1, slow, 7)),
      leaves_of(bytes_of("5c000000100005009b99036b00000000000000000100000001000000010000003c00"
                         "12000700010063616e003000020008000600000000002400010020a1070000000000"
                         "000000000000000000000000000000000000000000000000")));
  LinkChange down;
  down.up = false;
  EXPECT_EQ(
      leaves_of(change_link_message(1, down, 7)),
      leaves_of(bytes_of("20000000100005009b99036b0000000000000000010000000000000001000000")));
}

TEST(Netlink, ReadsAControllerAsTheKernelTellsOfIt) {
  const auto bytes = bytes_of(kRecordedKvaser);
  const auto messages = netlink_messages(bytes);
  ASSERT_EQ(messages.size(), 1U);
  const auto link = parse_can_link(messages[0]);
  ASSERT_TRUE(link.has_value());
  EXPECT_EQ(link->name, "can0");
  EXPECT_EQ(link->kind, "can");
  EXPECT_TRUE(link->can);
  EXPECT_TRUE(link->up);
  EXPECT_TRUE(link->echoes);
  EXPECT_FALSE(link->fd);
  EXPECT_EQ(link->mtu, 16);
  EXPECT_EQ(link->queue, 64);
  EXPECT_EQ(link->nominal.bit_rate, 1'000'000);
  ASSERT_TRUE(link->nominal.sample_point.has_value());
  EXPECT_NEAR(*link->nominal.sample_point, 0.75, 1e-9);
  EXPECT_FALSE(link->data.bit_rate.has_value());
  EXPECT_EQ(link->restart_ms, 100);
  ASSERT_TRUE(link->has_controller());
  EXPECT_EQ(link->controller->state, ControllerState::kActive);
}

TEST(Netlink, ReadsAVirtualInterfaceAsTheKernelTellsOfIt) {
  const auto bytes = bytes_of(kRecordedVcan);
  const auto messages = netlink_messages(bytes);
  ASSERT_EQ(messages.size(), 1U);
  const auto link = parse_can_link(messages[0]);
  ASSERT_TRUE(link.has_value());
  EXPECT_EQ(link->name, "vcan0");
  EXPECT_EQ(link->kind, "vcan");
  EXPECT_TRUE(link->can && link->up && link->fd);
  EXPECT_FALSE(link->echoes);
  EXPECT_FALSE(link->has_controller());
  EXPECT_FALSE(link->nominal.bit_rate.has_value());
  EXPECT_FALSE(link->restart_ms.has_value());
  EXPECT_EQ(link->mtu, 72);
}

/// A link message put together attribute by attribute.
std::optional<CanLink> link_with(const std::function<void(NetlinkWriter&)>& controller,
                                 unsigned flags = 1) {
  NetlinkWriter writer(RTM_NEWLINK, 0, 1);
  ifinfomsg info{};
  info.ifi_index = 4;
  info.ifi_type = 280;
  info.ifi_flags = flags;
  writer.fixed(info);
  writer.text(IFLA_IFNAME, "can3");
  const std::size_t kind = writer.begin_nest(IFLA_LINKINFO | NLA_F_NESTED);
  writer.text(IFLA_INFO_KIND, "can");
  can_device_stats stats{};
  stats.bus_off = 3;
  stats.restarts = 2;
  stats.error_passive = 5;
  writer.attribute(IFLA_INFO_XSTATS, stats);
  const std::size_t data = writer.begin_nest(IFLA_INFO_DATA | NLA_F_NESTED);
  controller(writer);
  writer.end_nest(data);
  writer.end_nest(kind);
  return parse_can_link(netlink_messages(writer.finish()).at(0));
}

TEST(Netlink, ReadsStatesCountersAndFd) {
  const std::map<std::uint32_t, ControllerState> states{
      {CAN_STATE_ERROR_ACTIVE, ControllerState::kActive},
      {CAN_STATE_ERROR_WARNING, ControllerState::kWarning},
      {CAN_STATE_ERROR_PASSIVE, ControllerState::kPassive},
      {CAN_STATE_BUS_OFF, ControllerState::kBusOff},
      {CAN_STATE_STOPPED, ControllerState::kStopped},
      {CAN_STATE_SLEEPING, ControllerState::kStopped},
      {99, ControllerState::kUnknown}};
  for (const auto& [code, state] : states) {
    const auto link = link_with([code = code](NetlinkWriter& writer) {
      writer.attribute(IFLA_CAN_STATE, code);
      writer.attribute(IFLA_CAN_BERR_COUNTER, can_berr_counter{128, 17});
      writer.attribute(IFLA_CAN_CTRLMODE, can_ctrlmode{0, CAN_CTRLMODE_FD | CAN_CTRLMODE_ONE_SHOT});
      can_bittiming timing{};
      timing.bitrate = 5'000'000;
      timing.sample_point = 800;
      writer.attribute(IFLA_CAN_DATA_BITTIMING, timing);
      writer.attribute(IFLA_CAN_RESTART_MS, std::uint32_t{0});
    });
    ASSERT_TRUE(link && link->controller);
    EXPECT_EQ(link->controller->state, state);
    EXPECT_EQ(link->controller->transmit_errors, 128);
    EXPECT_EQ(link->controller->receive_errors, 17);
    EXPECT_EQ(link->controller->bus_offs, 3U);
    EXPECT_EQ(link->controller->passives, 5U);
    EXPECT_EQ(link->controller->restarts, 2U);
    EXPECT_TRUE(link->fd);
    EXPECT_EQ(link->data.bit_rate, 5'000'000);
    EXPECT_EQ(link->data.sample_point, 0.8);
    EXPECT_EQ(link->restart_ms, 0);
  }
}

TEST(Netlink, ARefusalHasTheKernelsWords) {
  NetlinkWriter writer(NLMSG_ERROR, NLM_F_ACK_TLVS | NLM_F_CAPPED, 9);
  nlmsgerr error{};
  error.error = -EINVAL;
  error.msg.nlmsg_len = 200;  // longer than what comes back of it
  writer.fixed(error);
  writer.text(NLMSGERR_ATTR_MSG, "bitrate too high");
  const NetlinkVerdict verdict = netlink_verdict(netlink_messages(writer.finish()).at(0));
  EXPECT_EQ(verdict.error, EINVAL);
  EXPECT_EQ(verdict.reason, "bitrate too high");
}

TEST(Netlink, SurvivesAnyBytes) {
  std::mt19937 random(5);
  for (const char* recorded : {kRecordedKvaser, kRecordedVcan}) {
    const std::vector<std::byte> whole = bytes_of(recorded);
    for (int round = 0; round < 20'000; ++round) {
      std::vector<std::byte> bytes(
          whole.begin(), whole.begin() + static_cast<long>(random() % (whole.size() + 1)));
      for (int change = 0; change < 4 && !bytes.empty(); ++change) {
        bytes[random() % bytes.size()] = static_cast<std::byte>(random());
      }
      for (const NetlinkMessage& message : netlink_messages(bytes)) {
        if (const auto link = parse_can_link(message)) {
          EXPECT_LE(link->name.size(), bytes.size());
        }
        netlink_verdict(message);
      }
    }
  }
}

TEST(Netlink, TheKernelKnowsLoAndNoOtherOfTheName) {
  KernelLinkPort port;
  int error = 0;
  const auto lo = port.read("lo", error);
  ASSERT_TRUE(lo.has_value()) << std::strerror(error);
  EXPECT_EQ(lo->name, "lo");
  EXPECT_FALSE(lo->can);
  EXPECT_FALSE(port.read("no-such-can", error).has_value());
  EXPECT_EQ(error, ENODEV);
}

}  // namespace
}  // namespace geodesic::drivers
