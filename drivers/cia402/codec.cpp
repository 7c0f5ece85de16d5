// CANopen frames <-> numbers; see codec.hpp. Sources: README.md.
#include "drivers/cia402/codec.hpp"

#include <algorithm>
#include <cmath>

namespace geodesic::drivers::cia402 {

namespace {

Frame frame_of(std::uint32_t id, std::uint8_t length) noexcept {
  Frame frame;
  frame.id = id;
  frame.length = length;
  return frame;
}

void put(Frame& frame, std::size_t at, std::uint32_t value, std::size_t bytes) noexcept {
  for (std::size_t i = 0; i < bytes; ++i) {
    frame.data[at + i] = static_cast<std::uint8_t>(value >> (8U * i) & 0xFFU);
  }
}

std::uint32_t take(const Frame& frame, std::size_t at, std::size_t bytes) noexcept {
  std::uint32_t value = 0;
  for (std::size_t i = bytes; i > 0; --i) {
    value = value << 8U | frame.data[at + i - 1];
  }
  return value;
}

/// A classic data frame of that many bytes.
bool plain(const Frame& frame, std::size_t bytes) noexcept {
  return !frame.error && !frame.remote && !frame.extended && !frame.fd && frame.length == bytes;
}

Frame sdo_frame(std::uint32_t id, std::uint8_t command, const Object& object) noexcept {
  Frame frame = frame_of(id, 8);
  frame.data[0] = command;
  put(frame, 1, object.index, 2);
  frame.data[3] = object.sub;
  return frame;
}

std::uint8_t with_size(std::uint8_t command, std::uint8_t bytes) noexcept {
  return static_cast<std::uint8_t>(command | (4U - bytes) << sdo::kUnusedShift);
}

/// Bytes an expedited transfer of this first byte carries; 4 if it does not say.
std::uint8_t size_of(std::uint8_t command) noexcept {
  const unsigned unused = command >> sdo::kUnusedShift & 3U;
  return static_cast<std::uint8_t>((command & 1U) != 0 ? 4U - unused : 0U);
}

Sdo sdo_of(const Frame& frame, Sdo::Kind kind) noexcept {
  Sdo message;
  message.kind = kind;
  message.index = static_cast<std::uint16_t>(take(frame, 1, 2));
  message.sub = frame.data[3];
  if (kind == Sdo::Kind::kAbort) {
    message.value = take(frame, 4, 4);
  } else if (kind == Sdo::Kind::kReadReply || kind == Sdo::Kind::kWrite) {
    message.bytes = size_of(frame.data[0]);
    message.value = take(frame, 4, message.bytes == 0 ? 4 : message.bytes);
  }
  return message;
}

constexpr std::uint8_t kTransferBits = 0xE0;
constexpr std::uint8_t kExpeditedBit = 0x02;

}  // namespace

Frame encode_nmt(const NmtRequest& request) noexcept {
  Frame frame = frame_of(cob::kNmt, 2);
  frame.data[0] = static_cast<std::uint8_t>(request.command);
  frame.data[1] = request.node;
  return frame;
}

std::optional<NmtRequest> decode_nmt(const Frame& frame) noexcept {
  if (!plain(frame, 2) || frame.id != cob::kNmt) {
    return std::nullopt;
  }
  return NmtRequest{static_cast<NmtCommand>(frame.data[0]), frame.data[1]};
}

Frame encode_sync() noexcept {
  return frame_of(cob::kSync, 0);
}

bool decode_sync(const Frame& frame) noexcept {
  return frame.id == cob::kSync && (plain(frame, 0) || plain(frame, 1));
}

Frame encode_heartbeat(std::uint32_t node, NmtState state) noexcept {
  Frame frame = frame_of(cob::kHeartbeat + node, 1);
  frame.data[0] = static_cast<std::uint8_t>(state);
  return frame;
}

std::optional<NmtState> decode_heartbeat(const Frame& frame) noexcept {
  if (!plain(frame, 1)) {
    return std::nullopt;
  }
  return static_cast<NmtState>(frame.data[0] & 0x7FU);
}

Frame encode_read(std::uint32_t node, const Object& object) noexcept {
  return sdo_frame(cob::kSdoRequest + node, sdo::kRead, object);
}

Frame encode_write(std::uint32_t node, const Object& object, std::uint32_t value) noexcept {
  Frame frame = sdo_frame(cob::kSdoRequest + node, with_size(sdo::kWrite4, object.bytes), object);
  put(frame, 4, value, object.bytes);
  return frame;
}

Frame encode_abort(std::uint32_t node, const Object& object, Abort code) noexcept {
  Frame frame = sdo_frame(cob::kSdoReply + node, sdo::kAbort, object);
  put(frame, 4, static_cast<std::uint32_t>(code), 4);
  return frame;
}

Frame encode_read_reply(std::uint32_t node, const Object& object, std::uint32_t value) noexcept {
  Frame frame = sdo_frame(cob::kSdoReply + node, with_size(sdo::kReadReply4, object.bytes), object);
  put(frame, 4, value, object.bytes);
  return frame;
}

Frame encode_write_reply(std::uint32_t node, const Object& object) noexcept {
  return sdo_frame(cob::kSdoReply + node, sdo::kWriteReply, object);
}

std::optional<Sdo> decode_sdo_request(const Frame& frame) noexcept {
  if (!plain(frame, 8)) {
    return std::nullopt;
  }
  const std::uint8_t command = frame.data[0];
  if (command == sdo::kAbort) {
    return sdo_of(frame, Sdo::Kind::kAbort);
  }
  if ((command & kTransferBits) == sdo::kRead) {
    return sdo_of(frame, Sdo::Kind::kRead);
  }
  if ((command & kTransferBits) == (sdo::kWrite4 & kTransferBits) &&
      (command & kExpeditedBit) != 0) {
    return sdo_of(frame, Sdo::Kind::kWrite);
  }
  return std::nullopt;
}

std::optional<Sdo> decode_sdo_reply(const Frame& frame) noexcept {
  if (!plain(frame, 8)) {
    return std::nullopt;
  }
  const std::uint8_t command = frame.data[0];
  if (command == sdo::kAbort) {
    return sdo_of(frame, Sdo::Kind::kAbort);
  }
  if (command == sdo::kWriteReply) {
    return sdo_of(frame, Sdo::Kind::kWriteReply);
  }
  if ((command & kTransferBits) == (sdo::kReadReply4 & kTransferBits) &&
      (command & kExpeditedBit) != 0) {
    return sdo_of(frame, Sdo::Kind::kReadReply);
  }
  return std::nullopt;
}

Frame encode_torque(std::uint32_t node, const TorqueCommand& command) noexcept {
  Frame frame = frame_of(cob::kReceive1 + node, 4);
  put(frame, 0, command.controlword, 2);
  put(frame, 2, static_cast<std::uint16_t>(command.torque_permille), 2);
  return frame;
}

std::optional<TorqueCommand> decode_torque(const Frame& frame) noexcept {
  if (!plain(frame, 4)) {
    return std::nullopt;
  }
  return TorqueCommand{static_cast<std::uint16_t>(take(frame, 0, 2)),
                       static_cast<std::int16_t>(take(frame, 2, 2))};
}

Frame encode_report(std::uint32_t node, const Report& report) noexcept {
  Frame frame = frame_of(cob::kTransmit1 + node, 8);
  put(frame, 0, report.statusword, 2);
  put(frame, 2, static_cast<std::uint32_t>(report.position), 4);
  put(frame, 6, static_cast<std::uint16_t>(report.torque_permille), 2);
  return frame;
}

std::optional<Report> decode_report(const Frame& frame) noexcept {
  if (!plain(frame, 8)) {
    return std::nullopt;
  }
  return Report{static_cast<std::uint16_t>(take(frame, 0, 2)),
                static_cast<std::int32_t>(take(frame, 2, 4)),
                static_cast<std::int16_t>(take(frame, 6, 2))};
}

Frame encode_velocity(std::uint32_t node, std::int32_t velocity) noexcept {
  Frame frame = frame_of(cob::kTransmit2 + node, 4);
  put(frame, 0, static_cast<std::uint32_t>(velocity), 4);
  return frame;
}

std::optional<std::int32_t> decode_velocity(const Frame& frame) noexcept {
  if (!plain(frame, 4)) {
    return std::nullopt;
  }
  return static_cast<std::int32_t>(take(frame, 0, 4));
}

Frame encode_emergency(std::uint32_t node, const Emergency& emergency) noexcept {
  Frame frame = frame_of(cob::kEmergency + node, 8);
  put(frame, 0, emergency.code, 2);
  frame.data[2] = emergency.error_register;
  return frame;
}

std::optional<Emergency> decode_emergency(const Frame& frame) noexcept {
  if (!plain(frame, 8)) {
    return std::nullopt;
  }
  return Emergency{static_cast<std::uint16_t>(take(frame, 0, 2)), frame.data[2]};
}

std::optional<PowerState> power_state(std::uint16_t statusword) noexcept {
  for (const PowerStateBits& one : kPowerStates) {
    if ((statusword & one.mask) == one.bits) {
      return one.state;
    }
  }
  return std::nullopt;
}

const char* power_state_name(PowerState state) noexcept {
  return kPowerStates[static_cast<std::size_t>(state)].name;
}

std::uint16_t next_towards_enabled(PowerState state) noexcept {
  switch (state) {
    case PowerState::kSwitchOnDisabled:
      return control_word::kShutdown;
    case PowerState::kReady:
      return control_word::kSwitchOn;
    case PowerState::kSwitchedOn:
    case PowerState::kEnabled:
      return control_word::kEnableOperation;
    case PowerState::kNotReady:
    case PowerState::kQuickStop:
    case PowerState::kFaultReaction:
    case PowerState::kFault:
      break;
  }
  return control_word::kDisableVoltage;
}

std::optional<std::int16_t> to_permille(double torque_nm, double rated_nm,
                                        std::int16_t limit_permille) noexcept {
  const double exact = torque_nm / rated_nm * 1e3;
  if (!std::isfinite(exact)) {
    return std::nullopt;
  }
  const double limit = limit_permille;
  return static_cast<std::int16_t>(std::lround(std::clamp(exact, -limit, limit)));
}

}  // namespace geodesic::drivers::cia402
