// When the frames of one cycle are on the wire of one bus: a pure model of lengths, identifiers and
// the drives' latency, and the order of commands that suits it best. Knows no drives, no clock.
#pragma once

#include <cstddef>
#include <cstdint>
#include <functional>
#include <span>
#include <vector>

namespace geodesic::drivers {

/// One frame of a cycle as the wire sees it.
struct WireFrame {
  static constexpr std::size_t kNothing = static_cast<std::size_t>(-1);
  std::uint32_t key = 0;           ///< arbitration_key(): the smallest that waits wins
  std::int64_t duration_ns = 0;    ///< with interframe space
  bool reply = false;              ///< a drive's; else this host's
  std::size_t answers = kNothing;  ///< a reply's: index of the frame whose end calls for it
  std::int64_t latency_ns = 0;     ///< a reply's: from that end to when it is ready to leave
  std::size_t sender = kNothing;   ///< frames of one sender wait for each other
};

/// Since the host handed its frames over.
struct WireTime {
  std::int64_t ready_ns = 0;  ///< it competes for the wire from here on
  std::int64_t start_ns = 0;
  std::int64_t end_ns = 0;
};

struct Timeline {
  std::vector<WireTime> frames;  ///< of each frame, in the order given
  std::int64_t busy_ns = 0;      ///< sum of all durations
  std::int64_t end_ns = 0;       ///< of the last frame
  std::int64_t gap_ns = 0;       ///< longest from the end of one reply to the end of the next
  /// Times that frames of one identifier from two senders waited for the wire at once: they start
  /// together, and destroy each other.
  std::size_t collisions = 0;

  /// Time in which the wire waited for a drive.
  std::int64_t idle_ns() const noexcept { return end_ns - busy_ns; }
};

/// The host's frames are all handed over at 0 and leave in the order given, as from the queue of a
/// CAN controller; its foremost and all replies that are ready compete whenever the wire is free.
///
/// The wire idles only after the last command, for no longer than the longest latency: whatever the
/// frames hold, end_ns <= busy_ns + that. Nothing is gained by handing a command over later: the
/// wire is never idle while one waits. Not real-time; quadratic in the number of frames.
Timeline lay_out(std::span<const WireFrame> frames);

/// Cost of handing things over in this order; the smallest is wanted.
using OrderCost = std::function<std::int64_t(std::span<const std::size_t> order)>;

/// The first of `candidates` with the least cost, and from there on down by exchanging two or
/// moving one, as long as that helps. Orders of more than kMaxImproved are only compared. Not
/// real-time.
/// @param candidates  permutations of one another, at least one
std::vector<std::size_t> best_order(std::span<const std::vector<std::size_t>> candidates,
                                    const OrderCost& cost);
inline constexpr std::size_t kMaxImproved = 12;

}  // namespace geodesic::drivers
