// RobStride and CyberGear frames <-> numbers: the host's arithmetic. See codec.hpp for contracts,
// README.md for sources.
#include "drivers/robstride/codec.hpp"

#include <algorithm>
#include <cmath>

namespace geodesic::drivers::robstride {

namespace {

Frame make_frame(Type type, std::uint32_t data, std::uint32_t to) noexcept {
  Frame frame;
  frame.id = identifier(type, data, to);
  frame.extended = true;
  frame.length = 8;
  return frame;
}

bool is(const Frame& frame, Type type) noexcept {
  return frame.extended && !frame.fd && !frame.remote && !frame.error && frame.length == 8 &&
         type_of(frame.id) == type;
}

void store_big(Frame& frame, unsigned at, std::uint16_t code) noexcept {
  frame.data[at] = static_cast<std::uint8_t>(code >> 8U);
  frame.data[at + 1] = static_cast<std::uint8_t>(code & 0xFFU);
}

std::uint16_t load_big(const Frame& frame, unsigned at) noexcept {
  return static_cast<std::uint16_t>(frame.data[at] << 8U | frame.data[at + 1]);
}

void store_little(Frame& frame, unsigned at, std::uint32_t value, unsigned bytes) noexcept {
  for (unsigned i = 0; i < bytes; ++i) {
    frame.data[at + i] = static_cast<std::uint8_t>(value >> (8U * i) & 0xFFU);
  }
}

std::uint32_t load_little(const Frame& frame, unsigned at, unsigned bytes) noexcept {
  std::uint32_t value = 0;
  for (unsigned i = bytes; i-- > 0;) {
    value = value << 8U | frame.data[at + i];
  }
  return value;
}

/// What the drive sends: the motor in data16's low byte, the host in the destination.
Link link_of(std::uint32_t id) noexcept {
  return {.motor = static_cast<std::uint8_t>(id >> kDataShift & 0xFFU),
          .host = static_cast<std::uint8_t>(id & kDestinationMask)};
}

}  // namespace

std::optional<Frame> encode_control(std::uint8_t motor, const ControlCommand& command,
                                    const Ranges& ranges) noexcept {
  if (!std::isfinite(command.position_rad) || !std::isfinite(command.velocity_rad_s) ||
      !std::isfinite(command.stiffness_nm_rad) || !std::isfinite(command.damping_nm_s_rad) ||
      !std::isfinite(command.torque_nm)) {
    return std::nullopt;
  }
  const auto both_ways = [](double value, double range) { return to_code(value, -range, range); };
  Frame frame = make_frame(Type::kControl, both_ways(command.torque_nm, ranges.torque_nm), motor);
  store_big(frame, control_bytes::kPosition, both_ways(command.position_rad, ranges.position_rad));
  store_big(frame, control_bytes::kVelocity,
            both_ways(command.velocity_rad_s, ranges.velocity_rad_s));
  store_big(frame, control_bytes::kStiffness,
            to_code(command.stiffness_nm_rad, 0.0, ranges.stiffness_nm_rad));
  store_big(frame, control_bytes::kDamping,
            to_code(command.damping_nm_s_rad, 0.0, ranges.damping_nm_s_rad));
  return frame;
}

std::optional<ControlCommand> decode_control(const Frame& frame, const Ranges& ranges) noexcept {
  if (!is(frame, Type::kControl)) {
    return std::nullopt;
  }
  const auto both_ways = [](std::uint32_t code, double range) {
    return from_code(code, -range, range);
  };
  return ControlCommand{
      .position_rad = both_ways(load_big(frame, control_bytes::kPosition), ranges.position_rad),
      .velocity_rad_s = both_ways(load_big(frame, control_bytes::kVelocity), ranges.velocity_rad_s),
      .stiffness_nm_rad =
          from_code(load_big(frame, control_bytes::kStiffness), 0.0, ranges.stiffness_nm_rad),
      .damping_nm_s_rad =
          from_code(load_big(frame, control_bytes::kDamping), 0.0, ranges.damping_nm_s_rad),
      .torque_nm = both_ways(frame.id >> kDataShift & 0xFFFFU, ranges.torque_nm),
  };
}

std::optional<Feedback> decode_feedback(const Frame& frame, const Ranges& ranges) noexcept {
  if (!is(frame, Type::kFeedback)) {
    return std::nullopt;
  }
  const auto both_ways = [&frame](unsigned at, double range) {
    return from_code(load_big(frame, at), -range, range);
  };
  const std::uint16_t position = load_big(frame, feedback_bytes::kPosition);
  return Feedback{
      .link = link_of(frame.id),
      .mode = static_cast<std::uint8_t>(frame.id >> kModeShift & 3U),
      .faults = static_cast<std::uint8_t>(frame.id >> kFaultShift & ((1U << kFaultBits) - 1U)),
      .at_end = position == 0 || position == 0xFFFF,
      .position_rad = both_ways(feedback_bytes::kPosition, ranges.position_rad),
      .velocity_rad_s = both_ways(feedback_bytes::kVelocity, ranges.velocity_rad_s),
      .torque_nm = both_ways(feedback_bytes::kTorque, ranges.torque_nm),
      .temperature_c = load_big(frame, feedback_bytes::kTemperature) / 10.0,
  };
}

std::optional<ParameterAnswer> decode_parameter(const Frame& frame) noexcept {
  if (!is(frame, Type::kRead)) {
    return std::nullopt;
  }
  return ParameterAnswer{.link = link_of(frame.id),
                         .failed = (frame.id >> kFaultShift & 0xFFU) != 0,
                         .index = static_cast<std::uint16_t>(load_little(frame, 0, 2)),
                         .raw = load_little(frame, 4, 4)};
}

std::optional<FaultReport> decode_fault_report(const Frame& frame) noexcept {
  if (!is(frame, Type::kFault)) {
    return std::nullopt;
  }
  return FaultReport{.link = link_of(frame.id),
                     .faults = load_little(frame, 0, 4),
                     .warnings = load_little(frame, 4, 4)};
}

std::optional<std::uint8_t> decode_identity(const Frame& frame) noexcept {
  if (!is(frame, Type::kGetId) || (frame.id & kDestinationMask) != kIdentityDestination ||
      (frame.id >> kDataShift & 0xFFFFU) > kLastMotor) {
    return std::nullopt;
  }
  return link_of(frame.id).motor;
}

std::optional<std::uint32_t> decode_version(const Frame& frame) noexcept {
  if (!is(frame, Type::kFeedback) ||
      !std::equal(kVersionAnswer.begin(), kVersionAnswer.end(), frame.data.begin())) {
    return std::nullopt;
  }
  std::uint32_t version = 0;
  for (unsigned i = kVersionAnswer.size(); i < kVersionAnswer.size() + 4; ++i) {
    version = version * 100U + std::min<std::uint32_t>(frame.data[i], 99U);
  }
  return version;
}

Frame encode_get_id(const Link& link) noexcept {
  return make_frame(Type::kGetId, link.host, link.motor);
}

Frame encode_enable(const Link& link) noexcept {
  return make_frame(Type::kEnable, link.host, link.motor);
}

Frame encode_stop(const Link& link, bool clear_faults) noexcept {
  Frame frame = make_frame(Type::kStop, link.host, link.motor);
  frame.data[0] = clear_faults ? 1 : 0;
  return frame;
}

Frame encode_version_query(const Link& link) noexcept {
  Frame frame = make_frame(Type::kStop, link.host, link.motor);
  std::copy(kVersionQuery.begin(), kVersionQuery.end(), frame.data.begin());
  return frame;
}

Frame encode_zero(const Link& link) noexcept {
  Frame frame = make_frame(Type::kZero, link.host, link.motor);
  frame.data[0] = 1;
  return frame;
}

Frame encode_set_id(const Link& link, std::uint8_t motor) noexcept {
  return make_frame(Type::kSetId, static_cast<std::uint32_t>(motor) << 8U | link.host, link.motor);
}

Frame encode_read(const Link& link, std::uint16_t index) noexcept {
  Frame frame = make_frame(Type::kRead, link.host, link.motor);
  store_little(frame, 0, index, 2);
  return frame;
}

Frame encode_write(const Link& link, std::uint16_t index, std::uint32_t raw) noexcept {
  Frame frame = make_frame(Type::kWrite, link.host, link.motor);
  store_little(frame, 0, index, 2);
  store_little(frame, 4, raw, 4);
  return frame;
}

Frame encode_save(const Link& link) noexcept {
  Frame frame = make_frame(Type::kSave, link.host, link.motor);
  std::copy(kStaircase.begin(), kStaircase.end(), frame.data.begin());
  return frame;
}

Frame encode_reports(const Link& link, bool on) noexcept {
  Frame frame = make_frame(Type::kReport, link.host, link.motor);
  std::copy_n(kStaircase.begin(), 6, frame.data.begin());
  frame.data[6] = on ? 1 : 0;
  return frame;
}

}  // namespace geodesic::drivers::robstride
