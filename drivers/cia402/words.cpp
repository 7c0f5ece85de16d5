// CANopen frames in words for people; see family.hpp.
#include <fmt/format.h>

#include <utility>

#include "drivers/cia402/codec.hpp"
#include "drivers/cia402/errors.hpp"
#include "drivers/cia402/family.hpp"
#include "drivers/cia402/settings.hpp"

namespace geodesic::drivers::cia402 {

namespace {

DecodedField field(std::string name, double value, std::string unit) {
  return {std::move(name), fmt::format("{:.6g}", value), std::move(unit)};
}

DecodedField state_field(std::uint16_t statusword) {
  const std::optional<PowerState> state = power_state(statusword);
  return {"state", state ? power_state_name(*state) : fmt::format("none (0x{:04X})", statusword),
          ""};
}

const char* nmt_name(NmtCommand command) {
  switch (command) {
    case NmtCommand::kStart:
      return "start";
    case NmtCommand::kStop:
      return "stop";
    case NmtCommand::kPreOperational:
      return "enter pre-operational";
    case NmtCommand::kResetNode:
      return "reset node";
    case NmtCommand::kResetCommunication:
      return "reset communication";
  }
  return "unknown command";
}

const char* nmt_name(NmtState state) {
  switch (state) {
    case NmtState::kBootUp:
      return "boot-up";
    case NmtState::kStopped:
      return "stopped";
    case NmtState::kOperational:
      return "operational";
    case NmtState::kPreOperational:
      return "pre-operational";
  }
  return "unknown";
}

DecodedFrame sdo_words(const Sdo& sdo) {
  const std::string object = fmt::format("0x{:04X}:{}", sdo.index, sdo.sub);
  DecodedFrame words{"", {{"object", object, ""}}};
  switch (sdo.kind) {
    case Sdo::Kind::kRead:
      words.kind = "SDO read";
      break;
    case Sdo::Kind::kReadReply:
      words.kind = "SDO read reply";
      break;
    case Sdo::Kind::kWrite:
      words.kind = "SDO write";
      break;
    case Sdo::Kind::kWriteReply:
      words.kind = "SDO write reply";
      break;
    case Sdo::Kind::kAbort:
      words.kind = "SDO abort";
      words.fields.push_back({"code", fmt::format("0x{:08X}", sdo.value), ""});
      words.fields.push_back({"meaning", abort_meaning(sdo.value), ""});
      return words;
  }
  if (sdo.kind == Sdo::Kind::kReadReply || sdo.kind == Sdo::Kind::kWrite) {
    words.fields.push_back({"value", fmt::format("{}", sdo.value), ""});
    words.fields.push_back({"bytes", fmt::format("{}", sdo.bytes), ""});
  }
  return words;
}

/// @return nothing if the bytes are not those of an expedited transfer.
std::optional<DecodedFrame> maybe_sdo(const std::optional<Sdo>& sdo) {
  return sdo ? sdo_words(*sdo) : DecodedFrame{"SDO segment or block", {}};
}

std::optional<DecodedFrame> decode_shared(const Frame& frame, const DriveOptions& options) {
  if (const auto nmt = decode_nmt(frame); nmt && (nmt->node == 0 || nmt->node == options.id)) {
    return DecodedFrame{fmt::format("NMT {}", nmt_name(nmt->command)), {}};
  }
  if (decode_sync(frame)) {
    return DecodedFrame{"SYNC", {}};
  }
  if (frame.id == cob::kHeartbeat + integer(options, Setting::kHostNode)) {
    if (const auto state = decode_heartbeat(frame)) {
      return DecodedFrame{"host's heartbeat", {{"state", nmt_name(*state), ""}}};
    }
  }
  return std::nullopt;
}

}  // namespace

std::optional<DecodedFrame> decode(const Frame& frame, const DriveOptions& options) {
  if (frame.error || frame.extended || frame.fd || frame.remote) {
    return std::nullopt;
  }
  const Units units(options);
  const std::uint32_t node = options.id;
  if (frame.id == cob::kReceive1 + node) {
    if (const auto command = decode_torque(frame)) {
      return DecodedFrame{
          "torque command",
          {{"controlword", fmt::format("0x{:04X}", command->controlword), ""},
           field("torque", from_permille(command->torque_permille, units.rated_nm), "N·m")}};
    }
  } else if (frame.id == cob::kTransmit1 + node) {
    if (const auto report = decode_report(frame)) {
      return DecodedFrame{
          "state",
          {state_field(report->statusword),
           field("position", report->position * units.rad_per_increment, "rad"),
           field("torque", from_permille(report->torque_permille, units.rated_nm), "N·m")}};
    }
  } else if (frame.id == cob::kTransmit2 + node) {
    if (const auto velocity = decode_velocity(frame); velocity && units.rad_s_per_velocity > 0.0) {
      return DecodedFrame{"velocity",
                          {field("velocity", *velocity * units.rad_s_per_velocity, "rad/s")}};
    }
  } else if (frame.id == cob::kSdoRequest + node && frame.length == 8) {
    return maybe_sdo(decode_sdo_request(frame));
  } else if (frame.id == cob::kSdoReply + node && frame.length == 8) {
    return maybe_sdo(decode_sdo_reply(frame));
  } else if (frame.id == cob::kEmergency + node) {
    if (const auto emergency = decode_emergency(frame)) {
      const std::uint8_t error = error_of(emergency->code);
      return DecodedFrame{"emergency",
                          {{"code", fmt::format("0x{:04X}", emergency->code), ""},
                           {"error", error == 0 ? "none: cleared" : error_name(error), ""},
                           {"register", fmt::format("0x{:02X}", emergency->error_register), ""}}};
    }
  } else if (frame.id == cob::kHeartbeat + node) {
    if (const auto state = decode_heartbeat(frame)) {
      return *state == NmtState::kBootUp
                 ? DecodedFrame{"boot-up", {}}
                 : DecodedFrame{"heartbeat", {{"state", nmt_name(*state), ""}}};
    }
  }
  return decode_shared(frame, options);
}

}  // namespace geodesic::drivers::cia402
