// A CAN interface under the doctor's eye; see doctor_looks.hpp.
#include <fmt/format.h>

#include <algorithm>
#include <cctype>
#include <sstream>
#include <system_error>

#include "drivers/bus/interface_name.hpp"
#include "drivers/bus/link_plan.hpp"
#include "drivers/bus/socket_bus_hub.hpp"
#include "tools/geodesic/doctor_looks.hpp"

namespace geodesic::tools {
namespace {

using drivers::ControllerState;

constexpr int kLeastQueue = 10;  ///< frames; a joint's cycle and what is beside it

std::string joined(const std::vector<std::string>& parts) {
  std::string text;
  for (const std::string& part : parts) text += (text.empty() ? "" : "; ") + part;
  return text;
}

/// What the kernel tells of the wire, and what of it the configuration wants otherwise.
void look_at_setup(const drivers::CanLink& link, const drivers::BusOptions& options, Area& area) {
  const std::string command = "sudo " + drivers::link_command(link.name, options, &link);
  if (!link.up) {
    area.bad("state", "down", command);
    return;
  }
  area.ok("state", "up");
  const std::vector<std::string> differences = drivers::link_differences(link, options);
  std::string timing = fmt::format(
      "{}{}{}", link.nominal.bit_rate ? fmt::format("{} bit/s", *link.nominal.bit_rate) : "virtual",
      link.fd && link.data.bit_rate ? fmt::format(", data {} bit/s", *link.data.bit_rate) : "",
      link.fd ? ", CAN FD" : "");
  if (link.nominal.sample_point) {
    timing += fmt::format(", sample point {:.3f}", *link.nominal.sample_point);
  }
  if (differences.empty()) {
    area.ok("bit timing", timing);
  } else {
    area.bad("bit timing", joined(differences), command);
  }
  if (link.queue < kLeastQueue) {
    area.warn("queue",
              fmt::format("room for {} frames: a cycle's frames may be refused", link.queue),
              fmt::format("sudo ip link set {} txqueuelen {}", link.name, drivers::kDefaultQueue));
  } else {
    area.ok("queue", fmt::format("room for {} frames", link.queue));
  }
  if (link.has_controller() && link.restart_ms == 0) {
    area.warn(
        "restart", "a controller that leaves the bus (bus-off) stays off",
        fmt::format("sudo ip link set {0} down && sudo ip link set {0} up type can restart-ms "
                    "{1}",
                    link.name, drivers::kDefaultRestartMs));
  }
}

void look_at_health(const drivers::LinkHealth& health, const std::string& name, Area& area) {
  const std::string text =
      fmt::format("{}, error counters {} sending, {} receiving; bus-off {} times",
                  drivers::to_string(health.state), health.transmit_errors, health.receive_errors,
                  health.bus_offs);
  const std::string restart = fmt::format(
      "sudo ip link set {0} down && sudo ip link set {0} up   (first: termination of "
      "120 ohm at both ends, wiring, equal bit rates, a second node that is on)",
      name);
  if (health.state == ControllerState::kBusOff || health.state == ControllerState::kPassive) {
    area.bad("controller", text, restart);
  } else if (health.state == ControllerState::kWarning || health.bus_offs > 0) {
    area.warn("controller", text, restart);
  } else {
    area.ok("controller", text);
  }
}

void look_at_losses(const SystemTree& system, const std::string& name, Area& area) {
  std::string lost;
  for (const char* counter :
       {"rx_dropped", "rx_over_errors", "rx_errors", "tx_errors", "tx_dropped"}) {
    const long count =
        system.read_number(fmt::format("/sys/class/net/{}/statistics/{}", name, counter))
            .value_or(0);
    if (count > 0) lost += fmt::format("{}{} {}", lost.empty() ? "" : ", ", counter, count);
  }
  if (lost.empty()) {
    area.ok("losses", "none since it was made");
  } else {
    area.warn("losses", lost + " since it was made",
              fmt::format("watch -n 1 ip -details -statistics link show {}   (growing: wiring, or "
                          "too much load)",
                          name));
  }
}

/// The interrupts of the device behind an interface: its own, or those of what it is plugged into.
std::vector<int> interrupts_of(const SystemTree& system, const std::string& name) {
  std::vector<int> found;
  std::error_code none;
  std::filesystem::path device =
      std::filesystem::canonical(system.place("/sys/class/net/" + name + "/device"), none);
  const std::filesystem::path top = std::filesystem::canonical(system.place("/sys"), none);
  constexpr int kDeepest = 32;
  for (int level = 0; level < kDeepest && !device.empty() && device != top; ++level) {
    const SystemTree here(device);
    for (const std::string& number : here.list("/msi_irqs")) {
      found.push_back(std::atoi(number.c_str()));
    }
    if (found.empty() && here.read_number("/irq").value_or(0) > 0) {
      found.push_back(static_cast<int>(*here.read_number("/irq")));
    }
    if (!found.empty() || device == device.parent_path()) break;
    device = device.parent_path();
  }
  return found;
}

struct InterruptThread {
  std::string pid;
  std::string name;
  int policy = 0;  ///< sched.h: 1 SCHED_FIFO, 2 SCHED_RR
  int priority = 0;
};

/// The kernel's threads "irq/NUMBER-NAME" for these interrupts.
std::vector<InterruptThread> threads_of(const SystemTree& system, const std::vector<int>& numbers) {
  std::vector<InterruptThread> threads;
  for (const std::string& pid : system.list("/proc")) {
    if (std::isdigit(static_cast<unsigned char>(pid.front())) == 0) continue;
    const std::string name = system.read("/proc/" + pid + "/comm").value_or("");
    const bool ours = std::any_of(numbers.begin(), numbers.end(), [&](int number) {
      return name.starts_with(fmt::format("irq/{}-", number));
    });
    if (!ours) continue;
    // proc(5): behind the name in parentheses, fields 3 on; 40 is rt_priority, 41 the policy.
    const std::string stat = system.read("/proc/" + pid + "/stat").value_or("");
    const std::size_t end = stat.rfind(')');
    std::istringstream fields(end == std::string::npos ? std::string() : stat.substr(end + 1));
    std::string field;
    InterruptThread thread{pid, name};
    for (int i = 3; i <= 41 && fields >> field; ++i) {
      if (i == 40) thread.priority = std::atoi(field.c_str());
      if (i == 41) thread.policy = std::atoi(field.c_str());
    }
    threads.push_back(thread);
  }
  return threads;
}

void look_at_interrupt(const SystemTree& system, const std::string& name, const Wishes& wishes,
                       Area& area) {
  const std::vector<int> numbers = interrupts_of(system, name);
  if (numbers.empty()) return;  // virtual, or of a bus that tells none
  const std::vector<InterruptThread> threads = threads_of(system, numbers);
  if (threads.empty()) {
    area.ok("interrupt", fmt::format("number {}, served at once (no thread)", numbers.front()));
    return;
  }
  std::vector<const InterruptThread*> low;
  for (const InterruptThread& thread : threads) {
    if ((thread.policy != 1 && thread.policy != 2) || thread.priority < wishes.priority) {
      low.push_back(&thread);
    }
  }
  if (low.empty()) {
    area.ok("interrupt",
            fmt::format("thread {} at priority {}, not below the cycle's {}", threads.front().name,
                        threads.front().priority, wishes.priority));
    return;
  }
  std::string commands;
  for (const InterruptThread* thread : low) {
    commands += fmt::format("{}sudo chrt --fifo --pid {} {}", commands.empty() ? "" : " && ",
                            std::min(wishes.priority + 5, 98), thread->pid);
  }
  area.warn("interrupt",
            fmt::format("thread {} at priority {} is below the cycle's {}: every thread between "
                        "can hold replies up",
                        low.front()->name, low.front()->priority, wishes.priority),
            commands);
}

}  // namespace

void look_at_bus(const SystemTree& system, drivers::LinkPort& port,
                 const drivers::BusOptions& options, const Wishes& wishes, Findings& findings) {
  Area area("bus " + options.name, findings);
  std::string device;
  try {
    device = drivers::resolve_interface(options.interface, system.place("/sys"));
  } catch (const drivers::BusError& error) {
    area.bad("interface", error.what(), "ip -brief link show type can");
    return;
  }
  int error = 0;
  const std::optional<drivers::CanLink> link = port.read(device, error);
  if (!link || !link->can) {
    area.bad(
        "interface",
        link ? fmt::format("{} is no CAN interface", device)
             : fmt::format("there is no {}: is the adapter plugged in, its driver loaded?", device),
        drivers::is_virtual_can(device)
            ? fmt::format("sudo ip link add {0} type vcan && sudo ip link set {0} mtu 72 up",
                          device)
            : std::string("ip -brief link show type can   # lists those there are"));
    return;
  }
  area.ok(
      "interface",
      device == options.interface ? device : fmt::format("{} is {}", options.interface, device));
  look_at_setup(*link, options, area);
  if (link->controller && link->up) look_at_health(*link->controller, device, area);
  look_at_losses(system, device, area);
  look_at_interrupt(system, device, wishes, area);
}

void look_at_socket_bus(const drivers::BusOptions& options, Findings& findings) {
  Area area("bus " + options.name, findings);
  if (drivers::socket_bus_served(options.interface)) {
    area.ok("interface", options.interface + " is served; a socket bus has no bit timing");
  } else {
    area.bad("interface", "nobody serves " + options.interface,
             "geodesic bus " + options.interface);
  }
}

}  // namespace geodesic::tools
