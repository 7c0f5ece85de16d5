// How long frames occupy a CAN bus. Sources as in the header.
#include "drivers/bus/bit_timing.hpp"

#include <algorithm>
#include <array>
#include <cmath>

namespace geodesic::drivers {
namespace {

constexpr std::array<std::size_t, 16> kLengths = {0, 1,  2,  3,  4,  5,  6,  7,
                                                  8, 12, 16, 20, 24, 32, 48, 64};

// CRC delimiter, ACK slot, ACK delimiter, end of frame (7), interframe space (3): never stuffed.
constexpr int kTail = 13;
// FD: CRC sequence, stuff count with its parity, and the fixed stuff bits: one before the first bit
// and one after every fourth of them (ISO 11898-1:2015, 10.4.2.6).
constexpr int kFdCrcShort = 4 + 17 + 6;
constexpr int kFdCrcLong = 4 + 21 + 7;
constexpr std::size_t kShortCrcBytes = 16;

constexpr int fd_crc_bits(std::size_t bytes) {
  return bytes <= kShortCrcBytes ? kFdCrcShort : kFdCrcLong;
}

// Bits before the data field. Classic: SOF, identifier, RTR (SRR), IDE, reserved, DLC. FD: up to
// and with BRS; ESI and DLC follow at the data rate.
constexpr int kClassicStandard = 1 + 11 + 1 + 1 + 1 + 4;
constexpr int kClassicExtended = 1 + 11 + 1 + 1 + 18 + 1 + 2 + 4;
constexpr int kFdStandard = 1 + 11 + 1 + 1 + 1 + 1 + 1;
constexpr int kFdExtended = 1 + 11 + 1 + 1 + 18 + 1 + 1 + 1 + 1;
constexpr int kFdEsiDlc = 1 + 4;
constexpr int kClassicCrc = 15;

unsigned dlc_of(std::size_t length) noexcept {
  const auto* const place = std::find(kLengths.begin(), kLengths.end(), length);
  return static_cast<unsigned>(place - kLengths.begin());
}

// Walks along the bits of a frame as they leave, counting them and their stuff bits.
class BitStream {
 public:
  void put(bool bit) noexcept {
    ++bits_;
    const bool feedback = bit != ((crc_ >> 14 & 1U) != 0);
    crc_ = (crc_ << 1 & 0x7FFFU) ^ (feedback ? kCrc15 : 0U);
    if (stuff_next_) {
      // The stuff bit is the opposite of the five before it and begins a run of its own.
      ++stuffed_;
      run_ = 1;
      last_ = !last_;
      stuff_next_ = false;
    }
    run_ = bit == last_ && !first_ ? run_ + 1 : 1;
    last_ = bit;
    first_ = false;
    stuff_next_ = run_ == kRun;
  }
  void put(std::uint32_t value, int width) noexcept {
    for (int i = width - 1; i >= 0; --i) {
      put((value >> i & 1U) != 0);
    }
  }
  void put(std::span<const std::uint8_t> bytes) noexcept {
    for (const std::uint8_t byte : bytes) {
      put(byte, 8);
    }
  }
  std::uint32_t crc15() const noexcept { return crc_; }
  /// Bits so far with the stuff bits between them.
  int count() const noexcept { return bits_ + stuffed_; }
  /// The same with the stuff bit that is due after the last, if one is.
  int count_closed() const noexcept { return count() + (stuff_next_ ? 1 : 0); }

