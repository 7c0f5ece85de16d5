// The books of one opened bus, whatever carries it: which frames are ours, foreign or wanted, how
// many of ours are still under way, what the controller's state is. No system calls, no sockets.
#pragma once

#include <cstddef>
#include <cstdint>
#include <span>
#include <vector>

#include "control/joint.hpp"
#include "drivers/bus/bus.hpp"
#include "drivers/bus/id_set.hpp"

namespace geodesic::drivers {

/// Everything but the constructor is real-time.
class Traffic {
 public:
  /// @param held_capacity  frames kept between reading and take(); bounds what a caller that does
  ///                       not read costs.
  Traffic(const BusOptions& options, std::size_t held_capacity);

  /// This opener commands drives: its frames are confirmed and others' commands are foreign.
  bool commands() const noexcept { return !transmit_.empty(); }
  bool is_command(const Frame& frame) const noexcept { return transmit_.contains(frame); }

  /// A frame of somebody else (or of the kernel, if it is an error frame) has been read.
  void arrived(const Frame& frame, std::int64_t stamp_ns) noexcept;
  /// One of our own has left.
  void confirmed() noexcept;
  /// Counts frames lost before they could be read; `total` since the connection was made.
  void dropped(std::uint64_t total) noexcept;
  /// The peer that counts losses is a new one and begins at zero.
  void new_connection() noexcept { drops_seen_ = 0; }

  std::size_t room() const noexcept { return held_.size() - held_count_; }
  /// Moves the oldest frames held to `out`. @return how many.
  std::size_t take(std::span<ReceivedFrame> out) noexcept;

  /// Begins a send: forgets a foreign commander who has been silent for a second.
  void begin_send(std::int64_t now_ns) noexcept;
  /// `frames` cannot go behind what is still under way.
  void skipped(std::size_t frames) noexcept;
  /// The kernel took `sent` of `offered`; `commanded` of them will be confirmed.
  void handed_over(std::size_t sent, std::size_t offered, std::size_t commanded,
                   std::int64_t now_ns) noexcept;
  /// The bus refused or ended with this errno.
  void failed(int error_number) noexcept;

  std::size_t in_flight() const noexcept { return in_flight_; }
  std::int64_t handed_over_ns() const noexcept { return handed_over_ns_; }
  /// How long what was handed over last may take to leave before it must be called held: twice its
  /// bits at the bus's rate, and as much again as any controller or hub may be busy.
  std::int64_t patience_ns() const noexcept { return kBusyNs + handed_over_bits_ns_; }
  /// Something happened that destroys frames or confirmations: loss on our side, link down,
  /// restart.
  bool confirmations_lost() const noexcept { return confirmations_lost_; }
  void forget_in_flight() noexcept;
  /// Forgets what is under way for want of a confirmation alone. Allowed once, until a confirmation
  /// shows that the bus moves: so what a wrong guess puts behind a held frame is one cycle at most.
  /// Frames leave in order: if the guess was wrong, the forgotten ones' confirmations come before
  /// those of what is handed over next, and are not taken for them.
  /// @return false: not allowed.
  bool doubt_in_flight() noexcept;
  /// Queue and controller were emptied: nothing is under way any more.
  void purged() noexcept;
  /// Somebody is about to restart the controller, which left the bus.
  void restart_expected() noexcept;
  void went_down(std::int64_t now_ns) noexcept;
  void came_up() noexcept;

  const control::BusState& state() const noexcept { return state_; }
  const BusCounters& counters() const noexcept { return counters_; }

 private:
  void controller_afresh() noexcept;
  void hold(const Frame& frame, std::int64_t stamp_ns) noexcept;

  static constexpr std::int64_t kBusyNs = 15'000'000;

  IdSet receive_;
  IdSet transmit_;
  bool fd_;
  std::int64_t frame_ns_;  // twice the longest frame
  control::BusState state_;
  BusCounters counters_;
  std::vector<ReceivedFrame> held_;  // ring
  std::size_t held_first_ = 0;
  std::size_t held_count_ = 0;
  std::size_t in_flight_ = 0;
  std::size_t forgotten_ = 0;            // doubted frames that may still be confirmed
  std::size_t confirmed_forgotten_ = 0;  // since the last frames were handed over
  std::int64_t handed_over_ns_ = 0;
  std::int64_t handed_over_bits_ns_ = 0;
  std::int64_t foreign_ns_ = 0;
  std::int64_t down_ns_ = 0;
  std::uint64_t drops_seen_ = 0;
  bool confirmations_lost_ = false;
  bool doubted_ = false;
  bool bus_off_before_send_ =
      false;  // bus-off was known when the frames under way were handed over
};

}  // namespace geodesic::drivers
