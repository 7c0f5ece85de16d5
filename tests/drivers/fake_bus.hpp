// A bus in memory for tests of what stands on buses: simulated drives answer at once, and frames
// can be lost, doubled, held back or made up. Allocates nothing once built.
#pragma once

#include <sys/eventfd.h>
#include <unistd.h>

#include <algorithm>
#include <array>
#include <cstdint>
#include <memory>
#include <utility>
#include <vector>

#include "drivers/bus/bus.hpp"
#include "drivers/drive.hpp"
#include "drivers/lockstep_tick.hpp"
#include "rt/clock.hpp"

namespace geodesic::drivers::test {

/// What a test sees and does of a FakeBus that its Arm owns.
struct FakeWire {
  std::vector<std::unique_ptr<SimulatedDrive>> drives;
  bool stalled = false;         ///< send takes nothing
  std::uint32_t mute_id = 0;    ///< what carries this identifier is lost
  std::uint32_t double_id = 0;  ///< what carries this identifier arrives twice
  std::uint32_t hold_id = 0;    ///< what carries this identifier waits for release()
  std::size_t sends = 0;        ///< calls of send
  std::size_t receives = 0;
  std::vector<Frame> sent;

  void put(const ReceivedFrame& received) {
    if (used < queue.size()) {
      queue[used++] = received;
    }
    signal();
  }

  void answer(const Frame& reply) {
    const ReceivedFrame received{reply, rt::now_ns()};
    if (reply.id == mute_id) {
      return;
    }
    if (reply.id == hold_id) {
      held[holding++ % held.size()] = received;
      return;
    }
    put(received);
    if (reply.id == double_id) {
      put(received);
    }
  }

  void release() {
    for (std::size_t i = 0; i < std::min(holding, held.size()); ++i) {
      put(held[i]);
    }
    holding = 0;
  }

  void signal() const {
    const std::uint64_t one = 1;
    [[maybe_unused]] const auto written = write(descriptor, &one, sizeof one);
  }

  int descriptor = eventfd(0, EFD_NONBLOCK);
  std::array<ReceivedFrame, 512> queue;
  std::size_t used = 0;
  std::array<ReceivedFrame, 8> held;
  std::size_t holding = 0;
  control::BusState state;
  BusCounters counters;
};

class FakeBus final : public Bus {
 public:
  explicit FakeBus(FakeWire& wire) : wire_(wire) { wire_.sent.reserve(100'000); }
  ~FakeBus() override { close(wire_.descriptor); }
  FakeBus(const FakeBus&) = delete;
  FakeBus& operator=(const FakeBus&) = delete;

  std::size_t send(std::span<const Frame> frames) noexcept override {
    ++wire_.sends;
    wire_.state.stalled = wire_.stalled;
    if (wire_.stalled) {
      wire_.counters.send_skipped += frames.size();
      return 0;
    }
    for (const Frame& frame : frames) {
      if (is_tick(frame)) {
        wire_.answer(frame);  // behind the drives' replies, as the simulated arm does
        continue;
      }
      wire_.sent.push_back(frame);
      for (const auto& drive : wire_.drives) {
        std::array<Frame, SimulatedDrive::kMaxReplies> replies;
        const std::size_t count = drive->receive(frame, rt::now_ns(), replies);
        for (std::size_t i = 0; i < count; ++i) {
          wire_.answer(replies[i]);
        }
      }
    }
    wire_.counters.sent += frames.size();
    return frames.size();
  }

  std::size_t receive(std::span<ReceivedFrame> out) noexcept override {
    ++wire_.receives;
    std::uint64_t signals = 0;
    [[maybe_unused]] const auto got = read(wire_.descriptor, &signals, sizeof signals);
    const std::size_t count = std::min(out.size(), wire_.used);
    std::copy_n(wire_.queue.begin(), count, out.begin());
    std::copy(wire_.queue.begin() + static_cast<std::ptrdiff_t>(count),
              wire_.queue.begin() + static_cast<std::ptrdiff_t>(wire_.used), wire_.queue.begin());
    wire_.used -= count;
    wire_.counters.received += count;
    if (wire_.used > 0) {
      wire_.signal();
    }
    return count;
  }

  int descriptor() const noexcept override { return wire_.descriptor; }
  const control::BusState& state() const noexcept override { return wire_.state; }
  const BusCounters& counters() const noexcept override { return wire_.counters; }

 private:
  FakeWire& wire_;
};

}  // namespace geodesic::drivers::test
