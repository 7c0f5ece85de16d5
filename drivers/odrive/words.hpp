// CANSimple frames in words, for people.
#pragma once

#include <optional>

#include "drivers/families.hpp"

namespace geodesic::drivers::odrive {

/// Contract as Family::decode: names of signals as in the vendor's DBC. Not real-time.
std::optional<DecodedFrame> decode(const Frame& frame, const DriveOptions& options);

}  // namespace geodesic::drivers::odrive
