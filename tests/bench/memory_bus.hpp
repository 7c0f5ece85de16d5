// A bus in memory that costs next to nothing: frames are kept by send(), simulated drives answer
// when they are told to, receive() gives their replies. Nothing is lost here.
#pragma once

#include <sys/eventfd.h>
#include <unistd.h>

#include <algorithm>
#include <array>
#include <cstdint>
#include <memory>
#include <vector>

#include "drivers/bus/bus.hpp"
#include "drivers/drive.hpp"
#include "rt/clock.hpp"

namespace geodesic::bench {

class MemoryBus final : public drivers::Bus {
 public:
  MemoryBus() = default;
  ~MemoryBus() override { ::close(signal_); }
  MemoryBus(const MemoryBus&) = delete;
  MemoryBus& operator=(const MemoryBus&) = delete;

  void add(std::unique_ptr<drivers::SimulatedDrive> drive) { drives_.push_back(std::move(drive)); }

  /// Lets every drive answer what was sent. Outside what is measured.
  void answer(std::int64_t tick_ns) {
    const std::int64_t now = rt::now_ns();
    for (std::size_t i = 0; i < sent_; ++i) {
      for (const auto& drive : drives_) {
        std::array<drivers::Frame, 1> reply;
        if (drive->receive(frames_[i], tick_ns, reply) == 1 && replied_ < replies_.size()) {
          replies_[replied_++] = {reply[0], now};
        }
      }
    }
    sent_ = 0;
    ::eventfd_write(signal_, 1);
  }

  std::size_t send(std::span<const drivers::Frame> frames) noexcept override {
    sent_ = std::min(frames.size(), frames_.size());
    std::copy_n(frames.begin(), sent_, frames_.begin());
    counters_.sent += sent_;
    return sent_;
  }

  std::size_t receive(std::span<drivers::ReceivedFrame> out) noexcept override {
    eventfd_t signals = 0;
    ::eventfd_read(signal_, &signals);
    const std::size_t count = std::min(out.size(), replied_);
    std::copy_n(replies_.begin(), count, out.begin());
    replied_ = 0;
    counters_.received += count;
    return count;
  }

  int descriptor() const noexcept override { return signal_; }
  const control::BusState& state() const noexcept override { return state_; }
  const drivers::BusCounters& counters() const noexcept override { return counters_; }

 private:
  std::vector<std::unique_ptr<drivers::SimulatedDrive>> drives_;
  std::array<drivers::Frame, kMaxBatch> frames_{};
  std::array<drivers::ReceivedFrame, kMaxBatch> replies_{};
  std::size_t sent_ = 0;
  std::size_t replied_ = 0;
  int signal_ = ::eventfd(0, EFD_NONBLOCK | EFD_CLOEXEC);
  control::BusState state_;
  drivers::BusCounters counters_;
};

}  // namespace geodesic::bench
