// CANopen frames <-> numbers, for the host: pure functions, nothing remembered, nothing sent. Units
// are the drive's own (units.hpp turns them into SI); which frame is due when is driver.hpp's.
// Real-time throughout.
#pragma once

#include <cstdint>
#include <optional>

#include "drivers/bus/frame.hpp"
#include "drivers/cia402/layout.hpp"

namespace geodesic::drivers::cia402 {

struct NmtRequest {
  NmtCommand command = NmtCommand::kStart;
  std::uint8_t node = 0;  ///< 0: all
  bool operator==(const NmtRequest&) const = default;
};

/// An expedited SDO frame of either direction.
struct Sdo {
  enum class Kind : std::uint8_t { kRead, kReadReply, kWrite, kWriteReply, kAbort };
  Kind kind = Kind::kRead;
  std::uint16_t index = 0;
  std::uint8_t sub = 0;
  std::uint8_t bytes = 0;   ///< of value; 0 where there is none or the sender does not say
  std::uint32_t value = 0;  ///< little-endian, zero-extended; with kAbort, the code
  bool operator==(const Sdo&) const = default;
};

/// RPDO1 as start-up maps it.
struct TorqueCommand {
  std::uint16_t controlword = 0;
  std::int16_t torque_permille = 0;
  bool operator==(const TorqueCommand&) const = default;
};

/// TPDO1 as start-up maps it.
struct Report {
  std::uint16_t statusword = 0;
  std::int32_t position = 0;
  std::int16_t torque_permille = 0;
  bool operator==(const Report&) const = default;
};

struct Emergency {
  std::uint16_t code = 0;
  std::uint8_t error_register = 0;
  bool operator==(const Emergency&) const = default;
};

Frame encode_nmt(const NmtRequest& request) noexcept;
std::optional<NmtRequest> decode_nmt(const Frame& frame) noexcept;

Frame encode_sync() noexcept;
/// With or without its counter.
bool decode_sync(const Frame& frame) noexcept;

/// Of `node` in `state`; boot-up looks the same with state 0.
Frame encode_heartbeat(std::uint32_t node, NmtState state) noexcept;
/// The state without its toggle bit; nothing if the frame is no heartbeat.
std::optional<NmtState> decode_heartbeat(const Frame& frame) noexcept;

Frame encode_read(std::uint32_t node, const Object& object) noexcept;
/// The low object.bytes of `value`.
Frame encode_write(std::uint32_t node, const Object& object, std::uint32_t value) noexcept;
Frame encode_abort(std::uint32_t node, const Object& object, Abort code) noexcept;
/// The answer to a read or a write, as a drive gives it.
Frame encode_read_reply(std::uint32_t node, const Object& object, std::uint32_t value) noexcept;
Frame encode_write_reply(std::uint32_t node, const Object& object) noexcept;
/// Nothing if the frame has not eight bytes or is of a transfer that is not expedited.
std::optional<Sdo> decode_sdo_request(const Frame& frame) noexcept;
std::optional<Sdo> decode_sdo_reply(const Frame& frame) noexcept;

Frame encode_torque(std::uint32_t node, const TorqueCommand& command) noexcept;
std::optional<TorqueCommand> decode_torque(const Frame& frame) noexcept;

Frame encode_report(std::uint32_t node, const Report& report) noexcept;
std::optional<Report> decode_report(const Frame& frame) noexcept;
/// TPDO2: 0x606C in the drive's unit.
Frame encode_velocity(std::uint32_t node, std::int32_t velocity) noexcept;
std::optional<std::int32_t> decode_velocity(const Frame& frame) noexcept;

Frame encode_emergency(std::uint32_t node, const Emergency& emergency) noexcept;
std::optional<Emergency> decode_emergency(const Frame& frame) noexcept;

/// The state a statusword names; nothing where it names none.
std::optional<PowerState> power_state(std::uint16_t statusword) noexcept;
const char* power_state_name(PowerState state) noexcept;
/// The controlword that takes a drive one transition from `state` towards operation enabled.
std::uint16_t next_towards_enabled(PowerState state) noexcept;

/// Per mille of the rated torque, to nearest, within +-limit. Nothing if a number is not finite.
std::optional<std::int16_t> to_permille(double torque_nm, double rated_nm,
                                        std::int16_t limit_permille) noexcept;
constexpr double from_permille(std::int32_t permille, double rated_nm) noexcept {
  return static_cast<double>(permille) * 1e-3 * rated_nm;
}

}  // namespace geodesic::drivers::cia402
