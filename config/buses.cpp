// [[bus]] and --bus to BusOptions: names, interfaces, bit rates.
#include <fmt/format.h>

#include <algorithm>

#include "config/checks.hpp"
#include "drivers/bus/interface_name.hpp"

namespace geodesic::config {
namespace {

/// What is wrong with an interface's name; empty: nothing.
std::string wrong_interface(const std::string& interface) {
  constexpr std::string_view kUnix = "unix:";
  constexpr std::size_t kLongestPath = 107;  // sockaddr_un
  if (interface.starts_with(kUnix)) {
    const std::size_t length = interface.size() - kUnix.size();
    if (length == 0) return "expected a path after unix:";
    if (length > kLongestPath) {
      return fmt::format("the path has {} bytes, a socket's may have {}", length, kLongestPath);
    }
    return {};
  }
  return drivers::wrong_interface_name(interface);
}

bool is_virtual(const std::string& interface) {
  return interface.starts_with("unix:") || interface.starts_with("vcan") ||
         interface.starts_with("vxcan");
}

void check_override(Draft& draft) {
  const std::size_t named = draft.options.bus_override.size();
  const std::size_t buses = draft.file.buses.size();
  if (named == 0 || named == buses) return;
  const Place place{draft.robot.file, 0, 0};
  if (named > 1) {
    draft.findings.error(place,
                         fmt::format("--bus names {} buses, the robot has {}", named, buses));
  } else if (buses > 1) {
    draft.findings.error(place,
                         fmt::format("--bus names one bus ({}) for all, but the robot has {}: "
                                     "its drives' identifiers are told apart by their bus; "
                                     "name one for each, in order",
                                     draft.options.bus_override.front(), buses));
  }
}

void check_rates(const BusEntry& entry, Findings& findings) {
  if (entry.data_bit_rate.given && !entry.fd.value) {
    findings.error(
        entry.data_bit_rate.place,
        "data_bit_rate: a bus with fd = false has no data phase; set fd = true, or leave "
        "data_bit_rate out");
  }
  if (entry.data_sample_point.given && !entry.fd.value) {
    findings.error(entry.data_sample_point.place,
                   "data_sample_point: a bus with fd = false has no data phase; set fd = true, or "
                   "leave data_sample_point out");
  }
  if (entry.fd.value && entry.data_bit_rate.value < entry.bit_rate.value) {
    findings.error(entry.data_bit_rate.given ? entry.data_bit_rate.place : entry.place,
                   fmt::format("data_bit_rate: {} bit/s is slower than the nominal {} bit/s",
                               entry.data_bit_rate.value, entry.bit_rate.value));
  }
}

/// A socket bus has no controller to set up.
void check_setup(const BusEntry& entry, const std::string& interface, Findings& findings) {
  if (!interface.starts_with("unix:")) return;
  const auto needless = [&](const auto& option, const char* name) {
    if (option.given) {
      findings.warning(option.place, fmt::format("{}: has no meaning on a socket bus ({})", name,
                                                 quote(interface)));
    }
  };
  needless(entry.sample_point, "sample_point");
  needless(entry.data_sample_point, "data_sample_point");
  needless(entry.restart_ms, "restart_ms");
  needless(entry.queue, "queue");
}

void fill_setup(const BusEntry& entry, drivers::BusOptions& bus) {
  bus.bring_up = entry.bring_up.value;
  if (entry.sample_point.given) bus.sample_point = entry.sample_point.value;
  if (entry.data_sample_point.given) bus.data_sample_point = entry.data_sample_point.value;
  if (entry.restart_ms.given) bus.restart_ms = static_cast<int>(entry.restart_ms.value);
  if (entry.queue.given) bus.queue = static_cast<int>(entry.queue.value);
}

}  // namespace

void fill_buses(Draft& draft) {
  check_override(draft);
  std::vector<drivers::BusOptions>& buses = draft.robot.arm.buses;
  const std::vector<std::string>& override = draft.options.bus_override;
  for (std::size_t i = 0; i < draft.file.buses.size(); ++i) {
    const BusEntry& entry = draft.file.buses[i];
    drivers::BusOptions bus;
    bus.name = entry.name.value;
    bus.interface = entry.interface.value;
    if (i < override.size()) bus.interface = override[i];
    bus.fd = entry.fd.value;
    bus.bit_rate = entry.bit_rate.value;
    bus.data_bit_rate = entry.data_bit_rate.value;
    fill_setup(entry, bus);
    check_rates(entry, draft.findings);
    // Where --bus replaces a real bus by a socket bus, the file need not change.
    if (i >= override.size()) check_setup(entry, bus.interface, draft.findings);
    for (std::size_t k = 0; k < i; ++k) {
      const BusEntry& other = draft.file.buses[k];
      if (entry.name.given && entry.name.value == other.name.value) {
        draft.findings.error(entry.name.place,
                             fmt::format("a second bus {}; the first is in line {}",
                                         quote(bus.name), other.name.place.line));
      }
      if (!bus.interface.empty() && bus.interface == buses[k].interface) {
        draft.findings.error(
            entry.interface.given ? entry.interface.place : entry.place,
            fmt::format("buses {} and {} are both on {}; expected an interface for "
                        "each",
                        quote(buses[k].name), quote(bus.name), quote(bus.interface)));
      }
    }
    const bool named = entry.interface.given || i < override.size();
    if (const std::string wrong = wrong_interface(bus.interface); named && !wrong.empty()) {
      draft.findings.error(entry.interface.given ? entry.interface.place : entry.place,
                           fmt::format("interface: found {}, {}", quote(bus.interface), wrong));
    }
    buses.push_back(std::move(bus));
  }
  if (buses.size() > control::kMaxBuses) {
    draft.findings.error(
        draft.file.buses[control::kMaxBuses].place,
        fmt::format("{} buses, expected at most {}", buses.size(), control::kMaxBuses));
  }
  // The law that does nothing is for contrast in simulation; on a real arm it lets it fall.
  draft.robot.controller.allow_zero_law = std::all_of(
      buses.begin(), buses.end(), [](const auto& b) { return is_virtual(b.interface); });
}

}  // namespace geodesic::config
