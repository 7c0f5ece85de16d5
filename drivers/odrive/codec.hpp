// CANSimple frames <-> numbers, for the host: pure functions, nothing remembered, nothing sent.
// Which frame is due when is the driver's business (driver.hpp).
// Real-time throughout. An encoder refuses what is not finite, clamps integers to their field and
// rounds them to the nearest (the vendor's encoder truncates).
#pragma once

#include <cstdint>
#include <initializer_list>
#include <optional>
#include <span>

#include "drivers/bus/frame.hpp"
#include "drivers/odrive/messages.hpp"

namespace geodesic::drivers::odrive {

constexpr std::uint32_t frame_id(std::uint32_t node, Command command) noexcept {
  return node << kCommandBits | static_cast<std::uint32_t>(command);
}
constexpr std::uint32_t node_of(const Frame& frame) noexcept {
  return frame.id >> kCommandBits;
}
constexpr Command command_of(const Frame& frame) noexcept {
  return static_cast<Command>(frame.id & kCommandMask);
}

/// `values` in the order of the message's fields; missing ones are 0. Nothing if one is not finite,
/// or no float32 can hold it.
std::optional<Frame> encode(std::uint32_t node, const Message& message,
                            std::span<const double> values) noexcept;
inline std::optional<Frame> encode(std::uint32_t node, const Message& message,
                                   std::initializer_list<double> values) noexcept {
  return encode(node, message, std::span(values.begin(), values.size()));
}

/// A remote frame: asks for the message of that command.
Frame encode_request(std::uint32_t node, Command command) noexcept;

/// The field's bits as they are: what counts of an error word, of which a double may lose some.
/// Nothing if the frame is too short for it.
std::optional<std::uint64_t> decode_bits(const Frame& frame, const Field& field) noexcept;

/// The field's value; nothing if the frame is too short for it. NaN where the drive sent one.
std::optional<double> decode(const Frame& frame, const Field& field) noexcept;

/// RxSdo and TxSdo: an endpoint and up to four bytes of value.
struct Sdo {
  std::uint16_t endpoint = 0;
  std::uint32_t raw = 0;
  std::uint8_t bytes = 0;  ///< of value
};
Frame encode_sdo_read(std::uint32_t node, std::uint16_t endpoint) noexcept;
Frame encode_sdo_write(std::uint32_t node, std::uint16_t endpoint, ParameterType type,
                       double value) noexcept;
/// Nothing if the frame is too short to name an endpoint.
std::optional<Sdo> decode_sdo(const Frame& frame) noexcept;
double sdo_value(const Sdo& sdo, ParameterType type) noexcept;

}  // namespace geodesic::drivers::odrive
