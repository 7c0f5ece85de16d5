// One bus of the bare exchange: a batch out, a batch in, on SocketCAN or the socket bus, with as
// little between the caller and the kernel as can be. Who says what when is in bare_exchange.cpp.
#pragma once

#include <linux/can.h>
#include <sys/socket.h>

#include <array>
#include <cstddef>
#include <cstdint>
#include <ctime>
#include <memory>
#include <string>
#include <vector>

#include "drivers/bus/socket_bus_wire.hpp"  // how the socket bus lays out a message; no code

namespace geodesic::bench {

inline constexpr std::size_t kMaxFrames = 64;
inline constexpr std::size_t kMessages = 8;  ///< of the socket bus, read at once
inline constexpr std::int64_t kSecond = 1'000'000'000;

/// Says why and ends the program with status 1.
[[noreturn]] __attribute__((format(printf, 1, 2))) void fail(const char* format, ...);

inline std::int64_t now_ns() noexcept {
  timespec now{};
  ::clock_gettime(CLOCK_MONOTONIC, &now);
  return now.tv_sec * kSecond + now.tv_nsec;
}

inline timespec to_timespec(std::int64_t ns) noexcept {
  return {.tv_sec = ns / kSecond, .tv_nsec = ns % kSecond};
}

/// One bus: buffers to send a batch from and to read a batch into.
struct BareBus {
  int socket = -1;
  bool on_can = false;
  std::array<canfd_frame, kMaxFrames> out{};
  std::array<canfd_frame, kMaxFrames * kMessages> in{};
  std::array<iovec, kMaxFrames> out_vector{};
  std::array<iovec, kMaxFrames> in_vector{};
  std::array<mmsghdr, kMaxFrames> out_message{};
  std::array<mmsghdr, kMaxFrames> in_message{};
  std::array<std::byte, geodesic::drivers::kWireMessageBytes> out_bytes{};
  std::array<std::array<std::byte, geodesic::drivers::kWireMessageBytes>, kMessages> in_bytes{};
  std::uint64_t heard = 0;  ///< commander: one bit a reply of this cycle
};

struct BareBusOptions {
  bool extended = false;              ///< 29-bit identifiers
  bool fd = false;                    ///< CAN FD frames with bit-rate switch
  std::vector<std::uint32_t> let_in;  ///< identifiers to read
};

/// Opens "can0", "vcan0" or "unix:PATH"; ends the program where it cannot.
std::unique_ptr<BareBus> open_bare_bus(const std::string& name, const BareBusOptions& options);

/// Sends out[first .. first + n) in one system call. @return false if not all were taken.
bool send_batch(BareBus& bus, std::size_t first, std::size_t n) noexcept;

/// Reads what has arrived into in[0 .. @return), identifiers without flags. Ends the program where
/// the bus has gone.
std::size_t read_batch(BareBus& bus) noexcept;

}  // namespace geodesic::bench
