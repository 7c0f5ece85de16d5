// Fuzz target: what arrives from a CAN socket or the socket bus, before any drive sees it.
#include <linux/can.h>

#include <cstring>
#include <vector>

#include "drivers/bus/bit_timing.hpp"
#include "drivers/bus/can_frame.hpp"
#include "drivers/bus/error_frame.hpp"
#include "drivers/bus/socket_bus_wire.hpp"
#include "drivers/bus/traffic.hpp"
#include "rt/heap_counter.hpp"
#include "tests/fuzz/fuzz.hpp"

namespace geodesic::fuzz {
namespace {

using drivers::Frame;

void check_frame(const Frame& frame) {
  expect(frame.length <= frame.data.size(), "no frame is longer than 64 bytes");
  expect(frame.id <= (frame.extended || frame.error ? CAN_EFF_MASK : CAN_SFF_MASK),
         "identifier without flags");
  for (std::size_t i = frame.length; i < frame.data.size(); ++i) {
    expect(frame.data[i] == 0, "nothing behind the end of the data");
  }
  if (drivers::is_can_length(frame.length, frame.fd)) {
    const drivers::FrameBits bits = drivers::frame_bits(frame);
    const auto bound = [&frame](drivers::Stuffing stuffing) {
      const std::size_t bytes = frame.remote ? 0 : frame.length;
      const drivers::FrameBits all =
          drivers::frame_bits(bytes, frame.extended, frame.fd, frame.bit_rate_switch, stuffing);
      return all.nominal + all.data;
    };
    expect(bits.nominal + bits.data >= bound(drivers::Stuffing::kBest) &&
               bits.nominal + bits.data <= bound(drivers::Stuffing::kWorst),
           "bits on the wire are between best and worst case");
  }
}

void kernel_frame(Input& input) {
  canfd_frame raw{};
  const std::size_t size = input.flag() ? CANFD_MTU : (input.flag() ? CAN_MTU : input.below(80));
  const Bytes bytes = input.take(sizeof raw);
  std::memcpy(&raw, bytes.data(), bytes.size());
  Frame frame;
  if (!drivers::decode_can_frame(raw, size, frame)) {
    expect(size != CAN_MTU && size != CANFD_MTU, "only odd sizes are refused");
    return;
  }
  check_frame(frame);
  expect(frame.length <= (size == CANFD_MTU ? CANFD_MAX_DLEN : CAN_MAX_DLEN), "length by size");
  canfd_frame again{};
  expect(drivers::encode_can_frame(frame, again) == size, "encoded as the same kind of frame");
  Frame back;
  expect(drivers::decode_can_frame(again, size, back) && back == frame, "decode(encode(x)) is x");
  if (frame.error) {
    control::BusState state;
    state.bus_off = input.flag();
    state.error_passive = input.flag();
    const bool restarted = drivers::apply_error_frame(frame, state);
    expect(!restarted || (!state.bus_off && !state.error_passive), "a restart clears both states");
  }
}

void wire_message(Input& input) {
  const Bytes bytes = input.rest();
  drivers::WireReader reader(std::as_bytes(bytes));
  drivers::WireReader::Item item;
  drivers::WireWriter writer;
  std::vector<drivers::WireReader::Item> items;
  while (reader.next(item)) {
    expect(reader.valid(), "nothing is read from a message that is not ours");
    check_frame(item.frame);
    items.push_back(item);
    expect(items.size() <= reader.header().frames, "no more frames than the header says");
  }
  // What a hub passes on is read as it was written.
  for (std::size_t i = 0; i < items.size(); ++i) {
    if (writer.full()) break;
    if (items[i].confirmation) {
      writer.add_confirmation(items[i].stamp_ns);
    } else {
      writer.add(items[i].frame, items[i].stamp_ns);
    }
  }
  const std::size_t written = writer.frames();
  drivers::WireReader again(writer.finish(0, 0));
  for (std::size_t i = 0; i < written; ++i) {
    expect(again.next(item) && item.confirmation == items[i].confirmation &&
               item.stamp_ns == items[i].stamp_ns &&
               (item.confirmation || item.frame == items[i].frame),
           "read(write(x)) is x");
  }
  expect(!again.next(item), "and nothing more");
}

/// The books of a bus: whatever arrives, the counters add up and the ring stays within its bounds.
void traffic(Input& input) {
  drivers::BusOptions options;
  options.fd = input.flag();
  if (input.flag()) options.receive = {{0x11, false}, {0x12, false}};
  options.transmit = {{0x01, false}, {0x02, false}};
  constexpr std::size_t kCapacity = 16;
  drivers::Traffic books(options, kCapacity);
  std::array<drivers::ReceivedFrame, 8> out;
  std::int64_t now_ns = 0;
  std::size_t arrived = 0;
  while (!input.empty()) {
    now_ns += static_cast<std::int64_t>(input.integer(3));
    const std::uint64_t calls = rt::heap_calls();
    switch (input.below(8)) {
      case 0:
        books.begin_send(now_ns);
        books.handed_over(input.below(4), 3, input.below(4), now_ns);
        break;
      case 1:
        books.confirmed();
        break;
      case 2:
        books.dropped(input.integer(2));
        break;
      case 3: {
        const std::size_t room = books.room();
        const std::size_t taken = books.take(out);
        expect(taken <= out.size() && books.room() == room + taken, "take() frees what it returns");
        break;
      }
      case 4:
        books.forget_in_flight();
        break;
      case 5:
        input.flag() ? books.went_down(now_ns) : books.came_up();
        break;
      default: {
        Frame frame;
        frame.error = input.below(8) == 0;
        frame.extended = frame.error || input.below(8) == 0;
        frame.id = static_cast<std::uint32_t>(input.below(0x20));
        frame.length = 8;
        const Bytes data = input.take(8);
        std::memcpy(frame.data.data(), data.data(), data.size());
        if (books.room() > 0 || frame.error) {
          books.arrived(frame, now_ns);
          arrived += frame.error ? 0U : 1U;
        }
        break;
      }
    }
    expect(rt::heap_calls() == calls, "the books of a bus never touch the heap");
    expect(books.room() <= kCapacity, "the ring holds no more than its capacity");
    expect(books.counters().received <= arrived, "no frame is counted that did not arrive");
  }
}

}  // namespace

void frames(Bytes bytes) {
  Input input(bytes);
  switch (input.below(4)) {
    case 0:
      return wire_message(input);
    case 1:
      return traffic(input);
    default:
      return kernel_frame(input);
  }
}

}  // namespace geodesic::fuzz
