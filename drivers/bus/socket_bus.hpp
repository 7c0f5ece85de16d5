// A client of the socket bus: the same Bus as SocketCAN's, where the kernel has no CAN. The hub
// that carries the frames lives in socket_bus_hub.
#pragma once

#include <sys/socket.h>

#include <array>
#include <atomic>
#include <cstddef>
#include <cstdint>
#include <memory>
#include <optional>
#include <vector>

#include "drivers/bus/bus.hpp"
#include "drivers/bus/bus_lock.hpp"
#include "drivers/bus/descriptor.hpp"
#include "drivers/bus/socket_bus_wire.hpp"
#include "drivers/bus/traffic.hpp"
#include "drivers/bus/unix_address.hpp"

namespace geodesic::drivers {

class SocketBus final : public Bus {
 public:
  /// Not real-time. @throws BusError if nobody serves the path.
  explicit SocketBus(const BusOptions& options);

  std::size_t send(std::span<const Frame> frames) noexcept override;
  std::size_t receive(std::span<ReceivedFrame> out) noexcept override;
  int descriptor() const noexcept override { return socket_.get(); }
  const control::BusState& state() const noexcept override { return traffic_.state(); }
  const BusCounters& counters() const noexcept override { return traffic_.counters(); }
  void tend() noexcept override;

 private:
  static constexpr std::size_t kMessages = 8;

  /// Whose turn it is: what is not kUp is handed from one thread to the other.
  enum class Link : std::uint8_t {
    kUp,     ///< the socket belongs to who sends and receives
    kGone,   ///< the hub has left; the socket belongs to who tends
    kFresh,  ///< connected again; to be taken up by who sends
  };

  bool can_carry(const Frame& frame) const noexcept;
  bool reconnect() noexcept;
  bool may_send(std::int64_t now_ns) noexcept;
  void ask_to_forget(std::int64_t now_ns) noexcept;
  void gone(int error_number) noexcept;
  void set_aside() noexcept;
  bool connect_again() noexcept;
  std::size_t read_batch() noexcept;
  void take_in(std::span<const std::byte> message, std::int64_t now_ns) noexcept;

  UnixAddress address_;
  bool fd_;
  Traffic traffic_;
  std::optional<BusLock> lock_;
  Descriptor socket_;
  Descriptor idle_;  // takes the socket's place in poll() while the hub is gone: never readable
  int sends_until_reconnect_ = 0;
  std::atomic<Link> link_{Link::kUp};
  std::atomic<bool> tended_{false};  // somebody else does what takes more than to send and receive
  bool set_aside_ = false;           // the rest is tend()'s
  std::int64_t next_try_ns_ = 0;
  bool forget_asked_ = false;  // what is under way was taken back
  bool proven_ = true;         // something has left since it last was
  bool sent_since_ = false;    // something was handed over since
  std::int64_t quiet_until_ns_ = 0;
  WireWriter writer_;
  std::vector<std::array<std::byte, kWireMessageBytes>> buffers_;
  std::array<iovec, kMessages> vectors_{};
  std::array<mmsghdr, kMessages> messages_{};
};

/// Not real-time. @throws BusError.
std::unique_ptr<Bus> open_socket_bus(const BusOptions& options);

}  // namespace geodesic::drivers
