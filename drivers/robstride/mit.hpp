// The MIT protocol that RobStride drives can be switched to: frames <-> numbers, for whoever reads
// such a bus. Our driver speaks the private protocol only (codec.hpp). Real-time throughout.
#pragma once

#include <cstdint>
#include <optional>

#include "drivers/bus/frame.hpp"
#include "drivers/robstride/codec.hpp"

namespace geodesic::drivers::robstride {

/// Commands go to the motor's id, 11 bits; answers to the host's.
struct MitReply {
  std::uint8_t motor = 0;
  double position_rad = 0.0;
  double velocity_rad_s = 0.0;
  double torque_nm = 0.0;
  double temperature_c = 0.0;
};

/// Never equal to a special frame: where it would be, stiffness loses one code.
/// Nothing if a number is not finite.
std::optional<Frame> encode_mit(std::uint8_t motor, const ControlCommand& command,
                                const Ranges& ranges) noexcept;
/// Each gives nothing for another length, or a special frame.
std::optional<ControlCommand> decode_mit(const Frame& frame, const Ranges& ranges) noexcept;
std::optional<MitReply> decode_mit_reply(const Frame& frame, const Ranges& ranges) noexcept;

}  // namespace geodesic::drivers::robstride
