// What every bus can do, whatever carries it: send at most one cycle of frames, receive in batches,
// tell its health. Opening and its errors are non-real-time; everything else here is real-time.
#pragma once

#include <cstdint>
#include <memory>
#include <optional>
#include <span>
#include <stdexcept>
#include <string>
#include <vector>

#include "control/joint.hpp"
#include "drivers/bus/frame.hpp"
#include "drivers/bus/link_health.hpp"

namespace geodesic::drivers {

/// Why a bus cannot be opened or served: what was tried, the reason, the command that helps.
class BusError : public std::runtime_error {
 public:
  explicit BusError(const std::string& message, int error_number = 0)
      : std::runtime_error(message), error_number_(error_number) {}
  /// errno of the call that failed; 0 where no call did.
  int error_number() const noexcept { return error_number_; }

 private:
  int error_number_;
};

/// Identifiers of 11 or 29 bits: those that equal `id` in the bits of `mask`.
struct IdFilter {
  static constexpr std::uint32_t kExact = 0x1FFFFFFF;
  std::uint32_t id = 0;
  bool extended = false;
  std::uint32_t mask = kExact;
  /// Drives may have it in common: which one a frame belongs to stands in its data (Drive::claims).
  bool shared = false;

  constexpr bool matches(std::uint32_t other, bool other_extended) const noexcept {
    return extended == other_extended && ((id ^ other) & mask) == 0;
  }
};

/// There is an identifier that both match.
constexpr bool overlap(const IdFilter& a, const IdFilter& b) noexcept {
  return a.extended == b.extended && ((a.id ^ b.id) & a.mask & b.mask) == 0;
}

/// What an interface gets that is brought up, where the configuration does not say.
inline constexpr int kDefaultRestartMs = 100;
inline constexpr int kDefaultQueue = 64;  ///< a whole cycle fits (Bus::kMaxBatch)

struct BusOptions {
  std::string name;       ///< how the configuration calls it
  std::string interface;  ///< "can0", "vcan0", "usb:1-2.3", "serial:NUMBER", or "unix:PATH"
  bool fd = false;        ///< frames may be CAN FD; the interface must be able to carry them
  std::int64_t bit_rate = 1'000'000;       ///< [bit/s], nominal (arbitration) phase
  std::int64_t data_bit_rate = 5'000'000;  ///< [bit/s], FD data phase
  /// Set the interface up as this says, where CAP_NET_ADMIN allows it; and keep it so.
  bool bring_up = false;
  std::optional<double> sample_point;       ///< part of a bit, 0..1; empty: the kernel's choice
  std::optional<double> data_sample_point;  ///< the same of the data phase
  std::optional<int> restart_ms;  ///< a controller's way back from bus-off; 0: not by itself
  std::optional<int> queue;       ///< [frames], the interface's transmit queue
  std::vector<IdFilter> receive;  ///< let in; empty: everything (monitors, simulated drives)
  std::vector<IdFilter>
      transmit;  ///< what this host alone may send; the same from others is foreign
};

/// Since the bus was opened.
struct BusCounters {
  std::uint64_t sent = 0;             ///< frames handed to the kernel
  std::uint64_t received = 0;         ///< frames read, error frames not among them
  std::uint64_t send_skipped = 0;     ///< frames not sent since the last cycle's had not left
  std::uint64_t send_failed = 0;      ///< frames the kernel refused (last_errno says why)
  std::uint64_t receive_dropped = 0;  ///< frames the kernel dropped since its queue was full
  std::uint64_t error_frames = 0;
  std::uint64_t foreign_commands = 0;
  int last_errno = 0;
};

class Bus {
 public:
  virtual ~Bus() = default;

  /// Hands the cycle's frames to the kernel, all or none: if a frame of the last call has not left
  /// yet, none is queued behind it; they are counted as skipped and state().stalled is set. At most
  /// kMaxBatch frames a call; what the kernel refuses is counted as failed and never sent again.
  /// A frame with `error` set goes out as an error frame (fault injection).
  /// @return frames sent. Real-time, one system call (two on an interface without echo, as vcan).
  static constexpr std::size_t kMaxBatch = 64;
  virtual std::size_t send(std::span<const Frame> frames) noexcept = 0;

  /// Reads what has arrived, without waiting. @return frames written to `out`; a frame of our own
  /// never shows. Error frames change state() and show only where BusOptions::receive is empty.
  /// Real-time, bounded by out.size().
  virtual std::size_t receive(std::span<ReceivedFrame> out) noexcept = 0;

  /// Descriptor that polls readable when receive() has something; the same for the bus' whole life.
  virtual int descriptor() const noexcept = 0;

  /// What takes more than sending and receiving, such as to connect again to a bus that was gone.
  /// From its first call on, the others make no system call but to send, receive and read the
  /// clock, and this one is to be called now and then. One thread, not the real-time one.
  virtual void tend() noexcept {}

  /// Asks for a controller that is bus-off and does not restart by itself to be restarted by the
  /// next tend(). Real-time.
  virtual void ask_restart() noexcept {}

  /// How the controller feels, as far as tend() knows. The thread that tends; not real-time.
  virtual LinkHealth health() const { return {}; }
  /// What tend() has to tell since this was last asked. The thread that tends; not real-time.
  virtual std::vector<BusNews> take_news() { return {}; }

  virtual const control::BusState& state() const noexcept = 0;
  virtual const BusCounters& counters() const noexcept = 0;

 protected:
  Bus() = default;
  Bus(const Bus&) = default;
  Bus& operator=(const Bus&) = default;
};

/// Opens the bus that options.interface names. Not real-time.
/// @throws BusError with what was tried, the reason and the command that helps.
std::unique_ptr<Bus> open_bus(const BusOptions& options);

}  // namespace geodesic::drivers
