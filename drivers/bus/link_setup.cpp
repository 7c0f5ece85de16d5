// Brings a CAN interface into the state that the configuration wants, or refuses.
#include "drivers/bus/link_setup.hpp"

#include <fmt/format.h>
#include <fmt/ranges.h>

#include <algorithm>
#include <cerrno>
#include <cstring>

#include "drivers/bus/interface_name.hpp"
#include "drivers/bus/link_plan.hpp"

namespace geodesic::drivers {
namespace {

constexpr int kFdMtu = 72;

CanLink read_link(LinkPort& port, const BusOptions& options, const std::string& device) {
  if (const std::string wrong = wrong_interface_name(device); !wrong.empty()) {
    refuse_bus(options, fmt::format("\"{}\" is no interface name (1 to 15 characters)", device), 0,
               "name a CAN interface (can0, vcan0) or a socket bus (unix:PATH)");
  }
  int error = 0;
  const auto link = port.read(device, error);
  if (!link && error == ENODEV) {
    refuse_bus(options, fmt::format("interface {} does not exist", device), error,
               is_virtual_can(device)
                   ? fmt::format("ip link add dev {} type vcan && {}", device,
                                 link_command(device, options))
                   : "ip -brief link show type can   # lists the CAN interfaces there are; is the "
                     "adapter plugged in?");
  }
  if (!link) {
    refuse_bus(options, fmt::format("cannot ask the kernel about interface {}", device), error,
               "allow this program netlink sockets (systemd: RestrictAddressFamilies=AF_NETLINK)");
  }
  if (!link->can) {
    refuse_bus(options, fmt::format("interface {} is not a CAN interface", device), 0,
               "ip -brief link show type can   # lists those there are");
  }
  return *link;
}

std::string list(const std::vector<std::string>& differences, const std::string& device) {
  std::string down = fmt::format("interface {} is down", device);
  if (differences == std::vector<std::string>{down}) {
    return down;
  }
  std::vector<std::string> others = differences;
  const bool is_down = std::erase(others, down) > 0;
  return fmt::format("interface {} is {}otherwise than configured: {}", device,
                     is_down ? "down and " : "", fmt::join(others, "; "));
}

/// What the opener needs of the interface at the least, if its setting is not its own business.
std::vector<std::string> needs(const CanLink& link, const BusOptions& options) {
  if (!options.transmit.empty()) {
    return link_differences(link, options);
  }
  std::vector<std::string> list;
  if (!link.up) {
    list.push_back(fmt::format("interface {} is down", link.name));
  }
  if (options.fd && !link.fd && link.mtu < kFdMtu) {
    list.push_back(fmt::format(
        "carries classic CAN only (mtu {}), but CAN FD (mtu {}) is configured", link.mtu, kFdMtu));
  }
  return list;
}

NetlinkVerdict carry_out(LinkPort& port, const CanLink& link, const LinkPlan& plan) {
  if (plan.down_first) {
    LinkChange down;
    down.up = false;
    if (NetlinkVerdict verdict = port.change(link.index, down); verdict.error != 0) {
      return verdict;
    }
  }
  // In two steps: an interface that refuses its bit rate shall not come up with the old one.
  LinkChange setting = plan.change;
  setting.up.reset();
  const bool sets = setting.touches_controller() || setting.mtu || setting.queue;
  if (sets) {
    if (NetlinkVerdict verdict = port.change(link.index, setting); verdict.error != 0) {
      return verdict;
    }
  }
  LinkChange up;
  up.up = plan.change.up;
  return up.up ? port.change(link.index, up) : NetlinkVerdict{};
}

}  // namespace

void refuse_bus(const BusOptions& options, const std::string& found, int error,
                const std::string& fix) {
  const std::string reason = error != 0 ? fmt::format(" ({})", std::strerror(error)) : "";
  const std::string label =
      options.name.empty() || options.name == options.interface ? "" : options.name + ": ";
  throw BusError(fmt::format("{}{}{}; fix: {}", label, found, reason, fix), error);
}

CanLink prepare_link(LinkPort& port, const BusOptions& options, const std::string& device,
                     std::vector<BusNews>& news) {
  CanLink link = read_link(port, options, device);
  std::vector<std::string> missing = needs(link, options);
  if (missing.empty()) {
    return link;
  }
  std::string forbidden;
  if (options.bring_up) {
    const NetlinkVerdict verdict = carry_out(port, link, link_plan(link, options));
    if (verdict.error == 0) {
      link = read_link(port, options, device);
      missing = needs(link, options);
      if (missing.empty()) {
        news.push_back({false, fmt::format("interface {} set up as configured: {}", device,
                                           link_command(device, options))});
        return link;
      }
    } else if (verdict.error == EPERM) {
      forbidden = " (not set up by this program: it lacks CAP_NET_ADMIN)";
    } else {
      refuse_bus(
          options,
          fmt::format("{}; setting it up was refused by the kernel{}{}", list(missing, device),
                      verdict.reason.empty() ? "" : ": ", verdict.reason),
          verdict.error,
          fmt::format("change what the interface cannot do in the configuration, or try by "
                      "hand: {}",
                      link_command(device, options, &link)));
    }
  }
  refuse_bus(options, list(missing, device) + forbidden, 0, link_command(device, options, &link));
}

}  // namespace geodesic::drivers
