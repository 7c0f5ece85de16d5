// In which order the drives of a bus are sent to, and what a cycle then looks like on the wire:
// what the families say of their frames, put into the model of bus/schedule.hpp. Sends nothing.
#pragma once

#include <cstddef>
#include <cstdint>
#include <vector>

#include "drivers/arm.hpp"
#include "drivers/bus/bit_timing.hpp"
#include "drivers/bus/schedule.hpp"
#include "drivers/families.hpp"

namespace geodesic::drivers {

/// What a drive takes to answer where its family does not say.
inline constexpr std::int64_t kUsualLatencyNs = 100'000;

/// All joints, bus by bus, in the order in which their commands leave: the one by which the last
/// reply comes earliest and replies follow each other evenly, looked at with drives that answer in
/// a half to four times the usual latency and with as few and as many stuff bits as there can be.
/// Among equals the configured order. Not real-time.
std::vector<std::size_t> sending_order(const ArmOptions& options);

/// The last of its family on its bus to be sent to: DriveOptions::leader.
bool is_leader(const ArmOptions& options, const std::vector<std::size_t>& order, std::size_t joint);

/// One frame of a cycle and whose it is.
struct PlannedFrame {
  std::size_t joint = 0;
  CyclicFrame frame;
  WireFrame wire;  ///< with as many stuff bits as there can be
};

/// One cycle on one bus.
struct CyclePlan {
  std::vector<std::size_t> order;    ///< joints of this bus
  std::vector<PlannedFrame> frames;  ///< commands in the order they leave in, then replies
  Timeline best;                     ///< no stuff bit but those that are always there
  Timeline worst;                    ///< as many as there can be
  std::int64_t latency_ns = 0;       ///< the longest
  BusBudget budget;

  /// Nothing of the cycle is on the wire later than this, whatever the frames hold.
  std::int64_t bound_ns() const noexcept { return worst.busy_ns + latency_ns; }
  /// Rate that bit timing alone would allow [Hz], and the one at which the last reply still comes
  /// before the next cycle's first command; 0: no frames.
  double limit_hz() const noexcept;
  double reachable_hz() const noexcept;
};

/// Of the frames that come in part of the cycles only (CyclicFrame::share), the longest are there:
/// as many as come on average, rounded up, and one more, since their senders know nothing of each
/// other. Not real-time.
/// @param bus         index into options.buses
/// @param latency_ns  of drives whose family does not say
CyclePlan plan_cycle(const ArmOptions& options, std::size_t bus, double rate_hz,
                     std::int64_t latency_ns = kUsualLatencyNs);

}  // namespace geodesic::drivers
