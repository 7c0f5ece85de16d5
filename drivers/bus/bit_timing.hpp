// How long frames occupy a CAN bus, and whether a cycle of them fits: pure arithmetic. No sockets.
//
// Sources: Bosch CAN Specification 2.0 (1991), parts A and B (frame format 3.1, bit stuffing 5);
// ISO 11898-1:2015 (FD frame format 10.4.2.3, bit-rate switch, fixed stuff bits 10.5).
#pragma once

#include <cstddef>
#include <cstdint>
#include <span>

#include "drivers/bus/frame.hpp"

namespace geodesic::drivers {

/// Bits of one frame with its 3 bits of interframe space. The bit rate is taken to switch after the
/// BRS bit and back before the CRC delimiter; on the wire it does so within those bits (at the
/// sample point), which makes less than one nominal bit of difference.
struct FrameBits {
  int nominal = 0;  ///< at the nominal bit rate
  int data = 0;     ///< at the data bit rate; 0 without bit-rate switch
  bool operator==(const FrameBits&) const = default;
};

enum class Stuffing : std::uint8_t {
  kBest,   ///< no stuff bit but those that are always there
  kWorst,  ///< as many as any identifier and data can cause
};

/// 0..8, and for FD also 12, 16, 20, 24, 32, 48, 64. Real-time.
bool is_can_length(std::size_t bytes, bool fd) noexcept;
/// Shortest length a frame with `bytes` (at most 64) of payload has. Real-time.
std::size_t can_length(std::size_t bytes, bool fd) noexcept;

/// Exact, with the stuff bits this identifier and these data cause. Real-time.
FrameBits frame_bits(const Frame& frame) noexcept;
/// Bounds by length. Real-time. @param bytes  0..64 (classic 0..8), rounded up to a CAN length
FrameBits frame_bits(std::size_t bytes, bool extended, bool fd, bool bit_rate_switch,
                     Stuffing stuffing) noexcept;

/// Time of those bits [ns], rounded up. Rates in bit/s, > 0. Real-time.
std::int64_t frame_time_ns(const Frame& frame, std::int64_t bit_rate,
                           std::int64_t data_bit_rate) noexcept;
std::int64_t frame_time_ns(std::size_t bytes, bool extended, bool fd, bool bit_rate_switch,
                           std::int64_t bit_rate, std::int64_t data_bit_rate,
                           Stuffing stuffing) noexcept;

/// Frames of one kind in each cycle: commands and replies alike.
struct CycleFrames {
  std::size_t count = 1;
  std::size_t bytes = 8;
  bool extended = false;
  bool fd = false;
  bool bit_rate_switch = false;
  double share = 1.0;  ///< of the cycles in which they come
};

/// What one bus has to carry in a cycle, against what it can.
struct BusBudget {
  std::size_t frames = 0;      ///< a cycle
  std::int64_t period_ns = 0;  ///< of the rate asked for
  std::int64_t best_ns = 0;    ///< bus time a cycle without stuff bits, on average
  std::int64_t worst_ns = 0;   ///< bus time a cycle with as many as there can be
  double best_load = 0.0;      ///< best_ns / period_ns, 1 = full
  double worst_load = 0.0;     ///< worst_ns / period_ns
  double usable = 0.0;         ///< share of the bus that cyclic frames may take
  double max_rate_hz = 0.0;    ///< highest rate at which worst_ns still fits into the usable share
  bool carried = false;        ///< worst_ns <= usable * period_ns
};

/// Share of the bus left to cyclic frames by default: the rest is for what is not cyclic (register
/// dialogues, error frames, retransmission) and for replies that come late.
inline constexpr double kUsableBus = 0.95;

/// @param rate_hz  cycles a second, > 0    @param usable  0..1. Not real-time.
BusBudget bus_budget(std::span<const CycleFrames> frames, double rate_hz, std::int64_t bit_rate,
                     std::int64_t data_bit_rate, double usable = kUsableBus);

}  // namespace geodesic::drivers
