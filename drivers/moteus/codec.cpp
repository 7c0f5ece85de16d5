// What this host says to a moteus drive and what the replies tell. See codec.hpp for contracts,
// README.md for sources.
#include "drivers/moteus/codec.hpp"

#include <algorithm>
#include <array>
#include <cmath>

#include "drivers/bus/bit_timing.hpp"

namespace geodesic::drivers::moteus {

namespace {

constexpr std::int64_t kTenMilliseconds = 10'000'000;
constexpr std::int64_t kMillisecond = 1'000'000;

void append_query(Frame& frame, const Formats& formats) noexcept {
  const std::array<Item, 7> asked = {
      Item{Register::kMode, Resolution::kInt8},    Item{Register::kPosition, formats.position},
      Item{Register::kVelocity, formats.velocity}, Item{Register::kTorque, formats.torque},
      Item{Register::kVoltage, Resolution::kInt8}, Item{Register::kTemperature, Resolution::kInt8},
      Item{Register::kFault, Resolution::kInt8}};
  append_reads(frame, std::span(asked).first(4));
  append_reads(frame, std::span(asked).subspan(formats.voltage ? 4 : 5));
}

/// A small integer, as a drive may have sent it in any resolution; 255 for what is none.
std::uint8_t byte_of(double value) noexcept {
  return value >= 0.0 && value <= 255.0 ? static_cast<std::uint8_t>(value) : std::uint8_t{255};
}

/// Whole tens of milliseconds fit into 8 bits up to 1.27 s.
Resolution timeout_resolution(const Formats& formats, std::int64_t watchdog_ns) noexcept {
  if (formats.torque == Resolution::kFloat) {
    return Resolution::kFloat;
  }
  return watchdog_ns % kTenMilliseconds == 0 && watchdog_ns / kTenMilliseconds <= 0x7F
             ? Resolution::kInt8
             : Resolution::kInt16;
}

}  // namespace

double watchdog_s(std::int64_t watchdog_ns) noexcept {
  const std::int64_t milliseconds = watchdog_ns / kMillisecond;
  return static_cast<double>(milliseconds) * 1e-3;
}

std::optional<Frame> encode_position(const Link& link, const Formats& formats,
                                     const PositionCommand& command, bool read_back) noexcept {
  const double position = command.position_rev.value_or(0.0);
  if (!std::isfinite(position) || !std::isfinite(command.velocity_rev_s) ||
      !std::isfinite(command.torque_nm) || !std::isfinite(command.kp_scale) ||
      !std::isfinite(command.kd_scale) || !std::isfinite(command.max_torque_nm)) {
    return std::nullopt;
  }
  const bool floats = formats.torque == Resolution::kFloat;
  const bool placed = command.position_rev.has_value();
  const bool moving = command.velocity_rev_s != 0.0;
  // NaN is as good in 8 bits; a position is worth more than 16.
  const Resolution place =
      floats ? Resolution::kFloat : (placed ? Resolution::kInt32 : Resolution::kInt8);
  const Resolution narrow = floats ? Resolution::kFloat : Resolution::kInt8;
  std::array<Item, 9> items = {
      Item{Register::kMode, Resolution::kInt8, static_cast<double>(Mode::kPosition)},
      Item{Register::kCommandPosition, place, placed ? position : std::nan("")},
      Item{Register::kCommandVelocity, formats.velocity, command.velocity_rev_s},
      Item{Register::kCommandTorque, formats.torque, command.torque_nm},
      Item{Register::kCommandKpScale, formats.scale, command.kp_scale},
      Item{Register::kCommandKdScale, formats.scale, command.kd_scale},
      Item{Register::kCommandMaxTorque, formats.torque, command.max_torque_nm},
      Item{Register::kCommandTimeout, timeout_resolution(formats, command.watchdog_ns),
           watchdog_s(command.watchdog_ns)},
      Item{Register::kCommandIlimitScale, narrow, 0.0}};
  std::span<Item> all(items);
  if (!floats && !moving) {  // not written, it is 0
    std::rotate(items.begin() + 2, items.begin() + 3, items.end());
    all = all.first(8);
  }
  Frame frame = make_frame(link.command());
  append_writes(frame, all);
  if (read_back) {
    // As floats: an integer that the drive computes back may come out one less.
    constexpr std::array kAsked = {Item{Register::kCommandMaxTorque, Resolution::kFloat},
                                   Item{Register::kCommandTimeout, Resolution::kFloat}};
    append_reads(frame, kAsked);
  }
  append_query(frame, formats);
  pad(frame);
  return frame;
}

std::size_t command_length(const Formats& formats, std::int64_t watchdog_ns) noexcept {
  PositionCommand command;
  command.watchdog_ns = watchdog_ns;
  const auto frame = encode_position({}, formats, command, false);
  return frame ? frame->length : 0U;
}

Frame encode_stop(const Link& link, const Formats& formats) noexcept {
  Frame frame = make_frame(link.command());
  const std::array<Item, 1> stop = {
      Item{Register::kMode, Resolution::kInt8, static_cast<double>(Mode::kStopped)}};
  append_writes(frame, stop);
  append_query(frame, formats);
  pad(frame);
  return frame;
}

Frame encode_query(const Link& link, const Formats& formats) noexcept {
  Frame frame = make_frame(link.command());
  append_query(frame, formats);
  pad(frame);
  return frame;
}

std::size_t reply_length(const Formats& formats) noexcept {
  Frame frame = make_frame({});
  append_query(frame, formats);
  Reader reader(frame);
  std::size_t length = frame.length;
  for (Entry entry; reader.next(entry);) {
    length += bytes_of(entry.resolution);
  }
  return can_length(length, true);
}

Frame encode_text(const Link& link, std::string_view line) noexcept {
  Frame frame = make_frame(link.command());
  append_text(frame, kDiagnosticChannel, line);
  pad(frame);
  return frame;
}

Frame encode_poll(const Link& link) noexcept {
  Frame frame = make_frame(link.command());
  append_poll(frame, kDiagnosticChannel);
  pad(frame);
  return frame;
}

StateReport decode_report(const Frame& frame) noexcept {
  StateReport report;
  Reader reader(frame);
  for (Entry entry; reader.next(entry);) {
    if (entry.kind != opcode::kReply) {
      continue;
    }
    switch (static_cast<Register>(entry.number)) {
      case Register::kMode:
        report.mode = byte_of(entry.value);
        break;
      case Register::kPosition:
        report.position_rev = entry.value;
        report.saturated = report.saturated || entry.saturated;
        break;
      case Register::kVelocity:
        report.velocity_rev_s = entry.value;
        report.saturated = report.saturated || entry.saturated;
        break;
      case Register::kTorque:
        report.torque_nm = entry.value;
        break;
      case Register::kTemperature:
        report.temperature_c = entry.value;
        break;
      case Register::kMotorTemperature:
        report.motor_c = entry.value;
        break;
      case Register::kFault:
        report.fault = byte_of(entry.value);
        break;
      default:
        break;
    }
  }
  return report;
}

}  // namespace geodesic::drivers::moteus
