// The messages of the socket bus. No sockets.
#include "drivers/bus/socket_bus_wire.hpp"

#include <algorithm>

namespace geodesic::drivers {
namespace {

constexpr std::uint32_t kLongIdMask = 0x1FFFFFFF;
constexpr std::uint32_t kShortIdMask = 0x7FF;

}  // namespace

void WireWriter::append(const void* data, std::size_t bytes) noexcept {
  std::memcpy(bytes_.data() + size_, data, bytes);
  size_ += bytes;
}

void WireWriter::add(const Frame& frame, std::int64_t stamp_ns) noexcept {
  WireFrameHeader header;
  header.stamp_ns = stamp_ns;
  header.id = frame.id;
  header.length = std::min<std::uint8_t>(frame.length, 64);
  header.flags = static_cast<std::uint8_t>(
      (frame.extended ? WireFrameHeader::kExtended : 0) | (frame.fd ? WireFrameHeader::kFd : 0) |
      (frame.bit_rate_switch ? WireFrameHeader::kBitRateSwitch : 0) |
      (frame.error ? WireFrameHeader::kError : 0) | (frame.remote ? WireFrameHeader::kRemote : 0));
  append(&header, sizeof header);
  append(frame.data.data(), frame.remote ? 0 : header.length);
  ++header_.frames;
}

void WireWriter::add_confirmation(std::int64_t stamp_ns) noexcept {
  WireFrameHeader header;
  header.stamp_ns = stamp_ns;
  header.flags = WireFrameHeader::kConfirmed;
  append(&header, sizeof header);
  ++header_.frames;
}

std::span<const std::byte> WireWriter::finish(std::uint16_t flags, std::uint64_t dropped) noexcept {
  header_.flags = flags;
  header_.dropped = dropped;
  std::memcpy(bytes_.data(), &header_, sizeof header_);
  return {bytes_.data(), size_};
}

void WireWriter::clear() noexcept {
  header_ = WireMessageHeader{};
  size_ = sizeof(WireMessageHeader);
}

WireReader::WireReader(std::span<const std::byte> message) noexcept {
  header_.magic = 0;
  if (message.size() >= sizeof header_) {
    std::memcpy(&header_, message.data(), sizeof header_);
    rest_ = message.subspan(sizeof header_);
    left_ = valid() ? header_.frames : 0;
  }
}

bool WireReader::next(Item& item) noexcept {
  WireFrameHeader header;
  if (left_ == 0 || rest_.size() < sizeof header) {
    return false;
  }
  std::memcpy(&header, rest_.data(), sizeof header);
  rest_ = rest_.subspan(sizeof header);
  // As in SocketCAN: neither FD nor error frames ask for anything.
  const bool remote = (header.flags & WireFrameHeader::kRemote) != 0 &&
                      (header.flags & (WireFrameHeader::kFd | WireFrameHeader::kError)) == 0;
  const std::size_t bytes = remote ? 0 : header.length;
  if (header.length > 64 || rest_.size() < bytes) {
    left_ = 0;
    return false;
  }
  item.confirmation = (header.flags & WireFrameHeader::kConfirmed) != 0;
  item.stamp_ns = header.stamp_ns;
  item.frame = Frame{};
  item.frame.extended = (header.flags & WireFrameHeader::kExtended) != 0;
  item.frame.fd = (header.flags & WireFrameHeader::kFd) != 0;
  item.frame.bit_rate_switch = (header.flags & WireFrameHeader::kBitRateSwitch) != 0;
  item.frame.error = (header.flags & WireFrameHeader::kError) != 0;
  item.frame.remote = remote;
  const bool long_id = item.frame.extended || item.frame.error;
  item.frame.id = header.id & (long_id ? kLongIdMask : kShortIdMask);
  item.frame.length = header.length;
  std::memcpy(item.frame.data.data(), rest_.data(), bytes);
  rest_ = rest_.subspan(bytes);
  --left_;
  return true;
}

}  // namespace geodesic::drivers
