// Bytes <-> numbers as the simulated drive computes them, apart from the codec's.
#pragma once

#include <bit>
#include <cstddef>
#include <cstdint>

#include "drivers/bus/frame.hpp"
#include "drivers/odrive/layout.hpp"

namespace geodesic::drivers::odrive {

inline std::uint32_t word_at(const Frame& frame, std::size_t at) {
  std::uint32_t word = 0;
  for (std::size_t i = 0; i < 4; ++i) {
    word += static_cast<std::uint32_t>(frame.data[at + i]) << (8U * static_cast<unsigned>(i));
  }
  return word;
}

inline float float_at(const Frame& frame, std::size_t at) {
  return std::bit_cast<float>(word_at(frame, at));
}

inline void put_word(Frame& frame, std::size_t at, std::uint64_t word, std::size_t bytes = 4) {
  for (std::size_t i = 0; i < bytes; ++i) {
    frame.data[at + i] = static_cast<std::uint8_t>(word % 256U);
    word /= 256U;
  }
}

inline void put_float(Frame& frame, std::size_t at, double value) {
  put_word(frame, at, std::bit_cast<std::uint32_t>(static_cast<float>(value)));
}

inline std::size_t index(Parameter parameter) {
  return static_cast<std::size_t>(parameter);
}

}  // namespace geodesic::drivers::odrive
