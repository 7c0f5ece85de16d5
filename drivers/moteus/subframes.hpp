// moteus subframes: registers and their values as they stand in a frame, one way and the other.
// Pure functions for the host. Which registers make a command is codec.hpp's.
// Real-time throughout.
#pragma once

#include <cstddef>
#include <cstdint>
#include <span>
#include <string_view>

#include "drivers/bus/frame.hpp"
#include "drivers/moteus/layout.hpp"

namespace geodesic::drivers::moteus {

struct Address {
  std::uint32_t source = 0;
  std::uint32_t destination = 0;
  bool reply_wanted = false;
  std::uint32_t prefix = 0;
  bool operator==(const Address&) const = default;
};

constexpr std::uint32_t to_id(const Address& address) noexcept {
  return address.prefix << kPrefixShift | (address.reply_wanted ? kReplyWanted : 0U) |
         (address.source & 0x7FU) << kSourceShift | (address.destination & 0x7FU);
}
constexpr Address from_id(std::uint32_t id) noexcept {
  return {id >> kSourceShift & 0x7FU, id & 0x7FU, (id & kReplyWanted) != 0, id >> kPrefixShift};
}

/// An integer of that resolution: rounded to nearest, saturated; what is not finite, and for
/// measured quantities only, is the most negative one. Not for Resolution::kFloat.
std::int32_t to_code(double value, Quantity quantity, Resolution resolution) noexcept;
/// NaN for the most negative integer of a measured quantity.
double from_code(std::int32_t code, Quantity quantity, Resolution resolution) noexcept;

/// A register and how it stands in the frame; `value` where it is written.
struct Item {
  Register number = Register::kMode;
  Resolution resolution = Resolution::kInt8;
  double value = 0.0;
};

/// Empty, CAN FD with bit-rate switch, extended if the identifier asks for it.
Frame make_frame(const Address& address) noexcept;
/// Subframes that write or read `items` in their order; neighbours of one resolution share one.
/// What does not fit into the 64 bytes is left out. @return everything fitted.
bool append_writes(Frame& frame, std::span<const Item> items) noexcept;
bool append_reads(Frame& frame, std::span<const Item> items) noexcept;
/// No-ops up to the next length of CAN FD.
void pad(Frame& frame) noexcept;

/// A stream's piece: text for the drive (at most 48 characters), and the request for its own.
void append_text(Frame& frame, std::uint32_t channel, std::string_view text) noexcept;
void append_poll(Frame& frame, std::uint32_t channel) noexcept;

/// One register of a subframe, an error, or a piece of tunnelled text.
struct Entry {
  std::uint8_t kind = opcode::kNop;  ///< one of opcode, without count and resolution
  std::uint32_t number = 0;          ///< register; of a stream, its channel
  Resolution resolution = Resolution::kInt8;
  double value = 0.0;      ///< of writes and replies; of errors, their code
  std::int32_t code = 0;   ///< as it stood, of integers
  bool saturated = false;  ///< an integer at either end of its range
  std::string_view text;   ///< of streams; lives as long as the frame
};

/// Takes a frame apart, register by register; ends at the first byte that makes no sense.
class Reader {
 public:
  explicit Reader(const Frame& frame) noexcept : bytes_(frame.payload()) {}
  bool next(Entry& entry) noexcept;
  bool malformed() const noexcept { return malformed_; }

 private:
  bool fail() noexcept;
  bool varuint(std::uint32_t& value) noexcept;
  bool begin(Entry& entry) noexcept;
  bool stream(Entry& entry) noexcept;
  bool value(Entry& entry) noexcept;

  std::span<const std::uint8_t> bytes_;
  std::size_t at_ = 0;
  Entry group_;             ///< of the registers still to come
  std::uint32_t left_ = 0;  ///< how many
  bool malformed_ = false;
};

}  // namespace geodesic::drivers::moteus
