// A CAN interface as the kernel describes and changes it. The layout of the attributes is that of
// linux/can/netlink.h; iproute2 (ip/iplink_can.c) sends the same.
#include "drivers/bus/can_link.hpp"

#include <linux/can/netlink.h>
#include <linux/if.h>
#include <linux/if_arp.h>
#include <linux/if_link.h>
#include <linux/rtnetlink.h>

#include <algorithm>
#include <cerrno>
#include <cmath>

namespace geodesic::drivers {
namespace {

constexpr double kPerMille = 1000.0;
constexpr int kFdMtu = 72;
// A driver whose bit rate is set elsewhere says so (CAN_BITRATE_UNKNOWN).
constexpr std::uint32_t kRateUnknown = 0xFFFFFFFF;
constexpr std::uint64_t kMostQuanta = 1024;  // more makes no sense in any controller

ControllerState state_of(std::uint32_t state) {
  switch (state) {
    case CAN_STATE_ERROR_ACTIVE:
      return ControllerState::kActive;
    case CAN_STATE_ERROR_WARNING:
      return ControllerState::kWarning;
    case CAN_STATE_ERROR_PASSIVE:
      return ControllerState::kPassive;
    case CAN_STATE_BUS_OFF:
      return ControllerState::kBusOff;
    case CAN_STATE_STOPPED:
    case CAN_STATE_SLEEPING:
      return ControllerState::kStopped;
    default:
      return ControllerState::kUnknown;
  }
}

LinkTiming timing_of(const NetlinkAttribute& attribute) {
  LinkTiming timing;
  const auto value = attribute.value<can_bittiming>();
  if (value && value->bitrate != 0 && value->bitrate != kRateUnknown) {
    timing.bit_rate = value->bitrate;
    if (value->sample_point != 0) {
      timing.sample_point = value->sample_point / kPerMille;
    }
    const std::uint64_t quanta =
        std::uint64_t{1} + value->prop_seg + value->phase_seg1 + value->phase_seg2;
    timing.quanta = quanta > 1 && quanta <= kMostQuanta ? static_cast<int>(quanta) : 0;
  }
  return timing;
}

void take_controller(const NetlinkAttribute& data, CanLink& link, LinkHealth& health) {
  for (const NetlinkAttribute& item : netlink_attributes(data.data)) {
    switch (item.type) {
      case IFLA_CAN_BITTIMING:
        link.nominal = timing_of(item);
        break;
      case IFLA_CAN_DATA_BITTIMING:
        link.data = timing_of(item);
        break;
      case IFLA_CAN_STATE:
        health.state = state_of(item.value<std::uint32_t>().value_or(CAN_STATE_MAX));
        link.controller = health;
        break;
      case IFLA_CAN_CTRLMODE:
        link.fd =
            (item.value<can_ctrlmode>().value_or(can_ctrlmode{}).flags & CAN_CTRLMODE_FD) != 0;
        break;
      case IFLA_CAN_RESTART_MS:
        link.restart_ms = static_cast<int>(item.value<std::uint32_t>().value_or(0));
        break;
      case IFLA_CAN_BERR_COUNTER:
        if (const auto counter = item.value<can_berr_counter>()) {
          health.transmit_errors = counter->txerr;
          health.receive_errors = counter->rxerr;
        }
        break;
      default:
        break;
    }
  }
}

void take_statistics(const NetlinkAttribute& attribute, LinkHealth& health) {
  if (const auto counted = attribute.value<can_device_stats>()) {
    health.bus_errors = counted->bus_error;
    health.warnings = counted->error_warning;
    health.passives = counted->error_passive;
    health.bus_offs = counted->bus_off;
    health.arbitration_lost = counted->arbitration_lost;
    health.restarts = counted->restarts;
  }
}

void take_kind(const NetlinkAttribute& attribute, CanLink& link) {
  LinkHealth health;
  for (const NetlinkAttribute& item : netlink_attributes(attribute.data)) {
    if (item.type == IFLA_INFO_KIND) {
      link.kind = item.text();
    } else if (item.type == IFLA_INFO_DATA && link.kind == "can") {
      take_controller(item, link, health);
    } else if (item.type == IFLA_INFO_XSTATS && link.kind == "can") {
      take_statistics(item, health);
    }
  }
  if (link.controller) {
    health.state = link.controller->state;
    link.controller = health;
  }
}

std::uint32_t per_mille(double part) {
  return static_cast<std::uint32_t>(std::lround(part * kPerMille));
}

void add_timing(NetlinkWriter& writer, std::uint16_t type, std::int64_t bit_rate,
                const std::optional<double>& sample_point) {
  can_bittiming timing{};  // zero segments: the kernel works them out
  timing.bitrate = static_cast<std::uint32_t>(bit_rate);
  timing.sample_point = sample_point ? per_mille(*sample_point) : 0;
  writer.attribute(type, timing);
}

std::vector<std::byte> copy(std::span<const std::byte> bytes) {
  return {bytes.begin(), bytes.end()};
}

}  // namespace

const char* to_string(ControllerState state) noexcept {
  switch (state) {
    case ControllerState::kActive:
      return "error-active";
    case ControllerState::kWarning:
      return "error-warning";
    case ControllerState::kPassive:
      return "error-passive";
    case ControllerState::kBusOff:
      return "bus-off";
    case ControllerState::kStopped:
      return "stopped";
    case ControllerState::kUnknown:
      break;
  }
  return "";
}

std::optional<CanLink> parse_can_link(const NetlinkMessage& message) {
  ifinfomsg info{};
  if (message.header.nlmsg_type != RTM_NEWLINK || message.body.size() < sizeof info) {
    return std::nullopt;
  }
  std::memcpy(&info, message.body.data(), sizeof info);
  CanLink link;
  link.index = info.ifi_index;
  link.can = info.ifi_type == ARPHRD_CAN;
  link.up = (info.ifi_flags & IFF_UP) != 0;
  link.echoes = (info.ifi_flags & IFF_ECHO) != 0;
  for (const NetlinkAttribute& item : netlink_attributes(message.body.subspan(sizeof info))) {
    switch (item.type) {
      case IFLA_IFNAME:
        link.name = item.text();
        break;
      case IFLA_MTU:
        link.mtu = static_cast<int>(item.value<std::uint32_t>().value_or(0));
        break;
      case IFLA_TXQLEN:
        link.queue = static_cast<int>(item.value<std::uint32_t>().value_or(0));
        break;
      case IFLA_LINKINFO:
        take_kind(item, link);
        break;
      case IFLA_STATS64:
        if (const auto counted = item.value<rtnl_link_stats64>()) {
          link.received = counted->rx_packets;
          link.sent = counted->tx_packets;
        }
        break;
      default:
        break;
    }
  }
  if (!link.has_controller()) {
    link.fd = link.mtu >= kFdMtu;
  }
  return link;
}

std::vector<std::byte> ask_link_message(const std::string& name, std::uint32_t sequence) {
  NetlinkWriter writer(RTM_GETLINK, NLM_F_REQUEST, sequence);
  writer.fixed(ifinfomsg{});
  writer.text(IFLA_IFNAME, name);
  return copy(writer.finish());
}

std::vector<std::byte> ask_links_message(std::uint32_t sequence) {
  NetlinkWriter writer(RTM_GETLINK, NLM_F_REQUEST | NLM_F_DUMP, sequence);
  writer.fixed(ifinfomsg{});
  return copy(writer.finish());
}

std::vector<std::byte> change_link_message(int index, const LinkChange& change,
                                           std::uint32_t sequence) {
  NetlinkWriter writer(RTM_NEWLINK, NLM_F_REQUEST | NLM_F_ACK, sequence);
  ifinfomsg info{};
  info.ifi_index = index;
  if (change.up) {
    info.ifi_change = IFF_UP;
    info.ifi_flags = *change.up ? static_cast<unsigned>(IFF_UP) : 0U;
  }
  writer.fixed(info);
  if (change.mtu) {
    writer.attribute(IFLA_MTU, static_cast<std::uint32_t>(*change.mtu));
  }
  if (change.queue) {
    writer.attribute(IFLA_TXQLEN, static_cast<std::uint32_t>(*change.queue));
  }
  if (change.touches_controller()) {
    const std::size_t kind = writer.begin_nest(IFLA_LINKINFO);
    writer.text(IFLA_INFO_KIND, "can");
    const std::size_t data = writer.begin_nest(IFLA_INFO_DATA);
    if (change.fd) {
      writer.attribute(IFLA_CAN_CTRLMODE,
                       can_ctrlmode{CAN_CTRLMODE_FD, *change.fd ? CAN_CTRLMODE_FD : 0U});
    }
    if (change.bit_rate) {
      add_timing(writer, IFLA_CAN_BITTIMING, *change.bit_rate, change.sample_point);
    }
    if (change.data_bit_rate) {
      add_timing(writer, IFLA_CAN_DATA_BITTIMING, *change.data_bit_rate, change.data_sample_point);
    }
    if (change.restart_ms) {
      writer.attribute(IFLA_CAN_RESTART_MS, static_cast<std::uint32_t>(*change.restart_ms));
    }
    writer.end_nest(data);
    writer.end_nest(kind);
  }
  return copy(writer.finish());
}

std::optional<CanLink> KernelLinkPort::read(const std::string& name, int& error) {
  std::optional<CanLink> found;
  const auto message = ask_link_message(name, socket_.next_sequence());
  error =
      socket_.ask(message, [&](const NetlinkMessage& answer) { found = parse_can_link(answer); })
          .error;
  if (!found && error == 0) {
    error = EBADMSG;
  }
  return found;
}

NetlinkVerdict KernelLinkPort::change(int index, const LinkChange& change) {
  return socket_.ask(change_link_message(index, change, socket_.next_sequence()));
}

std::vector<CanLink> KernelLinkPort::all() {
  std::vector<CanLink> links;
  socket_.ask(ask_links_message(socket_.next_sequence()), [&](const NetlinkMessage& answer) {
    if (auto link = parse_can_link(answer); link && link->can) {
      links.push_back(std::move(*link));
    }
  });
  std::sort(links.begin(), links.end(),
            [](const CanLink& a, const CanLink& b) { return a.index < b.index; });
  return links;
}

}  // namespace geodesic::drivers
