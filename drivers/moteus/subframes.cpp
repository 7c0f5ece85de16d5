// moteus subframes, one way and the other; see subframes.hpp for contracts, README.md for sources.
#include "drivers/moteus/subframes.hpp"

#include <algorithm>
#include <array>
#include <bit>
#include <cmath>

#include "drivers/bus/bit_timing.hpp"

namespace geodesic::drivers::moteus {

namespace {

constexpr std::size_t kMostBytes = 64;
constexpr std::size_t kMostText = 48;
constexpr std::uint8_t kShortCount = 3;  ///< more than this is told in a byte of its own

double count_of(Quantity quantity, Resolution resolution) noexcept {
  const Scale& scale = kScales[static_cast<std::size_t>(quantity)];
  return resolution == Resolution::kInt8
             ? scale.int8
             : (resolution == Resolution::kInt16 ? scale.int16 : scale.int32);
}

std::int32_t top_of(Resolution resolution) noexcept {
  return resolution == Resolution::kInt8 ? 0x7F
                                         : (resolution == Resolution::kInt16 ? 0x7FFF : 0x7FFFFFFF);
}

Quantity quantity_of(std::uint32_t number) noexcept {
  const RegisterFact* fact = find_register(number);
  return fact != nullptr ? fact->quantity : Quantity::kInteger;
}

std::uint32_t number_of(Register number) noexcept {
  return static_cast<std::uint32_t>(number);
}

std::size_t varuint_size(std::uint32_t value) noexcept {
  std::size_t size = 1;
  for (; value > 0x7FU; value >>= 7U) {
    ++size;
  }
  return size;
}

void put(Frame& frame, std::uint32_t byte) noexcept {
  frame.data[frame.length++] = static_cast<std::uint8_t>(byte);
}

void put_varuint(Frame& frame, std::uint32_t value) noexcept {
  for (; value > 0x7FU; value >>= 7U) {
    put(frame, (value & 0x7FU) | 0x80U);
  }
  put(frame, value);
}

void put_value(Frame& frame, const Item& item) noexcept {
  const std::uint32_t raw =
      item.resolution == Resolution::kFloat
          ? std::bit_cast<std::uint32_t>(static_cast<float>(item.value))
          : std::bit_cast<std::uint32_t>(
                to_code(item.value, quantity_of(number_of(item.number)), item.resolution));
  for (std::size_t i = 0; i < bytes_of(item.resolution); ++i) {
    put(frame, raw >> (8U * i) & 0xFFU);
  }
}

/// How many items from the first on are neighbours of one resolution.
std::size_t run_of(std::span<const Item> items) noexcept {
  std::size_t run = 1;
  while (run < items.size() && items[run].resolution == items[0].resolution &&
         number_of(items[run].number) == number_of(items[0].number) + run) {
    ++run;
  }
  return run;
}

bool append(Frame& frame, std::span<const Item> items, std::uint8_t operation) noexcept {
  while (!items.empty()) {
    const std::size_t run = run_of(items);
    const std::uint32_t first = number_of(items[0].number);
    const bool counted = run > kShortCount;
    const std::size_t values =
        operation == opcode::kWrite ? run * bytes_of(items[0].resolution) : 0;
    if (frame.length + 1 + (counted ? 1U : 0U) + varuint_size(first) + values > kMostBytes) {
      return false;
    }
    put(frame, operation | static_cast<std::uint32_t>(items[0].resolution) << 2U |
                   (counted ? 0U : static_cast<std::uint32_t>(run)));
    if (counted) {
      put_varuint(frame, static_cast<std::uint32_t>(run));
    }
    put_varuint(frame, first);
    for (const Item& item : items.first(values > 0 ? run : 0)) {
      put_value(frame, item);
    }
    items = items.subspan(run);
  }
  return true;
}

}  // namespace

std::int32_t to_code(double value, Quantity quantity, Resolution resolution) noexcept {
  const std::int32_t top = top_of(resolution);
  if (!std::isfinite(value)) {
    return quantity == Quantity::kInteger ? 0 : -top - 1;
  }
  const double limit = static_cast<double>(top);
  return static_cast<std::int32_t>(
      std::clamp(std::round(value / count_of(quantity, resolution)), -limit, limit));
}

double from_code(std::int32_t code, Quantity quantity, Resolution resolution) noexcept {
  if (quantity != Quantity::kInteger && code == -top_of(resolution) - 1) {
    return std::nan("");
  }
  return static_cast<double>(code) * count_of(quantity, resolution);
}

Frame make_frame(const Address& address) noexcept {
  Frame frame;
  frame.id = to_id(address);
  frame.extended = frame.id > kLastStandardId;
  frame.fd = true;
  frame.bit_rate_switch = true;
  return frame;
}

bool append_writes(Frame& frame, std::span<const Item> items) noexcept {
  return append(frame, items, opcode::kWrite);
}

bool append_reads(Frame& frame, std::span<const Item> items) noexcept {
  return append(frame, items, opcode::kRead);
}

void pad(Frame& frame) noexcept {
  for (const std::size_t length = can_length(frame.length, true); frame.length < length;) {
    put(frame, opcode::kNop);
  }
}

bool Reader::fail() noexcept {
  malformed_ = true;
  at_ = bytes_.size();
  left_ = 0;
  return false;
}

bool Reader::varuint(std::uint32_t& value) noexcept {
  value = 0;
  for (unsigned shift = 0; shift < 35U && at_ < bytes_.size(); shift += 7U) {
    const std::uint32_t byte = bytes_[at_++];
    value |= (byte & 0x7FU) << shift;
    if (byte < 0x80U) {
      return true;
    }
  }
  return fail();
}

bool Reader::next(Entry& entry) noexcept {
  while (left_ == 0) {
    if (at_ >= bytes_.size()) {
      return false;
    }
    if (bytes_[at_] == opcode::kNop) {
      ++at_;
      continue;
    }
    if (!begin(entry)) {
      return false;
    }
    if (left_ == 0 && entry.kind != opcode::kNop) {
      return true;  // an error or a stream
    }
  }
  --left_;
  entry = group_;
  ++group_.number;
  return entry.kind == opcode::kRead || value(entry);
}

bool Reader::begin(Entry& entry) noexcept {
  entry = {};
  const std::uint8_t byte = bytes_[at_++];
  const auto kind = static_cast<std::uint8_t>(byte & 0xF0U);
  if (kind == opcode::kWrite || kind == opcode::kRead || kind == opcode::kReply) {
    group_ = {};
    group_.kind = kind;
    group_.resolution = static_cast<Resolution>(byte >> 2U & 3U);
    left_ = byte & 3U;
    std::uint32_t count = left_;
    if ((left_ == 0 && !varuint(count)) || !varuint(group_.number)) {
      return fail();
    }
    left_ = count;
    return count <= 0x200 ? true : fail();
  }
  if (byte == opcode::kWriteError || byte == opcode::kReadError) {
    std::uint32_t code = 0;
    if (!varuint(entry.number) || !varuint(code)) {
      return false;
    }
    entry.value = static_cast<double>(code);
    entry.kind = byte;
    return true;
  }
  entry.kind = byte;
  return stream(entry);
}

bool Reader::stream(Entry& entry) noexcept {
  std::uint32_t count = 0;
  if (entry.kind != opcode::kClientToServer && entry.kind != opcode::kServerToClient &&
      entry.kind != opcode::kClientPoll) {
    return fail();
  }
  if (!varuint(entry.number) || !varuint(count)) {
    return false;
  }
  entry.value = count;
  if (entry.kind == opcode::kClientPoll) {
    return true;
  }
  if (count > bytes_.size() - at_) {
    return fail();
  }
  // Text for people and numbers in ASCII: the bytes are characters.
  entry.text = {reinterpret_cast<const char*>(bytes_.data()) + at_, count};
  at_ += count;
  return true;
}

bool Reader::value(Entry& entry) noexcept {
  const std::size_t size = bytes_of(entry.resolution);
  if (size > bytes_.size() - at_) {
    return fail();
  }
  std::uint32_t raw = 0;
  for (std::size_t i = size; i-- > 0;) {
    raw = raw << 8U | bytes_[at_ + i];
  }
  at_ += size;
  if (entry.resolution == Resolution::kFloat) {
    entry.value = static_cast<double>(std::bit_cast<float>(raw));
    return true;
  }
  const auto unused = static_cast<unsigned>(32U - 8U * size);
  entry.code = std::bit_cast<std::int32_t>(raw << unused) >> unused;
  entry.saturated = std::abs(static_cast<double>(entry.code)) >= top_of(entry.resolution);
  entry.value = from_code(entry.code, quantity_of(entry.number), entry.resolution);
  return true;
}

void append_text(Frame& frame, std::uint32_t channel, std::string_view text) noexcept {
  text = text.substr(0, kMostText);
  put(frame, opcode::kClientToServer);
  put_varuint(frame, channel);
  put_varuint(frame, static_cast<std::uint32_t>(text.size()));
  for (const char letter : text) {
    put(frame, static_cast<unsigned char>(letter));
  }
}

void append_poll(Frame& frame, std::uint32_t channel) noexcept {
  put(frame, opcode::kClientPoll);
  put_varuint(frame, channel);
  put_varuint(frame, kMostText);
}

}  // namespace geodesic::drivers::moteus
