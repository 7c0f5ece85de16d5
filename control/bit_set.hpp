// A set of joints, buses, arms or states in one word.
#pragma once

#include <cstddef>
#include <cstdint>

namespace geodesic::control {

/// Bit i is number i.
using BitSet = std::uint32_t;
constexpr BitSet bit(std::size_t index) noexcept {
  return BitSet{1} << index;
}
constexpr bool has(BitSet set, std::size_t index) noexcept {
  return (set & bit(index)) != 0;
}
/// The first `count` members, count <= 32.
constexpr BitSet first(std::size_t count) noexcept {
  return count >= 32 ? ~BitSet{0} : bit(count) - 1;
}

}  // namespace geodesic::control
