// Finds ODrives on a bus; see scanner.hpp.
#include "drivers/odrive/scanner.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <iterator>
#include <utility>

#include "drivers/odrive/codec.hpp"
#include "drivers/odrive/errors.hpp"

namespace geodesic::drivers::odrive {

namespace {

constexpr std::uint8_t kLastState = 14;
constexpr int kLeastHeartbeats = 2;
/// Heartbeats 1 ms to 1 s apart; other families' reports on such an identifier are answers, and
/// come when somebody asks.
constexpr std::int64_t kSlowestNs = 1'000'000'000;

std::uint32_t integer(const Frame& frame, const Field& field) {
  return static_cast<std::uint32_t>(decode_bits(frame, field).value_or(0));
}

}  // namespace

void OdriveScanner::receive(const ReceivedFrame& received) {
  const Frame& frame = received.frame;
  if (frame.error || frame.extended || frame.fd || frame.remote || node_of(frame) > kLastNode) {
    return;
  }
  const Command command = command_of(frame);
  if (command == Command::kHeartbeat) {
    Node& node = nodes_[node_of(frame)];
    node.strange = node.strange || frame.length != 8 || frame.data[4] > kLastState ||
                   (node.heartbeats > 0 && received.stamp_ns - node.heartbeat_ns > kSlowestNs);
    ++node.heartbeats;
    node.heartbeat_ns = received.stamp_ns;
    node.heartbeat = frame;
    return;
  }
  const auto known = nodes_.find(node_of(frame));
  if (known == nodes_.end() || frame.length != 8) {
    return;
  }
  known->second.error_answers += command == Command::kError ? 1 : 0;
  known->second.estimates += command == Command::kEstimates ? 1 : 0;
  if (command == Command::kVersion) {
    known->second.version = frame;
  }
}

std::optional<Frame> OdriveScanner::transmit(std::int64_t now_ns) {
  begun_ns_ = begun_ns_ < 0 ? now_ns : begun_ns_;
  if (over_ || now_ns - begun_ns_ < kListenNs || now_ns < next_ns_) {
    return std::nullopt;
  }
  std::vector<std::uint32_t> heard;
  for (const auto& [id, node] : nodes_) {
    if (!node.strange && node.heartbeats >= kLeastHeartbeats) {
      heard.push_back(id);
    }
  }
  next_ns_ = now_ns + kReplyTimeoutNs;
  const std::size_t each = 2 * kAsks;
  if (asks_ >= heard.size() * each) {
    over_ = true;
    return std::nullopt;
  }
  const std::uint32_t id = heard[asks_ / each];
  const Command command = asks_ % 2 == 0 ? Command::kVersion : Command::kError;
  ++asks_;
  return encode_request(id, command);
}

std::vector<FoundDrive> OdriveScanner::found() const {
  std::vector<FoundDrive> all;
  for (const auto& [id, node] : nodes_) {
    if (node.strange || node.heartbeats < kLeastHeartbeats ||
        (!node.version && node.error_answers == 0)) {
      continue;
    }
    FoundDrive& drive = all.emplace_back();
    drive.id = id;
    const bool old = !node.version;
    const Message& heartbeat = old ? kHeartbeat05 : kHeartbeat06;
    if (old) {
      drive.model = "ODrive";
      drive.firmware = "0.5 (does not tell its version)";
    } else {
      const auto part = [&node = node](std::size_t i) {
        return integer(*node.version, kVersionReport.fields[i]);
      };
      drive.model = fmt::format("ODrive, hardware {}.{}-{}V", part(1), part(2), part(3));
      drive.firmware =
          fmt::format("{}.{}.{}{}", part(4), part(5), part(6), part(7) != 0 ? " (unreleased)" : "");
    }
    drive.options.emplace_back("firmware", old ? "\"0.5\"" : "\"0.6\"");
    if (node.estimates == 0) {
      drive.options.emplace_back("feedback", "\"request\"");
      drive.remarks.emplace_back("it sends no positions by its timer (encoder_msg_rate_ms is 0)");
    }
    // What check() needs and CANSimple does not tell.
    for (const auto& [key, value] :
         {std::pair{"torque_constant_nm_a", "0.1"}, std::pair{"current_limit_a", "10.0"},
          std::pair{"torque_range_nm", "1.0"}, std::pair{"velocity_range_rad_s", "50.0"}}) {
      drive.options.emplace_back(key, value);
    }
    drive.remarks.emplace_back(
        "torque_constant_nm_a, current_limit_a, torque_range_nm and velocity_range_rad_s are "
        "examples: the drive does not tell them, take them from odrivetool");
    const std::uint32_t errors = integer(node.heartbeat, heartbeat.fields[0]);
    if (errors != 0) {
      drive.remarks.push_back(
          fmt::format("error: {}", error_name(code_of(errors, old ? kAxisBase : kActiveBase))));
    }
    const std::uint32_t state = integer(node.heartbeat, heartbeat.fields[1]);
    if (state != kAxisIdle) {
      drive.remarks.push_back(
          fmt::format("the axis is not idle: {}", state_name(static_cast<std::uint8_t>(state))));
    }
    drive.remarks.emplace_back(
        "whether its watchdog is on cannot be told without endpoint ids: see drivers/odrive");
  }
  return all;
}

}  // namespace geodesic::drivers::odrive
