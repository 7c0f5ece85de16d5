// [[bus]] and --bus to BusOptions: names, interfaces, bit rates.
#include <fmt/format.h>

#include <algorithm>

#include "config/checks.hpp"

namespace geodesic::config {
namespace {

/// What is wrong with an interface's name; empty: nothing.
std::string wrong_interface(const std::string& interface) {
  constexpr std::string_view kUnix = "unix:";
  constexpr std::size_t kLongestPath = 107;  // sockaddr_un
  constexpr std::size_t kLongestName = 15;   // IFNAMSIZ
  if (interface.starts_with(kUnix)) {
    const std::size_t length = interface.size() - kUnix.size();
    if (length == 0) return "expected a path after unix:";
    if (length > kLongestPath) {
      return fmt::format("the path has {} bytes, a socket's may have {}", length, kLongestPath);
    }
    return {};
  }
  if (interface.empty() || interface.size() > kLongestName ||
      interface.find_first_of("/ \t:") != std::string::npos) {
    return "expected the name of a network interface such as can0 (at most 15 letters), or "
           "unix:PATH";
  }
  return {};
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
  if (entry.fd.value && entry.data_bit_rate.value < entry.bit_rate.value) {
    findings.error(entry.data_bit_rate.given ? entry.data_bit_rate.place : entry.place,
                   fmt::format("data_bit_rate: {} bit/s is slower than the nominal {} bit/s",
                               entry.data_bit_rate.value, entry.bit_rate.value));
  }
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
    check_rates(entry, draft.findings);
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
