// A bus of the kernel's CAN stack (SocketCAN): batches in, batches out, and proof that a cycle's
// frames have left before the next are queued. Opening the socket lives in socketcan_open, what is
// done for the interface meanwhile in link_keeper.
#pragma once

#include <linux/can.h>
#include <sys/socket.h>

#include <array>
#include <atomic>
#include <memory>
#include <optional>
#include <string>
#include <vector>

#include "drivers/bus/bus.hpp"
#include "drivers/bus/bus_lock.hpp"
#include "drivers/bus/can_link.hpp"
#include "drivers/bus/link_keeper.hpp"
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
  void ask_restart() noexcept override;
  /// Opens a bus anew whose adapter has come back, empties a queue that stands still, restarts a
  /// controller that was asked to be, reads its state and error counters.
  void tend() noexcept override;
  LinkHealth health() const override { return keeper_->health(); }
  std::vector<BusNews> take_news() override { return keeper_->take_news(); }

 private:
  static constexpr std::size_t kControlBytes = 128;
  struct alignas(cmsghdr) Control {
    std::array<char, kControlBytes> bytes;
  };

  /// Whose turn it is: what is not kUp is handed from one thread to the other.
  enum class Link : std::uint8_t {
    kUp,     ///< the socket belongs to who sends and receives
    kGone,   ///< there is no such interface any more; the socket belongs to who tends
    kFresh,  ///< opened again; to be taken up by who sends
  };

  // Real-time.
  bool usable() noexcept;
  bool may_send(std::int64_t now_ns) noexcept;
  void held() noexcept;
  bool last_cycle_has_left() noexcept;
  bool queue_empty() const noexcept;
  std::size_t read_batch() noexcept;
  void take_in(const mmsghdr& message, const canfd_frame& raw) noexcept;
  void note_error(int error_number) noexcept;

  // Who opens and tends.
  CanSocket open();
  void tend_gone(std::int64_t now_ns);
  void tend_up(std::int64_t now_ns);

  BusOptions options_;
  KernelLinkPort port_;
  std::string device_;  // the interface's own name
  std::optional<BusLock> lock_;
  std::optional<LinkKeeper> keeper_;
  CanSocket socket_;
  Descriptor idle_;  // takes the socket's place in poll() while there is none: never readable
  Traffic traffic_;
  StampClock clock_;
  std::array<canfd_frame, kMaxBatch> out_frames_{};
  std::array<iovec, kMaxBatch> out_vectors_{};
  std::array<mmsghdr, kMaxBatch> out_messages_{};
  std::array<canfd_frame, kMaxBatch> in_frames_{};
  std::array<iovec, kMaxBatch> in_vectors_{};
  std::array<mmsghdr, kMaxBatch> in_messages_{};
  std::array<Control, kMaxBatch> in_control_{};

  // Between the two threads.
  std::atomic<Link> link_{Link::kUp};
  std::atomic<bool> tended_{false};
  std::atomic<bool> fresh_echoes_{false};       // of a socket that is kFresh
  std::atomic<std::int64_t> held_since_ns_{0};  // nothing has left since then; 0: it moves
  std::atomic<std::int64_t> patience_ns_{0};    // with it
  std::atomic<bool> bus_off_{false};            // as the error frames say
  std::atomic<std::uint64_t> received_{0};      // frames of others
  std::atomic<bool> purging_{false};            // the interface goes down because we want it
  std::atomic<std::uint64_t> purges_{0};
  std::atomic<bool> proven_{true};  // something has left since the last purge
  std::atomic<bool> restart_possible_{false};
  std::atomic<bool> restart_asked_{false};

  // Who sends.
  std::uint64_t purges_seen_ = 0;
  std::int64_t quiet_until_ns_ = 0;
  bool sent_since_ = false;  // something was handed over since the last purge
  // Who tends.
  bool set_aside_ = false;
  std::int64_t next_try_ns_ = 0;
  std::string last_refusal_;
};

/// Not real-time. @throws BusError.
std::unique_ptr<Bus> open_socketcan_bus(const BusOptions& options);

}  // namespace geodesic::drivers
