// How long each phase of the cycle takes, as histograms that any thread may read while it runs.
#pragma once

#include <cstdint>

#include "rt/clock.hpp"
#include "rt/histogram.hpp"

namespace geodesic::tools {

/// Filled by the real-time thread: begin() at the top of the cycle, then each *_done() in turn.
class Phases {
 public:
  /// measured: false in simulated time, where durations mean nothing and no clock is read.
  explicit Phases(bool measured) : measured_(measured) {}

  rt::Histogram transmit_ns;         ///< all commands handed to the kernel
  rt::Histogram exchange_ns;         ///< first send -> last reply read, or the deadline
  rt::Histogram compute_ns;          ///< estimate, supervise, evaluate, law, bound, encode
  rt::Histogram observe_ns;          ///< external torque and what else is watched for
  rt::Histogram publish_ns;          ///< telemetry
  rt::Histogram state_to_torque_ns;  ///< last reply read (not yet decoded) -> next encoded

  void begin() noexcept { began_ns_ = now_ns(); }

  void transmit_done() noexcept { add(transmit_ns, now_ns() - began_ns_); }

  void receive_done() noexcept {
    received_ns_ = now_ns();
    add(exchange_ns, received_ns_ - began_ns_);
  }

  /// last_read_ns: when the last reply was read; of an earlier cycle if there was none in this one.
  void compute_done(std::int64_t last_read_ns) noexcept {
    computed_ns_ = now_ns();
    add(compute_ns, computed_ns_ - received_ns_);
    if (last_read_ns >= began_ns_) {
      add(state_to_torque_ns, computed_ns_ - last_read_ns);
    }
  }

  void observe_done() noexcept {
    observed_ns_ = now_ns();
    add(observe_ns, observed_ns_ - computed_ns_);
  }

  void publish_done() noexcept { add(publish_ns, now_ns() - observed_ns_); }

 private:
  std::int64_t now_ns() const noexcept { return measured_ ? rt::now_ns() : 0; }

  void add(rt::Histogram& histogram, std::int64_t duration_ns) noexcept {
    if (measured_) {
      histogram.add(duration_ns);
    }
  }

  bool measured_;
  std::int64_t began_ns_ = 0;
  std::int64_t received_ns_ = 0;
  std::int64_t computed_ns_ = 0;
  std::int64_t observed_ns_ = 0;
};

}  // namespace geodesic::tools
