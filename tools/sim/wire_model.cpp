// When frames would be on a real wire; see the header.
#include "tools/sim/wire_model.hpp"

#include <algorithm>
#include <limits>

#include "drivers/bus/arbitration.hpp"
#include "drivers/bus/bit_timing.hpp"

namespace geodesic::tools {

void WireModel::push_host(const drivers::Frame& frame, std::int64_t ready_ns) {
  host_.push_back({frame, ready_ns});
}

void WireModel::push_reply(const drivers::Frame& frame, std::int64_t ready_ns) {
  replies_.push_back({frame, ready_ns});
}

std::optional<WireModel::Choice> WireModel::choose() const {
  std::int64_t ready = std::numeric_limits<std::int64_t>::max();
  if (!host_.empty()) ready = host_.front().ready_ns;
  for (const Waiting& reply : replies_) ready = std::min(ready, reply.ready_ns);
  if (waiting() == 0) return std::nullopt;
  const std::int64_t start = std::max(free_ns_, ready);

  Choice best;
  const drivers::Frame* frame = nullptr;
  if (!host_.empty() && host_.front().ready_ns <= start) frame = &host_.front().frame;
  for (std::size_t i = 0; i < replies_.size(); ++i) {
    if (replies_[i].ready_ns > start) continue;
    const drivers::Frame& reply = replies_[i].frame;
    if (frame != nullptr && arbitration_key(*frame) <= arbitration_key(reply)) continue;
    frame = &reply;
    best = {true, i, 0};
  }
  best.end_ns = start + drivers::frame_time_ns(*frame, bit_rate_, data_bit_rate_);
  return best;
}

std::optional<std::int64_t> WireModel::next_end_ns() const {
  const std::optional<Choice> choice = choose();
  if (!choice) return std::nullopt;
  return choice->end_ns;
}

std::optional<WireModel::Delivery> WireModel::pop(std::int64_t now_ns) {
  const std::optional<Choice> choice = choose();
  if (!choice || choice->end_ns > now_ns) return std::nullopt;
  free_ns_ = choice->end_ns;
  Delivery delivery{{}, choice->reply, choice->end_ns};
  if (choice->reply) {
    delivery.frame = replies_[choice->index].frame;
    replies_.erase(replies_.begin() + static_cast<std::ptrdiff_t>(choice->index));
  } else {
    delivery.frame = host_.front().frame;
    host_.pop_front();
  }
  return delivery;
}

}  // namespace geodesic::tools
