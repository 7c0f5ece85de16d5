// RobStride and CyberGear frames in words for people; see family.hpp.
#include <fmt/format.h>

#include <utility>

#include "drivers/robstride/codec.hpp"
#include "drivers/robstride/family.hpp"
#include "drivers/robstride/settings.hpp"

namespace geodesic::drivers::robstride {

namespace {

DecodedField field(std::string name, double value, std::string unit) {
  return {std::move(name), fmt::format("{:.6g}", value), std::move(unit)};
}

const char* mode_name(std::uint8_t mode) {
  switch (static_cast<Mode>(mode)) {
    case Mode::kReset:
      return "reset";
    case Mode::kCalibration:
      return "calibration";
    case Mode::kRun:
      return "run";
  }
  return "unknown";
}

/// Names of the bits that are set, counted from `first` as error codes are.
std::string names(std::uint32_t bits, std::uint8_t first) {
  std::string all;
  for (unsigned bit = 0; bit < 32; ++bit) {
    if ((bits >> bit & 1U) != 0) {
      all.append(all.empty() ? "" : ", ")
          .append(error_name(static_cast<std::uint8_t>(first + bit)));
    }
  }
  return all.empty() ? "none" : all;
}

DecodedFrame control_words(const ControlCommand& command) {
  return {"operation control",
          {field("position", command.position_rad, "rad"),
           field("velocity", command.velocity_rad_s, "rad/s"),
           field("stiffness", command.stiffness_nm_rad, "N·m/rad"),
           field("damping", command.damping_nm_s_rad, "N·m·s/rad"),
           field("torque", command.torque_nm, "N·m")}};
}

DecodedFrame feedback_words(const Feedback& feedback) {
  return {"feedback",
          {{"mode", mode_name(feedback.mode), ""},
           {"faults", names(feedback.faults, 1), ""},
           field("position", feedback.position_rad, "rad"),
           field("velocity", feedback.velocity_rad_s, "rad/s"),
           field("torque", feedback.torque_nm, "N·m"),
           field("temperature", feedback.temperature_c, "°C")}};
}

/// A parameter by number and name, and its value where it says something.
DecodedFrame parameter_words(std::string kind, std::uint16_t index, std::uint32_t raw,
                             bool with_value) {
  DecodedFrame words{std::move(kind), {{"parameter", fmt::format("0x{:04X}", index), ""}}};
  const Parameter* fact = find_parameter(index);
  if (fact != nullptr) {
    words.fields.push_back({"name", fact->name, ""});
  }
  if (with_value) {
    const bool real = fact != nullptr && fact->value == Value::kFloat;
    words.fields.push_back(
        {"value", real ? fmt::format("{:.6g}", std::bit_cast<float>(raw)) : fmt::format("{}", raw),
         fact != nullptr ? fact->unit : ""});
  }
  return words;
}

std::optional<DecodedFrame> reply_words(const Frame& frame, const DriveOptions& options) {
  const Link link = link_of(options);
  const auto ours = [&link](const Link& other) {
    return other.motor == link.motor && other.host == link.host;
  };
  if (decode_identity(frame) == link.motor) {
    return DecodedFrame{"identity", {{"motor", fmt::format("{}", link.motor), ""}}};
  }
  if (const auto answer = decode_parameter(frame); answer && ours(answer->link)) {
    return parameter_words(answer->failed ? "parameter answer: refused" : "parameter answer",
                           answer->index, answer->raw, !answer->failed);
  }
  if (const auto report = decode_fault_report(frame); report && ours(report->link)) {
    return DecodedFrame{"fault report",
                        {{"faults", names(report->faults, kFirstReported), ""},
                         {"warnings", fmt::format("0x{:X}", report->warnings), ""}}};
  }
  const auto feedback = decode_feedback(frame, ranges_of(options));
  if (!feedback || !ours(feedback->link)) {
    return std::nullopt;
  }
  if (const auto version = decode_version(frame)) {
    return DecodedFrame{"version answer, or feedback that looks like it",
                        {{"version", fmt::format("{}", *version), ""}}};
  }
  return feedback_words(*feedback);
}

DecodedFrame stop_words(const Frame& frame) {
  if (frame.data[0] == 1) {
    return {"stop and clear faults", {}};
  }
  return {frame.data[1] == kVersionQuery[1] ? "stop and version query" : "stop", {}};
}

std::optional<DecodedFrame> command_words(const Frame& frame, const DriveOptions& options) {
  const auto index = static_cast<std::uint16_t>(frame.data[0] | frame.data[1] << 8U);
  std::uint32_t raw = 0;
  for (std::size_t i = 8; i-- > 4;) {
    raw = raw << 8U | frame.data[i];
  }
  switch (type_of(frame.id)) {
    case Type::kGetId:
      return DecodedFrame{"identity request", {}};
    case Type::kControl:
      if (const auto command = decode_control(frame, ranges_of(options))) {
        return control_words(*command);
      }
      return std::nullopt;
    case Type::kEnable:
      return DecodedFrame{"enable", {}};
    case Type::kStop:
      return stop_words(frame);
    case Type::kZero:
      return DecodedFrame{"set zero", {}};
    case Type::kSetId:
      return DecodedFrame{"set id",
                          {{"new id", fmt::format("{}", frame.id >> kFaultShift & 0xFFU), ""}}};
    case Type::kRead:
      return parameter_words("parameter read", index, 0, false);
    case Type::kWrite:
      return parameter_words("parameter write", index, raw, true);
    case Type::kSave:
      return DecodedFrame{"save parameters", {}};
    case Type::kBitRate:
      return DecodedFrame{"set bit rate", {{"code", fmt::format("{}", frame.data[6]), ""}}};
    case Type::kReport:
      return DecodedFrame{"reports by timer", {{"on", frame.data[6] != 0 ? "yes" : "no", ""}}};
    case Type::kProtocol:
      return DecodedFrame{"set protocol", {{"code", fmt::format("{}", frame.data[6]), ""}}};
    case Type::kFeedback:
    case Type::kFault:
      break;
  }
  return std::nullopt;
}

}  // namespace

std::optional<DecodedFrame> decode(const Frame& frame, const DriveOptions& options) {
  if (frame.error || !frame.extended || frame.fd || frame.remote || frame.length != 8) {
    return std::nullopt;
  }
  if ((frame.id & kDestinationMask) == options.id) {
    return command_words(frame, options);
  }
  return reply_words(frame, options);
}

}  // namespace geodesic::drivers::robstride
