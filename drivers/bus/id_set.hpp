// A set of identifiers that answers in constant (11 bits) or logarithmic (29 bits) time; masks of
// 29 bits one after the other. No kernel filters: those are made where the socket is opened.
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
      if (!id.extended) {
        for (std::uint32_t one = 0; one <= kStandardMask; ++one) {
          if (((id.id ^ one) & id.mask & kStandardMask) == 0) {
            standard_.set(one);
          }
        }
      } else if (id.mask == IdFilter::kExact) {
        extended_.push_back(id.id);
      } else {
        masked_.push_back(id);
      }
    }
    std::sort(extended_.begin(), extended_.end());
  }

  /// Real-time.
  bool empty() const noexcept { return empty_; }

  /// Real-time.
  bool contains(const Frame& frame) const noexcept {
    if (frame.extended) {
      return std::binary_search(extended_.begin(), extended_.end(), frame.id) ||
             std::any_of(masked_.begin(), masked_.end(),
                         [&](const IdFilter& id) { return id.matches(frame.id, true); });
    }
    return standard_[frame.id & kStandardMask];
  }

 private:
  static constexpr std::uint32_t kStandardMask = 0x7FF;
  std::bitset<kStandardMask + 1> standard_;
  std::vector<std::uint32_t> extended_;  // sorted
  std::vector<IdFilter> masked_;         // extended too
  bool empty_;
};

}  // namespace geodesic::drivers
