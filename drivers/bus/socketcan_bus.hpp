// A bus of the kernel's CAN stack (SocketCAN): batches in, batches out, and proof that a cycle's
// frames have left before the next are queued. Opening the socket lives in socketcan_open.
#pragma once

#include <linux/can.h>
#include <sys/socket.h>

#include <array>
#include <memory>
#include <optional>

#include "drivers/bus/bus.hpp"
#include "drivers/bus/bus_lock.hpp"
#include "drivers/bus/socketcan_open.hpp"
#include "drivers/bus/stamp_clock.hpp"
#include "drivers/bus/traffic.hpp"

namespace geodesic::drivers {

class SocketCanBus final : public Bus {
 public:
  /// Not real-time. @throws BusError.
  explicit SocketCanBus(const BusOptions& options);

  std::size_t send(std::span<const Frame> frames) noexcept override;
  std::size_t receive(std::span<ReceivedFrame> out) noexcept override;
  int descriptor() const noexcept override { return socket_.descriptor.get(); }
  const control::BusState& state() const noexcept override { return traffic_.state(); }
  const BusCounters& counters() const noexcept override { return traffic_.counters(); }

 private:
  static constexpr std::size_t kControlBytes = 128;
  struct alignas(cmsghdr) Control {
    std::array<char, kControlBytes> bytes;
  };

  bool last_cycle_has_left() noexcept;
  bool queue_empty() const noexcept;
  std::size_t read_batch() noexcept;
  void take_in(const mmsghdr& message, const canfd_frame& raw) noexcept;
  void note_error(int error_number) noexcept;

  CanSocket socket_;
  std::optional<BusLock> lock_;
  Traffic traffic_;
  StampClock clock_;
  std::array<canfd_frame, kMaxBatch> out_frames_{};
  std::array<iovec, kMaxBatch> out_vectors_{};
  std::array<mmsghdr, kMaxBatch> out_messages_{};
  std::array<canfd_frame, kMaxBatch> in_frames_{};
  std::array<iovec, kMaxBatch> in_vectors_{};
  std::array<mmsghdr, kMaxBatch> in_messages_{};
  std::array<Control, kMaxBatch> in_control_{};
};

/// Not real-time. @throws BusError.
std::unique_ptr<Bus> open_socketcan_bus(const BusOptions& options);

}  // namespace geodesic::drivers
