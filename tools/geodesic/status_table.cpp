// The daemon's status as a table for people; see the header.
#include "tools/geodesic/status_table.hpp"

#include <fmt/format.h>

namespace geodesic::tools {
namespace {

using nlohmann::json;

std::string number(const json& object, const char* key, const char* format) {
  const auto found = object.find(key);
  if (found == object.end() || !found->is_number()) return "-";
  return fmt::format(fmt::runtime(format), found->get<double>());
}

std::string text(const json& object, const char* key) {
  const auto found = object.find(key);
  return found != object.end() && found->is_string() ? found->get<std::string>() : "-";
}

std::string head(const json& status) {
  std::string result =
      fmt::format("{}: {}, law {}, authority {}, {} s\n", text(status, "robot"),
                  text(status, "state"), text(status, "law"), number(status, "authority", "{:.2f}"),
                  number(status, "time_s", "{:.1f}"));
  const bool realtime = status.value("realtime", false);
  return result +
         fmt::format("{} cycles, {} missed, {} page faults, {} allocations{}\n",
                     number(status, "cycles", "{:.0f}"), number(status, "missed", "{:.0f}"),
                     number(status, "page_faults", "{:.0f}"),
                     number(status, "allocations", "{:.0f}"),
                     realtime ? "" : ", NOT real-time: " + text(status, "realtime_reason"));
}

std::string latencies(const json& status) {
  std::string result;
  const auto found = status.find("latencies");
  if (found == status.end()) return result;
  for (const char* key : {"wake_latency_ns", "cycle_time_ns", "state_to_torque_ns"}) {
    const auto histogram = found->find(key);
    if (histogram == found->end()) continue;
    const auto micro = [&](const char* part) {
      const auto value = histogram->find(part);
      return value != histogram->end() && value->is_number() ? value->get<double>() * 1e-3 : 0.0;
    };
    const std::string name(key, std::string_view(key).size() - 3);
    result += fmt::format("{:<18} p50 {:>8.1f}  p99 {:>8.1f}  p99.9 {:>8.1f}  max {:>8.1f} us\n",
                          name, micro("p50"), micro("p99"), micro("p999"), micro("max"));
  }
  return result;
}

/// What watches the joint has to say, if it has.
std::string watch(const json& joint) {
  std::string result;
  if (joint.value("contact", false)) result += ", in contact";
  if (joint.value("gain", 1.0) < 1.0) {
    result += ", gains at " + number(joint, "gain", "{:.2f}") + " for a vibration";
  }
  const std::string check = text(joint, "static_check");
  if (check == "pending") result += ", static check pending: not yet seen to carry itself";
  if (check == "failed") result += ", static check failed";
  return result;
}

std::string joints(const json& status) {
  std::string result =
      fmt::format("{:<26}{:>11}{:>11}{:>11}{:>11}{:>11}{:>11}{:>7}{:>7}  {}\n", "joint", "angle",
                  "velocity", "torque", "command", "model", "external", "C", "lost", "drive");
  const auto found = status.find("joints");
  if (found == status.end()) return result;
  for (const json& joint : *found) {
    std::string drive = text(joint, "condition");
    if (joint.contains("drive_error")) drive += ": " + text(joint, "drive_error");
    if (joint.contains("complaint")) drive += ": " + text(joint, "complaint");
    result +=
        fmt::format("{:<26}{:>11}{:>11}{:>11}{:>11}{:>11}{:>11}{:>7}{:>7}  {}\n",
                    text(joint, "name"), number(joint, "position", "{:+.4f}"),
                    number(joint, "velocity", "{:+.4f}"), number(joint, "torque", "{:+.3f}"),
                    number(joint, "command", "{:+.3f}"), number(joint, "model", "{:+.3f}"),
                    number(joint, "external", "{:+.3f}"), number(joint, "temperature", "{:.0f}"),
                    number(joint, "lost", "{:.0f}"), drive + watch(joint));
  }
  return result;
}

/// Said only of robots with several arms.
std::string arms(const json& status) {
  std::string result;
  const auto found = status.find("arms");
  if (found == status.end() || !found->is_array() || found->size() < 2) return result;
  for (const json& arm : *found) {
    result += fmt::format("arm {}: {}, law {}, authority {}\n", text(arm, "name"),
                          text(arm, "state"), text(arm, "law"), number(arm, "authority", "{:.2f}"));
  }
  return result;
}

/// Joints that owe replies now, or have missed several in a row.
std::string missing(const json& status) {
  std::string result;
  const auto found = status.find("joints");
  if (found == status.end()) return result;
  for (const json& joint : *found) {
    const auto counts = joint.find("missing");
    if (counts == joint.end() || counts->value("longest", 0) < 2) continue;
    result += fmt::format("{}: {} replies missing, longest run {}, now {}\n", text(joint, "name"),
                          number(*counts, "total", "{:.0f}"), number(*counts, "longest", "{:.0f}"),
                          number(*counts, "run", "{:.0f}"));
  }
  return result;
}

/// Said only of buses with a CAN controller, and of what happened to them.
std::string controller(const json& bus) {
  std::string result;
  if (const std::string state = bus.value("controller", std::string()); !state.empty()) {
    result = fmt::format(", {}, error counters {} sending, {} receiving", state,
                         number(bus, "transmit_errors", "{:.0f}"),
                         number(bus, "receive_errors", "{:.0f}"));
  }
  const auto happened = [&](const char* key, const char* what) {
    if (bus.value(key, 0.0) >= 1.0) {
      result += fmt::format(", {} {}", number(bus, key, "{:.0f}"), what);
    }
  };
  happened("bus_offs", "times bus-off");
  happened("purged", "times emptied");
  happened("reopened", "times opened again");
  happened("foreign_frames_hz", "foreign frames a second");
  return result;
}

std::string buses(const json& status) {
  std::string result;
  const auto found = status.find("buses");
  if (found == status.end()) return result;
  for (const json& bus : *found) {
    std::string place = text(bus, "interface");
    const std::string device = bus.value("device", std::string());
    if (!device.empty() && device != place) place += " = " + device;
    result +=
        fmt::format("bus {} ({}): {}, {} sent, {} received, {} skipped, {} error frames{}\n",
                    text(bus, "name"), place, text(bus, "state"), number(bus, "sent", "{:.0f}"),
                    number(bus, "received", "{:.0f}"), number(bus, "send_skipped", "{:.0f}"),
                    number(bus, "error_frames", "{:.0f}"), controller(bus));
  }
  return result;
}

std::string faults(const json& status) {
  constexpr std::size_t kLast = 5;
  std::string result;
  const auto found = status.find("faults");
  if (found == status.end() || !found->is_array()) return result;
  const std::size_t first = found->size() > kLast ? found->size() - kLast : 0;
  for (std::size_t i = first; i < found->size(); ++i) {
    const json& fault = (*found)[i];
    result += fmt::format("fault at {} s: {}\n", number(fault, "time", "{:.3f}"),
                          fault.contains("text") ? text(fault, "text") : text(fault, "name"));
  }
  return result;
}

}  // namespace

std::string status_table(const nlohmann::json& status) {
  return head(status) + arms(status) + "\n" + joints(status) + missing(status) + "\n" +
         latencies(status) + buses(status) + faults(status);
}

}  // namespace geodesic::tools
