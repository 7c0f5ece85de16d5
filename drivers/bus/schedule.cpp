// When the frames of one cycle are on the wire; see the header.
#include "drivers/bus/schedule.hpp"

#include <algorithm>
#include <limits>
#include <utility>

namespace geodesic::drivers {
namespace {

constexpr std::int64_t kNever = std::numeric_limits<std::int64_t>::max();
constexpr int kMaxRounds = 4;  // of improvement; each is cubic in the number of drives

/// The frame that begins next among those that have not.
std::size_t winner(std::span<const WireFrame> frames, const std::vector<WireTime>& times,
                   const std::vector<bool>& done, std::size_t host, std::int64_t free_ns,
                   Timeline& line) {
  std::int64_t start = kNever;
  for (std::size_t i = 0; i < frames.size(); ++i) {
    if (!done[i] && (frames[i].reply || i == host)) start = std::min(start, times[i].ready_ns);
  }
  start = std::max(start, free_ns);
  std::size_t best = host < frames.size() ? host : WireFrame::kNothing;
  bool collides = false;
  for (std::size_t i = 0; i < frames.size(); ++i) {
    if (done[i] || !frames[i].reply || times[i].ready_ns > start) continue;
    if (best == WireFrame::kNothing || frames[i].key < frames[best].key) {
      best = i;
      collides = false;
    } else if (frames[i].key == frames[best].key) {
      collides = collides || frames[i].sender != frames[best].sender ||
                 frames[i].sender == WireFrame::kNothing;
      // The one that was ready first, if it is not the host's.
      if (frames[best].reply && times[i].ready_ns < times[best].ready_ns) best = i;
    }
  }
  line.collisions += collides ? 1 : 0;
  return best;
}

/// One step of improvement: exchanges two, or moves one, where that costs less.
bool improve(std::vector<std::size_t>& order, std::int64_t& least, const OrderCost& cost) {
  bool better = false;
  const auto consider = [&](const std::vector<std::size_t>& other) {
    const std::int64_t its = cost(other);
    if (its >= least) return false;
    least = its;
    order = other;
    better = true;
    return true;
  };
  for (std::size_t a = 0; a < order.size(); ++a) {
    for (std::size_t b = 0; b < order.size(); ++b) {
      if (a == b) continue;
      std::vector<std::size_t> other = order;
      std::swap(other[a], other[b]);
      if (a < b && consider(other)) continue;
      other = order;
      const std::size_t moved = other[a];
      other.erase(other.begin() + static_cast<std::ptrdiff_t>(a));
      other.insert(other.begin() + static_cast<std::ptrdiff_t>(b), moved);
      consider(other);
    }
  }
  return better;
}

}  // namespace

Timeline lay_out(std::span<const WireFrame> frames) {
  Timeline line;
  line.frames.resize(frames.size());
  std::vector<bool> done(frames.size(), false);
  for (std::size_t i = 0; i < frames.size(); ++i) {
    const bool waits = frames[i].reply && frames[i].answers != WireFrame::kNothing;
    line.frames[i].ready_ns = waits ? kNever : 0;
    line.busy_ns += frames[i].duration_ns;
  }
  std::size_t host = 0;  // its foremost frame
  std::int64_t last_reply_ns = kNever;
  for (std::size_t count = 0; count < frames.size(); ++count) {
    while (host < frames.size() && frames[host].reply) ++host;
    const std::size_t next = winner(frames, line.frames, done, host, line.end_ns, line);
    if (next == WireFrame::kNothing) break;  // the rest answers nothing that was sent
    WireTime& time = line.frames[next];
    time.start_ns = std::max(line.end_ns, time.ready_ns);
    time.end_ns = time.start_ns + frames[next].duration_ns;
    line.end_ns = time.end_ns;
    done[next] = true;
    if (next == host) ++host;
    if (frames[next].reply) {
      if (last_reply_ns != kNever) line.gap_ns = std::max(line.gap_ns, time.end_ns - last_reply_ns);
      last_reply_ns = time.end_ns;
    }
    for (std::size_t i = 0; i < frames.size(); ++i) {
      if (!done[i] && frames[i].reply && frames[i].answers == next) {
        line.frames[i].ready_ns = time.end_ns + frames[i].latency_ns;
      }
    }
  }
  return line;
}

std::vector<std::size_t> best_order(std::span<const std::vector<std::size_t>> candidates,
                                    const OrderCost& cost) {
  std::vector<std::size_t> best = candidates.front();
  std::int64_t least = cost(best);
  for (const std::vector<std::size_t>& other : candidates.subspan(1)) {
    const std::int64_t its = cost(other);
    if (its < least) {
      least = its;
      best = other;
    }
  }
  if (best.size() <= kMaxImproved) {
    for (int round = 0; round < kMaxRounds && improve(best, least, cost); ++round) {
    }
  }
  return best;
}

}  // namespace geodesic::drivers
