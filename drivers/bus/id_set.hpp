// A set of identifiers that answers in constant (11 bits) or logarithmic (29 bits) time. No kernel
// filters: those are made where the socket is opened.
#pragma once

#include <algorithm>
#include <bitset>
#include <cstdint>
#include <span>
#include <vector>

#include "drivers/bus/bus.hpp"

namespace geodesic::drivers {

class IdSet {
 public:
  /// Not real-time.
  explicit IdSet(std::span<const IdFilter> ids) : empty_(ids.empty()) {
    for (const IdFilter& id : ids) {
      if (id.extended) {
        extended_.push_back(id.id);
      } else {
        standard_.set(id.id & kStandardMask);
      }
    }
    std::sort(extended_.begin(), extended_.end());
  }

  /// Real-time.
  bool empty() const noexcept { return empty_; }

  /// Real-time.
  bool contains(const Frame& frame) const noexcept {
    if (frame.extended) {
      return std::binary_search(extended_.begin(), extended_.end(), frame.id);
    }
    return standard_[frame.id & kStandardMask];
  }

 private:
  static constexpr std::uint32_t kStandardMask = 0x7FF;
  std::bitset<kStandardMask + 1> standard_;
  std::vector<std::uint32_t> extended_;  // sorted
  bool empty_;
};

}  // namespace geodesic::drivers
