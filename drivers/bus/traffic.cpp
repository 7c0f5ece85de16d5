// The books of one opened bus. No system calls, no sockets.
#include "drivers/bus/traffic.hpp"

#include <algorithm>

#include "drivers/bus/bit_timing.hpp"
#include "drivers/bus/error_frame.hpp"

namespace geodesic::drivers {
namespace {

// Long enough for a person or a supervisor to see it, short enough to go once the cause has gone.
constexpr std::int64_t kForeignMemoryNs = 1'000'000'000;

}  // namespace

Traffic::Traffic(const BusOptions& options, std::size_t held_capacity)
    : receive_(options.receive),
      transmit_(options.transmit),
      fd_(options.fd),
      frame_ns_(2 * frame_time_ns(options.fd ? 64 : 8, true, options.fd, options.fd,
                                  options.bit_rate, options.data_bit_rate, Stuffing::kWorst)),
      held_(held_capacity) {}

void Traffic::arrived(const Frame& frame, std::int64_t stamp_ns) noexcept {
  if (frame.error) {
    ++counters_.error_frames;
    if (apply_error_frame(frame, state_)) {
      confirmations_lost_ = true;  // a restart empties the controller
    }
    if (receive_.empty()) {
      hold(frame, stamp_ns);
    }
    return;
  }
  if (state_.down && stamp_ns > down_ns_) {  // older ones had waited to be read
    came_up();
  }
  const bool wanted = receive_.contains(frame);
  if (!wanted && transmit_.contains(frame)) {
    // An identifier in both lists is a drive that answers on the one it is commanded by.
    ++counters_.foreign_commands;
    state_.foreign_commander = true;
    foreign_ns_ = stamp_ns;
  }
  // A remote frame asks a drive for an answer; to who commands, it is none.
  const bool readable = (fd_ || !frame.fd) && !(frame.remote && commands());
  if (receive_.empty() || (wanted && readable)) {
    ++counters_.received;
    hold(frame, stamp_ns);
  }
}

void Traffic::confirmed() noexcept {
  doubted_ = false;
  if (forgotten_ > 0) {
    --forgotten_;
    ++confirmed_forgotten_;
    return;
  }
  in_flight_ -= in_flight_ > 0 ? 1 : 0;
  if (bus_off_before_send_) {
    // A frame handed over after the bus-off has left: the controller is back, though nobody said
    // so.
    state_.bus_off = false;
    bus_off_before_send_ = false;
  }
}

void Traffic::dropped(std::uint64_t total) noexcept {
  if (total > drops_seen_) {
    counters_.receive_dropped += total - drops_seen_;
    drops_seen_ = total;
    confirmations_lost_ = true;
  }
}

void Traffic::hold(const Frame& frame, std::int64_t stamp_ns) noexcept {
  if (room() == 0) {
    ++counters_.receive_dropped;
    return;
  }
  ReceivedFrame& slot = held_[(held_first_ + held_count_) % held_.size()];
  slot.frame = frame;
  slot.stamp_ns = stamp_ns;
  ++held_count_;
}

std::size_t Traffic::take(std::span<ReceivedFrame> out) noexcept {
  const std::size_t n = std::min(out.size(), held_count_);
  for (std::size_t i = 0; i < n; ++i) {
    out[i] = held_[held_first_];
    held_first_ = (held_first_ + 1) % held_.size();
  }
  held_count_ -= n;
  return n;
}

void Traffic::begin_send(std::int64_t now_ns) noexcept {
  if (state_.foreign_commander && now_ns - foreign_ns_ > kForeignMemoryNs) {
    state_.foreign_commander = false;
  }
}

void Traffic::skipped(std::size_t frames) noexcept {
  counters_.send_skipped += frames;
  state_.stalled = true;
}

void Traffic::handed_over(std::size_t sent, std::size_t offered, std::size_t commanded,
                          std::int64_t now_ns) noexcept {
  state_.stalled = false;
  counters_.sent += sent;
  counters_.send_failed += offered - sent;
  if (sent > 0) {
    if (state_.down) {
      came_up();
    }
    in_flight_ += commanded;
    confirmed_forgotten_ = 0;
    handed_over_ns_ = now_ns;
    handed_over_bits_ns_ = static_cast<std::int64_t>(sent) * frame_ns_;
    confirmations_lost_ = false;
    bus_off_before_send_ = state_.bus_off;
  }
}

void Traffic::failed(int error_number) noexcept {
  counters_.last_errno = error_number;
}

void Traffic::forget_in_flight() noexcept {
  in_flight_ = 0;
  forgotten_ = 0;
  confirmations_lost_ = false;
}

bool Traffic::doubt_in_flight() noexcept {
  if (doubted_) {
    return false;
  }
  doubted_ = true;
  // As many confirmations as were due have come since: they were these frames' own, and the
  // confirmations of the frames forgotten before are lost indeed.
  const bool came_after_all = confirmed_forgotten_ > 0 && confirmed_forgotten_ >= in_flight_;
  forgotten_ = came_after_all ? 0 : forgotten_ + in_flight_;
  in_flight_ = 0;
  return true;
}

void Traffic::purged() noexcept {
  forget_in_flight();
  doubted_ = false;
  controller_afresh();
}

void Traffic::went_down(std::int64_t now_ns) noexcept {
  state_.down = true;
  down_ns_ = now_ns;
  controller_afresh();
}

void Traffic::came_up() noexcept {
  state_.down = false;
  controller_afresh();
}

void Traffic::restart_expected() noexcept {
  state_.bus_off = false;
}

// Down or up, the controller starts anew and what waited in it has gone.
void Traffic::controller_afresh() noexcept {
  state_.bus_off = false;
  state_.error_passive = false;
  confirmations_lost_ = true;
}

}  // namespace geodesic::drivers
