// One CAN frame, classic or FD, and one as received. No sockets, no protocol.
#pragma once

#include <array>
#include <cstddef>
#include <cstdint>
#include <span>

namespace geodesic::drivers {

struct Frame {
  std::uint32_t id = 0;          ///< 11 or 29 bits, without flags
  bool extended = false;         ///< 29-bit identifier
  bool fd = false;               ///< CAN FD frame
  bool bit_rate_switch = false;  ///< FD only: data phase at the data bit rate
  bool remote = false;  ///< a request for the frame of that identifier: `length` is what is asked
                        ///< for, no data is carried; classic only
  bool error = false;   ///< received only: an error frame of the kernel; id holds its class
  std::uint8_t length = 0;  ///< data bytes: 0..8, FD also 12, 16, 20, 24, 32, 48, 64
  std::array<std::uint8_t, 64> data{};

  std::span<const std::uint8_t> payload() const noexcept { return {data.data(), length}; }
  bool operator==(const Frame&) const = default;
};

struct ReceivedFrame {
  Frame frame;
  std::int64_t stamp_ns = 0;  ///< CLOCK_MONOTONIC, arrival at this host's kernel
};

}  // namespace geodesic::drivers
