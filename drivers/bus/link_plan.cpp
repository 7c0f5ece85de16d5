// What a CAN interface should be against what it is.
#include "drivers/bus/link_plan.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>

namespace geodesic::drivers {
namespace {

constexpr int kFdMtu = 72;
// Dividers of a clock do not meet every rate; beyond this, two crystals might not understand each
// other. (ISO 11898-1: 0.5 % at 1 Mbit/s and usual segments.)
constexpr double kRateTolerance = 0.005;
// Of a sample point, where nobody says how many quanta a bit has; else one quantum.
constexpr double kSamplePointTolerance = 0.02;

bool is_virtual(const CanLink& link) {
  return link.kind == "vcan" || link.kind == "vxcan" ||
         (link.kind.empty() && is_virtual_can(link.name));
}

bool other_rate(const LinkTiming& found, std::int64_t wanted) {
  return found.bit_rate && std::abs(static_cast<double>(*found.bit_rate - wanted)) >
                               kRateTolerance * static_cast<double>(wanted);
}

bool other_point(const LinkTiming& found, const std::optional<double>& wanted) {
  const double step = found.quanta > 0 ? std::max(kSamplePointTolerance, 1.0 / found.quanta)
                                       : kSamplePointTolerance;
  return wanted && found.sample_point && std::abs(*found.sample_point - *wanted) > step;
}

/// What needs the interface down to be changed.
void controller_differences(const CanLink& link, const BusOptions& options,
                            std::vector<std::string>& list) {
  const auto point = [&](const char* what, const LinkTiming& found,
                         const std::optional<double>& wanted) {
    if (other_point(found, wanted)) {
      list.push_back(
          fmt::format("{} {:.3f}, configured {:.3f}", what, *found.sample_point, *wanted));
    }
  };
  if (other_rate(link.nominal, options.bit_rate)) {
    list.push_back(
        fmt::format("bit rate {}, configured {}", *link.nominal.bit_rate, options.bit_rate));
  }
  point("sample point", link.nominal, options.sample_point);
  if (options.fd && link.has_controller() && !link.fd) {
    list.emplace_back("CAN FD is off, configured on");
  } else if (options.fd) {
    if (other_rate(link.data, options.data_bit_rate)) {
      list.push_back(fmt::format("data bit rate {}, configured {}", *link.data.bit_rate,
                                 options.data_bit_rate));
    }
    point("data sample point", link.data, options.data_sample_point);
  }
  if (options.fd && !link.has_controller() && link.mtu < kFdMtu) {
    list.push_back(fmt::format(
        "carries classic CAN only (mtu {}), but CAN FD (mtu {}) is configured", link.mtu, kFdMtu));
  }
  if (options.restart_ms && link.restart_ms && *link.restart_ms != *options.restart_ms) {
    list.push_back(
        fmt::format("restart-ms {}, configured {}", *link.restart_ms, *options.restart_ms));
  }
}

}  // namespace

bool is_virtual_can(const std::string& device) {
  return device.starts_with("vcan") || device.starts_with("vxcan");
}

std::vector<std::string> link_differences(const CanLink& link, const BusOptions& options) {
  std::vector<std::string> list;
  if (!link.up) {
    list.push_back(fmt::format("interface {} is down", link.name));
  }
  // A controller that was never set up has no bit rate: being down says it all.
  if (link.up || link.nominal.bit_rate || !link.has_controller()) {
    controller_differences(link, options, list);
  }
  if (options.queue && link.queue != *options.queue) {
    list.push_back(fmt::format("queue of {} frames, configured {}", link.queue, *options.queue));
  }
  return list;
}

LinkPlan link_plan(const CanLink& link, const BusOptions& options) {
  LinkPlan plan;
  std::vector<std::string> controller;
  controller_differences(link, options, controller);
  plan.down_first = link.up && !controller.empty();
  if (!link.up || plan.down_first) {
    plan.change.up = true;
    if (link.has_controller()) {
      plan.change.bit_rate = options.bit_rate;
      plan.change.sample_point = options.sample_point;
      plan.change.restart_ms = options.restart_ms.value_or(kDefaultRestartMs);
      if (options.fd) {
        plan.change.fd = true;
        plan.change.data_bit_rate = options.data_bit_rate;
        plan.change.data_sample_point = options.data_sample_point;
      } else if (link.fd) {
        plan.change.fd = false;  // its data rate may not suit the new nominal one
      }
    } else if (is_virtual(link) && options.fd && link.mtu < kFdMtu) {
      plan.change.mtu = kFdMtu;
    }
  }
  const int queue =
      options.queue.value_or(link.has_controller() && plan.change.up ? kDefaultQueue : link.queue);
  if (queue != link.queue) {
    plan.change.queue = queue;
  }
  return plan;
}

std::string link_command(const std::string& device, const BusOptions& options,
                         const CanLink* link) {
  const bool made = link == nullptr ? is_virtual_can(device) : is_virtual(*link);
  std::string command;
  std::vector<std::string> down_for;
  if (link != nullptr && link->up) {
    controller_differences(*link, options, down_for);
    if (!down_for.empty()) {
      command = fmt::format("ip link set {} down && ", device);
    }
  }
  command += fmt::format("ip link set {}", device);
  const bool only_queue = link != nullptr && link->up && down_for.empty();
  if (made) {
    if (options.queue) {
      command += fmt::format(" txqueuelen {}", *options.queue);
    }
    return only_queue ? command : command + (options.fd ? " mtu 72 up" : " up");
  }
  command += fmt::format(" txqueuelen {}", options.queue.value_or(kDefaultQueue));
  if (only_queue) {
    return command;
  }
  command += fmt::format(" up type can bitrate {}", options.bit_rate);
  if (options.sample_point) {
    command += fmt::format(" sample-point {:.3f}", *options.sample_point);
  }
  if (options.fd) {
    command += fmt::format(" dbitrate {}", options.data_bit_rate);
    if (options.data_sample_point) {
      command += fmt::format(" dsample-point {:.3f}", *options.data_sample_point);
    }
    command += " fd on";
  } else if (link != nullptr && link->fd) {
    command += " fd off";
  }
  return command + fmt::format(" restart-ms {}", options.restart_ms.value_or(kDefaultRestartMs));
}

}  // namespace geodesic::drivers