 private:
  static constexpr int kRun = 5;
  static constexpr std::uint32_t kCrc15 = 0x4599;  // Bosch CAN 2.0, 3.1.1
  int bits_ = 0;
  int stuffed_ = 0;
  int run_ = 0;
  std::uint32_t crc_ = 0;
  bool last_ = true;  // the bus is recessive before SOF
  bool first_ = true;
  bool stuff_next_ = false;
};

void put_identifier(BitStream& stream, const Frame& frame) noexcept {
  stream.put(0, 1);  // SOF
  if (frame.extended) {
    stream.put(frame.id >> 18 & 0x7FFU, 11);
    stream.put(0b11, 2);  // SRR, IDE
    stream.put(frame.id & 0x3FFFFU, 18);
    stream.put(frame.remote ? 1 : 0, 1);  // RTR or RRS
  } else {
    stream.put(frame.id & 0x7FFU, 11);
    stream.put(frame.remote ? 0b10 : 0b00, 2);  // RTR or RRS, IDE
  }
}

FrameBits classic_bits(const Frame& frame, std::size_t length) noexcept {
  BitStream stream;
  put_identifier(stream, frame);
  stream.put(0, frame.extended ? 2 : 1);  // reserved
  stream.put(static_cast<std::uint32_t>(length), 4);
  stream.put({frame.data.data(), frame.remote ? 0 : length});  // its length is what it asks for
  stream.put(stream.crc15(), kClassicCrc);
  return {stream.count_closed() + kTail, 0};
}

// The CRC of an FD frame has stuff bits at fixed places, whatever its value, so it need not be
// computed: only what comes before it is stuffed by content. If a stuff bit is due just where the
// CRC field begins, the field's first fixed stuff bit is that bit.
FrameBits fd_bits(const Frame& frame, std::size_t length) noexcept {
  BitStream stream;
  put_identifier(stream, frame);
  stream.put(0b10, 2);  // FDF, reserved
  stream.put(frame.bit_rate_switch ? 1 : 0, 1);
  const int arbitration = stream.count();
  stream.put(0, 1);  // ESI: error-active
  stream.put(dlc_of(length), 4);
  stream.put({frame.data.data(), length});
  const int rest = stream.count() - arbitration + fd_crc_bits(length);
  return frame.bit_rate_switch ? FrameBits{arbitration + kTail, rest}
                               : FrameBits{arbitration + rest + kTail, 0};
}

std::int64_t time_ns(const FrameBits& bits, std::int64_t bit_rate,
                     std::int64_t data_bit_rate) noexcept {
  constexpr std::int64_t kSecond = 1'000'000'000;
  const std::int64_t nominal = (bits.nominal * kSecond + bit_rate - 1) / bit_rate;
  const std::int64_t data =
      bits.data > 0 ? (bits.data * kSecond + data_bit_rate - 1) / data_bit_rate : 0;
  return nominal + data;
}

}  // namespace

bool is_can_length(std::size_t bytes, bool fd) noexcept {
  return bytes <= 8 || (fd && std::find(kLengths.begin(), kLengths.end(), bytes) != kLengths.end());
}

std::size_t can_length(std::size_t bytes, bool fd) noexcept {
  if (!fd) {
    return std::min<std::size_t>(bytes, 8);
  }
  const auto* const place = std::lower_bound(kLengths.begin(), kLengths.end(), bytes);
  return place == kLengths.end() ? kLengths.back() : *place;
}

FrameBits frame_bits(const Frame& frame) noexcept {
  const std::size_t length = can_length(frame.length, frame.fd);
  return frame.fd ? fd_bits(frame, length) : classic_bits(frame, length);
}

FrameBits frame_bits(std::size_t bytes, bool extended, bool fd, bool bit_rate_switch,
                     Stuffing stuffing) noexcept {
  const std::size_t length = can_length(bytes, fd);
  const int payload = static_cast<int>(8 * length);
  const bool worst = stuffing == Stuffing::kWorst;
  // The first stuff bit can follow the fifth bit; as each counts in the run after it, then one
  // every fourth.
  const auto stuff = [worst](int bits) { return worst ? (bits - 1) / 4 : 0; };
  if (!fd) {
    const int bits = (extended ? kClassicExtended : kClassicStandard) + payload + kClassicCrc;
    return {bits + stuff(bits) + kTail, 0};
  }
  const int arbitration = extended ? kFdExtended : kFdStandard;
  const int stuffable = arbitration + kFdEsiDlc + payload;
  const int slow = arbitration + stuff(arbitration) + kTail;
  // None after the last bit before the CRC field, which begins with a fixed one.
  const int fast =
      kFdEsiDlc + payload + fd_crc_bits(length) + stuff(stuffable - 1) - stuff(arbitration);
  return bit_rate_switch ? FrameBits{slow, fast} : FrameBits{slow + fast, 0};
}

std::int64_t frame_time_ns(const Frame& frame, std::int64_t bit_rate,
                           std::int64_t data_bit_rate) noexcept {
  return time_ns(frame_bits(frame), bit_rate, data_bit_rate);
}

std::int64_t frame_time_ns(std::size_t bytes, bool extended, bool fd, bool bit_rate_switch,
                           std::int64_t bit_rate, std::int64_t data_bit_rate,
                           Stuffing stuffing) noexcept {
  return time_ns(frame_bits(bytes, extended, fd, bit_rate_switch, stuffing), bit_rate,
                 data_bit_rate);
}

BusBudget bus_budget(std::span<const CycleFrames> frames, double rate_hz, std::int64_t bit_rate,
                     std::int64_t data_bit_rate, double usable) {
  BusBudget budget;
  for (const CycleFrames& kind : frames) {
    const auto time = [&](Stuffing stuffing) {
      const std::int64_t one =
          frame_time_ns(kind.bytes, kind.extended, kind.fd, kind.bit_rate_switch, bit_rate,
                        data_bit_rate, stuffing);
      return std::llround(static_cast<double>(kind.count) * kind.share * static_cast<double>(one));
    };
    budget.frames += kind.count;
    budget.best_ns += time(Stuffing::kBest);
    budget.worst_ns += time(Stuffing::kWorst);
  }
  budget.usable = usable;
  budget.period_ns = std::llround(1e9 / rate_hz);
  budget.best_load = static_cast<double>(budget.best_ns) / static_cast<double>(budget.period_ns);
  budget.worst_load = static_cast<double>(budget.worst_ns) / static_cast<double>(budget.period_ns);
  budget.max_rate_hz =
      budget.worst_ns > 0 ? usable * 1e9 / static_cast<double>(budget.worst_ns) : 0.0;
  budget.carried = budget.worst_load <= usable;
  return budget;
}

}  // namespace geodesic::drivers
