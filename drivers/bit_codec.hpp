// Numbers <-> fields of bits, as the host reads and writes them: for the codecs of families that
// pack ranges into codes. Simulated drives have arithmetic of their own. Real-time.
#pragma once

#include <bit>
#include <cstddef>
#include <cstdint>
#include <cstring>

#include "drivers/bit_field.hpp"
#include "drivers/bus/frame.hpp"

namespace geodesic::drivers {

/// @return the code of `value` in [low, high] as `bits` bits: clamped, rounded to nearest.
constexpr std::uint32_t to_code(double value, double low, double high, unsigned bits) noexcept {
  const double top = static_cast<double>((1U << bits) - 1U);
  const double clamped = value < low ? low : (value > high ? high : value);
  const double exact = (clamped - low) / (high - low) * top;
  const auto below = static_cast<std::uint32_t>(exact);
  return exact - static_cast<double>(below) < 0.5 ? below : below + 1U;
}

/// @return what a drive takes `code` for.
constexpr double from_code(std::uint32_t code, double low, double high, unsigned bits) noexcept {
  return static_cast<double>(code) / static_cast<double>((1U << bits) - 1U) * (high - low) + low;
}

/// The first eight data bytes in the order of the wire as one number, most significant first. Every
/// field of every frame passes here: one load and one swap, not a loop.
inline std::uint64_t load_word(const Frame& frame) noexcept {
  std::uint64_t word = 0;
  std::memcpy(&word, frame.data.data(), sizeof word);
  return std::endian::native == std::endian::little ? __builtin_bswap64(word) : word;
}
inline void store_word(Frame& frame, std::uint64_t word) noexcept {
  word = std::endian::native == std::endian::little ? __builtin_bswap64(word) : word;
  std::memcpy(frame.data.data(), &word, sizeof word);
}

/// @return the bits of `field` in the first eight data bytes.
inline std::uint32_t extract(const Frame& frame, Field field) noexcept {
  const std::uint64_t mask = (std::uint64_t{1} << field.bits) - 1U;
  return static_cast<std::uint32_t>(load_word(frame) >> (64U - field.first - field.bits) & mask);
}

/// @return a word with `code` where `field` is, 0 elsewhere.
constexpr std::uint64_t place(std::uint32_t code, Field field) noexcept {
  return static_cast<std::uint64_t>(code) << (64U - field.first - field.bits);
}

/// The same of a number in [-range, range].
constexpr std::uint64_t place_signed(double value, double range, Field field) noexcept {
  return place(to_code(value, -range, range, field.bits), field);
}
inline double signed_at(const Frame& frame, double range, Field field) noexcept {
  return from_code(extract(frame, field), -range, range, field.bits);
}

}  // namespace geodesic::drivers
