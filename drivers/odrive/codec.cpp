// CANSimple frames <-> numbers: the host's arithmetic. See codec.hpp for contracts, README.md for
// sources.
#include "drivers/odrive/codec.hpp"

#include <algorithm>
#include <bit>
#include <cmath>
#include <cstring>
#include <limits>

namespace geodesic::drivers::odrive {

namespace {

constexpr std::uint8_t kSdoHead = 4;
constexpr double kMilli = 1e-3;

std::uint64_t load(const Frame& frame) noexcept {
  std::uint64_t word = 0;
  std::memcpy(&word, frame.data.data(), sizeof word);
  return std::endian::native == std::endian::little ? word : __builtin_bswap64(word);
}

void store(Frame& frame, std::uint64_t word) noexcept {
  word = std::endian::native == std::endian::little ? word : __builtin_bswap64(word);
  std::memcpy(frame.data.data(), &word, sizeof word);
}

Frame make_frame(std::uint32_t node, Command command, std::uint8_t length) noexcept {
  Frame frame;
  frame.id = frame_id(node, command);
  frame.length = length;
  return frame;
}

constexpr std::uint64_t mask_of(unsigned bits) noexcept {
  return bits >= 64 ? ~std::uint64_t{0} : (std::uint64_t{1} << bits) - 1U;
}

double clamped(double value, double low, double high) noexcept {
  return std::round(value < low ? low : (value > high ? high : value));
}

/// The field's bits; `value` is finite.
std::uint64_t bits_for(double value, Type type) noexcept {
  switch (type) {
    case Type::kF32:
      return std::bit_cast<std::uint32_t>(static_cast<float>(value));
    case Type::kI32:
      return static_cast<std::uint64_t>(
          static_cast<std::int64_t>(clamped(value, -2147483648.0, 2147483647.0)));
    case Type::kI16Milli:
      return static_cast<std::uint64_t>(
          static_cast<std::int64_t>(clamped(value / kMilli, -32768.0, 32767.0)));
    case Type::kU64: {
      constexpr double kMost = 18446744073709549568.0;  // the last double below 2^64
      return static_cast<std::uint64_t>(clamped(value, 0.0, kMost));
    }
    default:
      return static_cast<std::uint64_t>(
          clamped(value, 0.0, static_cast<double>(mask_of(bits_of(type)))));
  }
}

double value_of(std::uint64_t bits, Type type) noexcept {
  switch (type) {
    case Type::kF32:
      return static_cast<double>(std::bit_cast<float>(static_cast<std::uint32_t>(bits)));
    case Type::kI32:
      return static_cast<double>(static_cast<std::int32_t>(static_cast<std::uint32_t>(bits)));
    case Type::kI16Milli:
      return kMilli * static_cast<double>(static_cast<std::int16_t>(bits));
    default:
      return static_cast<double>(bits);
  }
}

}  // namespace

std::optional<Frame> encode(std::uint32_t node, const Message& message,
                            std::span<const double> values) noexcept {
  Frame frame = make_frame(node, message.command, message.length);
  std::uint64_t word = 0;
  for (std::size_t i = 0; i < message.count() && i < values.size(); ++i) {
    const Field& field = message.fields[i];
    const bool fits = std::abs(values[i]) <= static_cast<double>(std::numeric_limits<float>::max());
    if (!fits) {  // NaN among them
      return std::nullopt;
    }
    word |= (bits_for(values[i], field.type) & mask_of(bits_of(field.type))) << field.bit;
  }
  store(frame, word);
  return frame;
}

Frame encode_request(std::uint32_t node, Command command) noexcept {
  Frame frame = make_frame(node, command, 0);
  frame.remote = true;
  return frame;
}

std::optional<std::uint64_t> decode_bits(const Frame& frame, const Field& field) noexcept {
  const unsigned bits = bits_of(field.type);
  if (frame.remote || field.bit + bits > 8U * std::min<unsigned>(frame.length, 8U)) {
    return std::nullopt;
  }
  return load(frame) >> field.bit & mask_of(bits);
}

std::optional<double> decode(const Frame& frame, const Field& field) noexcept {
  const std::optional<std::uint64_t> bits = decode_bits(frame, field);
  return bits ? std::optional(value_of(*bits, field.type)) : std::nullopt;
}

Frame encode_sdo_read(std::uint32_t node, std::uint16_t endpoint) noexcept {
  Frame frame = make_frame(node, Command::kRxSdo, kSdoHead);
  store(frame, std::uint64_t{endpoint} << 8U | kSdoRead);
  return frame;
}

Frame encode_sdo_write(std::uint32_t node, std::uint16_t endpoint, ParameterType type,
                       double value) noexcept {
  Frame frame =
      make_frame(node, Command::kRxSdo,
                 static_cast<std::uint8_t>(kSdoHead + (type == ParameterType::kBool ? 1 : 4)));
  const std::uint64_t raw = type == ParameterType::kFloat  ? bits_for(value, Type::kF32)
                            : type == ParameterType::kBool ? (value != 0.0 ? 1U : 0U)
                                                           : bits_for(value, Type::kU32);
  store(frame, raw << 32U | std::uint64_t{endpoint} << 8U | kSdoWrite);
  return frame;
}

std::optional<Sdo> decode_sdo(const Frame& frame) noexcept {
  if (frame.remote || frame.length < kSdoHead || frame.length > 8) {
    return std::nullopt;
  }
  const auto bytes = static_cast<std::uint8_t>(frame.length - kSdoHead);
  const std::uint64_t word = load(frame);
  return Sdo{.endpoint = static_cast<std::uint16_t>(word >> 8U & 0xFFFFU),
             .raw = static_cast<std::uint32_t>(word >> 32U & mask_of(8U * bytes)),
             .bytes = bytes};
}

double sdo_value(const Sdo& sdo, ParameterType type) noexcept {
  return type == ParameterType::kFloat  ? value_of(sdo.raw, Type::kF32)
         : type == ParameterType::kBool ? static_cast<double>(sdo.raw & 0xFFU)
                                        : static_cast<double>(sdo.raw);
}

}  // namespace geodesic::drivers::odrive
