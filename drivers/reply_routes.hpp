// Which joint of a bus a received identifier belongs to. What the frame means is the drive's.
#pragma once

#include <algorithm>
#include <cstddef>
#include <cstdint>
#include <vector>

#include "drivers/bus/bus.hpp"

namespace geodesic::drivers {

class ReplyRoutes {
 public:
  /// Not real-time.
  void add(const IdFilter& filter, std::size_t joint) {
    if (filter.mask == IdFilter::kExact && !filter.shared) {
      exact_.push_back({address(filter.id, filter.extended), joint});
      std::sort(exact_.begin(), exact_.end(),
                [](const Exact& a, const Exact& b) { return a.address < b.address; });
    } else {
      others_.push_back({filter, joint});
    }
  }

  /// Calls take(joint) for the joints the frame may be of, until one returns true. Real-time.
  template <class Take>
  void find(const Frame& frame, const Take& take) const noexcept {
    const std::uint64_t wanted = address(frame.id, frame.extended);
    const auto at = std::lower_bound(exact_.begin(), exact_.end(), wanted,
                                     [](const Exact& a, std::uint64_t b) { return a.address < b; });
    if (at != exact_.end() && at->address == wanted && take(at->joint)) {
      return;
    }
    for (const Other& other : others_) {
      if (other.filter.matches(frame.id, frame.extended) && take(other.joint)) {
        return;
      }
    }
  }

 private:
  struct Exact {
    std::uint64_t address = 0;
    std::size_t joint = 0;
  };
  struct Other {
    IdFilter filter;
    std::size_t joint = 0;
  };

  /// An identifier, the extended ones apart from the standard ones.
  static constexpr std::uint64_t address(std::uint32_t id, bool extended) noexcept {
    return (extended ? std::uint64_t{1} << 32U : 0U) | id;
  }

  std::vector<Exact> exact_;   // sorted
  std::vector<Other> others_;  // masked or shared
};

}  // namespace geodesic::drivers
