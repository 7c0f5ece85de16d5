// When frames would be on a real wire: one bus, one frame at a time, arbitration by identifier,
// exact bit timing. Pure arithmetic on time stamps; sends nothing and knows no clock.
#pragma once

#include <cstdint>
#include <deque>
#include <optional>
#include <vector>

#include "drivers/bus/bus.hpp"
#include "drivers/bus/frame.hpp"

namespace geodesic::tools {

class WireModel {
 public:
  struct Delivery {
    drivers::Frame frame;
    bool reply = false;       ///< one of ours; else the host's
    std::int64_t end_ns = 0;  ///< its last bit was on the wire
  };

  WireModel(std::int64_t bit_rate, std::int64_t data_bit_rate) noexcept
      : bit_rate_(bit_rate), data_bit_rate_(data_bit_rate) {}

  /// A frame that the host's controller was handed at ready_ns: its frames leave in their order.
  void push_host(const drivers::Frame& frame, std::int64_t ready_ns);
  /// A drive's reply, ready to compete for the bus from ready_ns.
  void push_reply(const drivers::Frame& frame, std::int64_t ready_ns);

  /// When the next frame's last bit is due, by what is known now; nothing while nothing waits.
  std::optional<std::int64_t> next_end_ns() const;
  /// The next frame if it has ended by now_ns. What competes was fixed when its first bit was due.
  std::optional<Delivery> pop(std::int64_t now_ns);
  std::size_t waiting() const noexcept { return host_.size() + replies_.size(); }

 private:
  struct Waiting {
    drivers::Frame frame;
    std::int64_t ready_ns = 0;
  };
  struct Choice {
    bool reply = false;
    std::size_t index = 0;
    std::int64_t end_ns = 0;
  };
  std::optional<Choice> choose() const;

  std::int64_t bit_rate_;
  std::int64_t data_bit_rate_;
  std::int64_t free_ns_ = 0;  // the wire is idle from here on
  std::deque<Waiting> host_;
  std::vector<Waiting> replies_;
};

}  // namespace geodesic::tools
