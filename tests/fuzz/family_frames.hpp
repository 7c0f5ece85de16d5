// What the fuzz targets of the drive families share: frames that look as if they were a drive's,
// made of the fuzzer's bytes, and whether a frame passes a family's filters.
#pragma once

#include <algorithm>
#include <vector>

#include "drivers/bus/bus.hpp"
#include "drivers/families.hpp"
#include "tests/fuzz/fuzz.hpp"

namespace geodesic::fuzz {

inline bool matches(const std::vector<drivers::IdFilter>& filters, const drivers::Frame& frame) {
  return std::any_of(filters.begin(), filters.end(), [&frame](const drivers::IdFilter& filter) {
    return filter.matches(frame.id, frame.extended);
  });
}

/// A frame on one of these identifiers (what their masks leave open is the fuzzer's), at times
/// another one, a remote one or one of a strange length.
inline drivers::Frame forged(Input& input, const std::vector<drivers::IdFilter>& filters, bool fd) {
  constexpr std::uint8_t kLengths[] = {8, 12, 16, 20, 24, 32, 48, 64};
  drivers::Frame frame;
  const drivers::IdFilter& filter = filters[input.below(filters.size())];
  const std::uint32_t widest = filter.extended ? 0x1FFFFFFFU : 0x7FFU;
  const std::size_t kind = input.below(16);
  const std::uint32_t open = ~filter.mask & widest;
  const std::uint32_t any =
      open != 0 || kind == 15 ? static_cast<std::uint32_t>(input.integer(4)) : 0;
  frame.id = kind == 15 ? any & widest : (filter.id & filter.mask & widest) | (any & open);
  frame.extended = filter.extended;
  frame.fd = fd;
  frame.bit_rate_switch = fd;
  frame.remote = kind == 14 && !fd;
  frame.length = 8;
  if (kind == 13) {
    frame.length = static_cast<std::uint8_t>(input.below(9));
  } else if (fd) {
    frame.length = kLengths[input.below(8)];
  }
  const Bytes data = input.take(frame.remote ? 0 : frame.length);
  std::copy(data.begin(), data.end(), frame.data.begin());
  return frame;
}

/// Words that can be shown, whatever the frame is.
inline void expect_words(const std::optional<drivers::DecodedFrame>& words) {
  if (!words) return;
  expect(!words->kind.empty(), "what is understood has a name");
  for (const drivers::DecodedField& field : words->fields) {
    expect(!field.name.empty() && !field.value.empty() && is_printable(field.value) &&
               is_printable(field.unit),
           "every field has a name and a value that can be shown");
  }
}

}  // namespace geodesic::fuzz
