// The messages of the socket bus: how a batch of frames lies in one SOCK_SEQPACKET message. Both
// sides run on one host, so integers are in its own order. No sockets.
#pragma once

#include <array>
#include <cstddef>
#include <cstdint>
#include <cstring>
#include <span>

#include "drivers/bus/bus.hpp"

namespace geodesic::drivers {

struct WireMessageHeader {
  static constexpr std::uint32_t kMagic = 0x31424447;  // "GDB1"
  static constexpr std::uint16_t kWantsConfirmation = 1;
  static constexpr std::uint16_t kForget = 2;
  std::uint32_t magic = kMagic;
  std::uint16_t frames = 0;
  /// Client to hub: kWantsConfirmation; kForget: what of mine still waits is not to be sent (each
  /// frame thrown away is confirmed as if it had left).
  std::uint16_t flags = 0;
  std::uint64_t dropped = 0;  ///< hub to client: frames this client has lost since it came
};

struct WireFrameHeader {
  static constexpr std::uint8_t kExtended = 1;
  static constexpr std::uint8_t kFd = 2;
  static constexpr std::uint8_t kBitRateSwitch = 4;
  static constexpr std::uint8_t kError = 8;
  static constexpr std::uint8_t kConfirmed = 16;  ///< hub to client: one of yours has left; no data
  static constexpr std::uint8_t kRemote = 32;     ///< no data follows, whatever the length
  std::int64_t stamp_ns = 0;  ///< hub to client: CLOCK_MONOTONIC, end of the frame on the wire
  std::uint32_t id = 0;
  std::uint8_t length = 0;
  std::uint8_t flags = 0;
  std::uint16_t reserved = 0;
};

inline constexpr std::size_t kWireFrameBytes = sizeof(WireFrameHeader) + 64;
inline constexpr std::size_t kWireMessageBytes =
    sizeof(WireMessageHeader) + Bus::kMaxBatch * kWireFrameBytes;

/// Fills one message. Real-time.
class WireWriter {
 public:
  bool full() const noexcept { return header_.frames == Bus::kMaxBatch; }
  std::size_t frames() const noexcept { return header_.frames; }
  void add(const Frame& frame, std::int64_t stamp_ns) noexcept;
  void add_confirmation(std::int64_t stamp_ns) noexcept;
  /// The finished message; lives until clear().
  std::span<const std::byte> finish(std::uint16_t flags, std::uint64_t dropped) noexcept;
  void clear() noexcept;

 private:
  void append(const void* data, std::size_t bytes) noexcept;

  WireMessageHeader header_;
  std::size_t size_ = sizeof(WireMessageHeader);
  std::array<std::byte, kWireMessageBytes> bytes_{};
};

/// Walks through one message; survives any bytes. Real-time.
class WireReader {
 public:
  explicit WireReader(std::span<const std::byte> message) noexcept;
  /// False: not of this protocol.
  bool valid() const noexcept { return header_.magic == WireMessageHeader::kMagic; }
  const WireMessageHeader& header() const noexcept { return header_; }
  struct Item {
    Frame frame;
    std::int64_t stamp_ns = 0;
    bool confirmation = false;
  };
  /// @return false at the end, or where the bytes do not hold what they promise.
  bool next(Item& item) noexcept;

 private:
  WireMessageHeader header_;
  std::span<const std::byte> rest_;
  std::size_t left_ = 0;
};

}  // namespace geodesic::drivers
