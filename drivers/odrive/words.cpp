// CANSimple frames in words; see words.hpp.
#include "drivers/odrive/words.hpp"

#include <fmt/format.h>

#include <string>

#include "drivers/odrive/codec.hpp"
#include "drivers/odrive/errors.hpp"
#include "drivers/odrive/settings.hpp"

namespace geodesic::drivers::odrive {

namespace {

/// All errors of a word, each in words.
std::string errors_of(std::uint64_t word, std::uint8_t base) {
  std::string text;
  for (; word != 0; word &= word - 1) {
    text += text.empty() ? "" : ", ";
    text += error_name(code_of(word, base));
  }
  return text.empty() ? "none" : text;
}

/// The base of the codes of an error word; 0: the field is none.
std::uint8_t base_of(const Message& message, std::size_t index) {
  if (&message == &kError06 || (&message == &kHeartbeat06 && index == 0)) {
    return kActiveBase;
  }
  if (&message == &kHeartbeat05 && index == 0) {
    return kAxisBase;
  }
  return &message == &kMotorError05        ? kMotorBase
         : &message == &kEncoderError05    ? kEncoderBase
         : &message == &kControllerError05 ? kControllerBase
                                           : std::uint8_t{0};
}

std::string value_text(const Message& message, std::size_t index, std::uint64_t bits,
                       double value) {
  if (const std::uint8_t base = base_of(message, index); base != 0) {
    return errors_of(bits, base);
  }
  const bool state = (message.command == Command::kHeartbeat && index == 1) ||
                     message.command == Command::kAxisState;
  if (state && value < 256.0) {
    return state_name(static_cast<std::uint8_t>(value));
  }
  if (&message == &kHeartbeat06 && index == 2) {
    return result_name(static_cast<std::uint8_t>(value));
  }
  const Type type = message.fields[index].type;
  return type == Type::kF32 || type == Type::kI16Milli ? fmt::format("{:.6g}", value)
                                                       : fmt::format("{:.0f}", value);
}

}  // namespace

std::optional<DecodedFrame> decode(const Frame& frame, const DriveOptions& options) {
  if (frame.error || frame.extended || frame.fd || node_of(frame) != options.id) {
    return std::nullopt;
  }
  const Firmware firmware = Settings(options).firmware;
  const Message* message = find_message(firmware, frame.id & kCommandMask);
  if (message == nullptr && frame.remote) {  // what 0.5 never answers is asked for all the same
    message = find_message(firmware == Firmware::k06 ? Firmware::k05 : Firmware::k06,
                           frame.id & kCommandMask);
  }
  if (message == nullptr) {
    return std::nullopt;
  }
  if (frame.remote || (message->report && frame.length == 0)) {
    return DecodedFrame{fmt::format("{} request", message->name), {}};
  }
  DecodedFrame words{message->name, {}};
  for (std::size_t i = 0; i < message->count(); ++i) {
    const Field& field = message->fields[i];
    const std::optional<std::uint64_t> bits = decode_bits(frame, field);
    const std::optional<double> value = decode(frame, field);
    if (!bits || !value) {
      continue;
    }
    words.fields.push_back({field.name, value_text(*message, i, *bits, *value), field.unit});
    const bool sdo = message == &kRxSdo06 || message == &kTxSdo06;
    if (sdo && field.type == Type::kF32) {
      words.fields.push_back({"raw", fmt::format("0x{:X}", decode_sdo(frame)->raw), ""});
    }
  }
  return words;
}

}  // namespace geodesic::drivers::odrive
