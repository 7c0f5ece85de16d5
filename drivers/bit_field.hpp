// Where a number lies in a frame of eight bytes: what layout tables are made of. Facts only.
#pragma once

#include <cstdint>

namespace geodesic::drivers {

/// A run of bits in the eight data bytes, counted from the most significant bit of byte 0.
struct Field {
  std::uint8_t first = 0;
  std::uint8_t bits = 0;
};

}  // namespace geodesic::drivers
