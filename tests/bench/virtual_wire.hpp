// A bus whose time is made up: simulated drives on the modelled wire, bit for bit, as fast as this
// machine can and alike on all of them. No sockets, no clock but Arm's own.
#pragma once

#include <sys/eventfd.h>
#include <unistd.h>

#include <algorithm>
#include <array>
#include <cstdint>
#include <memory>
#include <vector>

#include "drivers/bus/bit_timing.hpp"
#include "drivers/bus/bus.hpp"
#include "drivers/drive.hpp"
#include "drivers/lockstep_tick.hpp"
#include "rt/clock.hpp"
#include "tools/sim/wire_model.hpp"

namespace geodesic::bench {

/// What cycles have taken on one wire.
struct WireFigures {
  std::int64_t cycles = 0;
  std::int64_t busy_ns = 0;      ///< in all
  std::int64_t latest_ns = 0;    ///< end of a reply after its cycle's tick
  std::int64_t gap_ns = 0;       ///< longest between the ends of two replies of a cycle
  std::int64_t last_sum_ns = 0;  ///< of each cycle's last reply
  std::int64_t carried = 0;      ///< frames
};

/// For an Arm in simulated time (ArmOptions::simulated_time). Whoever steps it calls begin() first.
class VirtualWire final : public drivers::Bus {
 public:
  VirtualWire(const drivers::BusOptions& options, std::int64_t latency_ns, std::int64_t period_ns)
      : options_(options),
        wire_(options.bit_rate, options.data_bit_rate),
        latency_ns_(latency_ns),
        period_ns_(period_ns) {}
  ~VirtualWire() override { close(descriptor_); }
  VirtualWire(const VirtualWire&) = delete;
  VirtualWire& operator=(const VirtualWire&) = delete;

  void add(std::unique_ptr<drivers::SimulatedDrive> drive) { drives_.push_back(std::move(drive)); }
  void begin(std::int64_t tick_ns) { tick_ns_ = tick_ns; }
  WireFigures& figures() { return figures_; }

  /// The whole period passes on the wire at once.
  std::size_t send(std::span<const drivers::Frame> frames) noexcept override {
    bool ticks = false;
    for (const drivers::Frame& frame : frames) {
      ticks = ticks || drivers::is_tick(frame);  // which no real wire carries
      if (!drivers::is_tick(frame)) wire_.push_host(frame, tick_ns_);
    }
    last_reply_ns_ = 0;
    speak(tick_ns_);
    const std::int64_t end_ns = tick_ns_ + period_ns_;
    for (auto due = wire_.next_end_ns(); due && *due <= end_ns; due = wire_.next_end_ns()) {
      carry(*wire_.pop(*due));
    }
    if (ticks) deliver(drivers::tick_frame());
    ++figures_.cycles;
    figures_.last_sum_ns += last_reply_ns_ > 0 ? last_reply_ns_ - tick_ns_ : 0;
    counters_.sent += frames.size();
    return frames.size();
  }

  std::size_t receive(std::span<drivers::ReceivedFrame> out) noexcept override {
    const std::size_t count = std::min(out.size(), arrived_.size());
    std::copy_n(arrived_.begin(), count, out.begin());
    arrived_.erase(arrived_.begin(), arrived_.begin() + static_cast<std::ptrdiff_t>(count));
    std::uint64_t signals = 0;
    if (arrived_.empty()) [[maybe_unused]]
      const auto got = read(descriptor_, &signals, sizeof signals);
    counters_.received += count;
    return count;
  }

  int descriptor() const noexcept override { return descriptor_; }
  const control::BusState& state() const noexcept override { return state_; }
  const drivers::BusCounters& counters() const noexcept override { return counters_; }

 private:
  void speak(std::int64_t now_ns) {
    std::array<drivers::Frame, drivers::SimulatedDrive::kMaxReplies> frames;
    for (const auto& drive : drives_) {
      const std::size_t count = drive->speak(now_ns, frames);
      for (std::size_t i = 0; i < count; ++i) wire_.push_reply(frames[i], now_ns);
    }
  }

  void deliver(const drivers::Frame& frame) {
    // Arm asks its own clock whether a reply is older than its command.
    arrived_.push_back({frame, rt::now_ns() + rt::kNanosecondsPerSecond});
    const std::uint64_t one = 1;
    [[maybe_unused]] const auto written = write(descriptor_, &one, sizeof one);
  }

  void carry(const tools::WireModel::Delivery& delivery) {
    ++figures_.carried;
    figures_.busy_ns +=
        drivers::frame_time_ns(delivery.frame, options_.bit_rate, options_.data_bit_rate);
    if (delivery.reply) {
      figures_.latest_ns = std::max(figures_.latest_ns, delivery.end_ns - tick_ns_);
      if (last_reply_ns_ > 0) {
        figures_.gap_ns = std::max(figures_.gap_ns, delivery.end_ns - last_reply_ns_);
      }
      last_reply_ns_ = delivery.end_ns;
      deliver(delivery.frame);
      return;
    }
    std::array<drivers::Frame, drivers::SimulatedDrive::kMaxReplies> replies;
    for (const auto& drive : drives_) {
      const std::size_t count = drive->receive(delivery.frame, delivery.end_ns, replies);
      for (std::size_t i = 0; i < count; ++i) {
        wire_.push_reply(replies[i], delivery.end_ns + latency_ns_);
      }
    }
  }

  drivers::BusOptions options_;
  tools::WireModel wire_;
  std::int64_t latency_ns_;
  std::int64_t period_ns_;
  std::int64_t tick_ns_ = 0;
  std::int64_t last_reply_ns_ = 0;
  std::vector<std::unique_ptr<drivers::SimulatedDrive>> drives_;
  std::vector<drivers::ReceivedFrame> arrived_;
  WireFigures figures_;
  int descriptor_ = eventfd(0, EFD_NONBLOCK);
  control::BusState state_;
  drivers::BusCounters counters_;
};

}  // namespace geodesic::bench
