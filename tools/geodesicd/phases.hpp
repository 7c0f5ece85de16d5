// How long each phase of the cycle takes, as histograms that any thread may read while it runs.
#pragma once

#include <cstdint>

#include "rt/clock.hpp"
#include "rt/histogram.hpp"

namespace geodesic::tools {

/// Filled by the real-time thread: begin() at the top of the cycle, then each *_done() in turn.
class Phases {
 public:
  rt::Histogram transmit_ns;         ///< all commands handed to the kernel
  rt::Histogram exchange_ns;         ///< first send -> last reply read, or the deadline
  rt::Histogram compute_ns;          ///< estimate, supervise, evaluate, law, bound
  rt::Histogram publish_ns;          ///< telemetry
  rt::Histogram state_to_torque_ns;  ///< last reply read -> next commands ready

  void begin() noexcept { began_ns_ = rt::now_ns(); }

  void transmit_done() noexcept { transmit_ns.add(rt::now_ns() - began_ns_); }

  void receive_done() noexcept {
    received_ns_ = rt::now_ns();
    exchange_ns.add(received_ns_ - began_ns_);
  }

  void compute_done() noexcept {
    computed_ns_ = rt::now_ns();
    compute_ns.add(computed_ns_ - received_ns_);
    state_to_torque_ns.add(computed_ns_ - received_ns_);
  }

  void publish_done() noexcept { publish_ns.add(rt::now_ns() - computed_ns_); }

 private:
  std::int64_t began_ns_ = 0;
  std::int64_t received_ns_ = 0;
  std::int64_t computed_ns_ = 0;
};

}  // namespace geodesic::tools
