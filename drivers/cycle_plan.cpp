// The order of commands and the cycle it makes; see the header.
#include "drivers/cycle_plan.hpp"

#include <algorithm>
#include <array>
#include <cmath>
#include <map>
#include <numeric>
#include <span>
#include <string_view>
#include <utility>

#include "drivers/bus/arbitration.hpp"

namespace geodesic::drivers {
namespace {

constexpr double kOrderingRateHz = 1000.0;  // shares do not matter to the order
// Nobody knows a drive's latency well, and it varies: the order has to suit all of these.
constexpr std::array kLatencyFactors = {0.5, 1.0, 2.0, 4.0};
// Late by this much outweighs so many times that of unevenness.
constexpr std::int64_t kEndWeight = 16;
// Two frames that destroy each other cost more than any order can save.
constexpr std::int64_t kCollisionNs = 1'000'000;

/// A frame and its number among its drive's commands: a command's own, a reply's that it answers.
struct Numbered {
  static constexpr std::size_t kNone = WireFrame::kNothing;
  CyclicFrame frame;
  std::size_t command = kNone;
};

/// What one drive puts on its bus in a cycle.
struct DriveFrames {
  std::size_t joint = 0;
  std::string_view family;
  std::vector<Numbered> commands;
  std::vector<Numbered> replies;
  std::vector<Numbered>
      for_all;  ///< that its family's leader sends after its own; one drive has it
};

std::uint32_t key_of(const CyclicFrame& cyclic) {
  Frame frame;
  frame.id = cyclic.id;
  frame.extended = cyclic.extended;
  return arbitration_key(frame);
}

/// How the frames of a bus are encoded, and how long they take.
class Encoding {
 public:
  explicit Encoding(const BusOptions& bus) : bus_(bus) {}

  CycleFrames of(const CyclicFrame& frame) const {
    const bool fd = bus_.fd && !frame.classic;
    return {1, frame.bytes, frame.extended, fd, fd && frame.bit_rate_switch, frame.share};
  }
  std::int64_t duration_ns(const CyclicFrame& frame, Stuffing stuffing) const {
    const CycleFrames as = of(frame);
    return frame_time_ns(as.bytes, as.extended, as.fd, as.bit_rate_switch, bus_.bit_rate,
                         bus_.data_bit_rate, stuffing);
  }

 private:
  const BusOptions& bus_;
};

std::vector<DriveFrames> frames_of_bus(const ArmOptions& options, std::size_t bus, double rate_hz) {
  std::vector<DriveFrames> all;
  for (std::size_t joint = 0; joint < options.joints.size(); ++joint) {
    const DriveOptions& drive = options.joints[joint].drive;
    const Family* family = find_family(drive.family);
    if (options.joints[joint].bus != bus || family == nullptr) continue;
    const bool first = std::none_of(all.begin(), all.end(), [family](const DriveFrames& other) {
      return other.family == family->name;
    });
    DriveFrames& one = all.emplace_back();
    one.joint = joint;
    one.family = family->name;
    std::size_t answered = 0;
    for (const CyclicFrame& frame : family->cyclic_frames(drive, rate_hz)) {
      if (frame.once_a_bus) {
        if (first) one.for_all.push_back({frame});
      } else if (!frame.reply) {
        one.commands.push_back({frame, one.commands.size()});
      } else if (frame.unasked || one.commands.empty()) {
        one.replies.push_back({frame});
      } else {
        one.replies.push_back({frame, std::min(answered++, one.commands.size() - 1)});
      }
    }
  }
  return all;
}

template <class What>
void each_list(std::vector<DriveFrames>& drives, What&& what) {
  for (DriveFrames& drive : drives) {
    what(drive.commands);
    what(drive.replies);
    what(drive.for_all);
  }
}

/// Leaves of the frames that come in part of the cycles only as many as come on average and one.
void thin_out(std::vector<DriveFrames>& drives, const Encoding& encoding) {
  std::vector<std::int64_t> rare;
  double shares = 0.0;
  each_list(drives, [&](const std::vector<Numbered>& list) {
    for (const Numbered& one : list) {
      if (one.frame.share >= 1.0) continue;
      rare.push_back(encoding.duration_ns(one.frame, Stuffing::kWorst));
      shares += one.frame.share;
    }
  });
  std::sort(rare.rbegin(), rare.rend());
  const auto usual = static_cast<std::size_t>(std::ceil(shares - 1e-9));
  rare.resize(std::min(rare.size(), usual + 1));
  each_list(drives, [&](std::vector<Numbered>& list) {
    std::vector<Numbered> kept;
    for (const Numbered& one : list) {
      // One that comes more often than once a cycle is there as often.
      auto times = static_cast<std::size_t>(std::ceil(one.frame.share - 1e-9));
      if (one.frame.share < 1.0) {
        const std::int64_t duration = encoding.duration_ns(one.frame, Stuffing::kWorst);
        const auto found = std::find(rare.begin(), rare.end(), duration);
        times = found != rare.end() ? 1 : 0;
        if (found != rare.end()) rare.erase(found);
      }
      kept.insert(kept.end(), times, one);
    }
    list = std::move(kept);
  });
}

/// Puts a cycle together, drive by drive.
class Composer {
 public:
  Composer(const Encoding& encoding, Stuffing stuffing, std::int64_t usual_ns, double factor)
      : encoding_(encoding), stuffing_(stuffing), usual_ns_(usual_ns), factor_(factor) {}

  /// @return its place
  std::size_t add(std::size_t joint, const CyclicFrame& frame, std::size_t answers) {
    const std::int64_t latency = frame.latency_ns > 0 ? frame.latency_ns : usual_ns_;
    WireFrame wire{key_of(frame), encoding_.duration_ns(frame, stuffing_), frame.reply, answers,
                   std::llround(factor_ * static_cast<double>(latency))};
    if (!frame.reply || answers == WireFrame::kNothing) wire.latency_ns = 0;
    wire.sender = joint;
    frames_.push_back({joint, frame, wire});
    return frames_.size() - 1;
  }
  std::vector<PlannedFrame> take() { return std::move(frames_); }

 private:
  const Encoding& encoding_;
  Stuffing stuffing_;
  std::int64_t usual_ns_;
  double factor_;
  std::vector<PlannedFrame> frames_;
};

/// The cycle in an order (of indices into `drives`).
std::vector<PlannedFrame> compose(const std::vector<DriveFrames>& drives,
                                  std::span<const std::size_t> order, Composer composer) {
  constexpr std::size_t kNothing = WireFrame::kNothing;
  std::map<std::string_view, std::size_t> last;  // of each family
  for (const std::size_t i : order) last[drives[i].family] = i;
  std::map<std::string_view, std::size_t> called;  // by what the leader sends for all
  std::vector<std::map<std::size_t, std::size_t>> places(drives.size());  // of numbered commands
  for (const std::size_t i : order) {
    const DriveFrames& drive = drives[i];
    for (const Numbered& one : drive.commands) {
      places[i][one.command] = composer.add(drive.joint, one.frame, kNothing);
    }
    if (last[drive.family] != i) continue;
    for (const DriveFrames& other : drives) {
      if (other.family != drive.family) continue;
      for (const Numbered& one : other.for_all) {
        called[drive.family] = composer.add(drive.joint, one.frame, kNothing);
      }
    }
  }
  for (const std::size_t i : order) {
    const auto together = called.find(drives[i].family);
    for (const Numbered& one : drives[i].replies) {
      std::size_t answers = kNothing;
      if (one.command != kNothing || (!one.frame.unasked && together != called.end())) {
        const auto place = places[i].find(one.command);
        answers = together != called.end()   ? together->second
                  : place != places[i].end() ? place->second
                                             : kNothing;
      }
      composer.add(drives[i].joint, one.frame, answers);
    }
  }
  return composer.take();
}

std::vector<WireFrame> wire_of(const std::vector<PlannedFrame>& frames) {
  std::vector<WireFrame> wire;
  wire.reserve(frames.size());
  for (const PlannedFrame& frame : frames) wire.push_back(frame.wire);
  return wire;
}

/// Orders worth a try: as configured, and sorted by what decides who waits for whom.
std::vector<std::vector<std::size_t>> candidates_of(const std::vector<DriveFrames>& drives) {
  std::vector<std::size_t> order(drives.size());
  std::iota(order.begin(), order.end(), std::size_t{0});
  std::vector<std::vector<std::size_t>> all{order};
  const auto sorted = [&](auto&& value) {
    std::vector<std::size_t> other = order;
    std::stable_sort(other.begin(), other.end(), [&](std::size_t a, std::size_t b) {
      return value(drives[a]) < value(drives[b]);
    });
    all.push_back(other);
    std::stable_sort(other.begin(), other.end(), [&](std::size_t a, std::size_t b) {
      return value(drives[a]) > value(drives[b]);
    });
    all.push_back(other);
  };
  const auto first_key = [](const std::vector<Numbered>& frames) {
    return frames.empty() ? 0U : key_of(frames.front().frame);
  };
  sorted([&](const DriveFrames& drive) { return first_key(drive.commands); });
  sorted([&](const DriveFrames& drive) { return first_key(drive.replies); });
  sorted([](const DriveFrames& drive) {
    return drive.replies.empty() ? std::int64_t{0} : drive.replies.front().frame.latency_ns;
  });
  return all;
}

/// Joints of one bus, in the order to send to them.
std::vector<std::size_t> order_of_bus(const ArmOptions& options, std::size_t bus) {
  std::vector<DriveFrames> drives = frames_of_bus(options, bus, kOrderingRateHz);
  const Encoding encoding(options.buses[bus]);
  each_list(drives, [](std::vector<Numbered>& list) {
    std::erase_if(list, [](const Numbered& one) { return one.frame.share < 0.5; });
  });
  const auto cost = [&](std::span<const std::size_t> order) {
    std::int64_t sum = 0;
    for (const Stuffing stuffing : {Stuffing::kBest, Stuffing::kWorst}) {
      for (const double factor : kLatencyFactors) {
        const Timeline line = lay_out(
            wire_of(compose(drives, order, Composer(encoding, stuffing, kUsualLatencyNs, factor))));
        sum +=
            kEndWeight * (line.end_ns + static_cast<std::int64_t>(line.collisions) * kCollisionNs) +
            line.gap_ns;
      }
    }
    return sum;
  };
  const std::vector<std::vector<std::size_t>> candidates = candidates_of(drives);
  std::vector<std::size_t> joints;
  for (const std::size_t i : best_order(candidates, cost)) joints.push_back(drives[i].joint);
  return joints;
}

}  // namespace

std::vector<std::size_t> sending_order(const ArmOptions& options) {
  std::vector<std::size_t> order;
  for (std::size_t bus = 0; bus < options.buses.size(); ++bus) {
    const std::vector<std::size_t> joints = order_of_bus(options, bus);
    order.insert(order.end(), joints.begin(), joints.end());
  }
  return order;
}

bool is_leader(const ArmOptions& options, const std::vector<std::size_t>& order,
               std::size_t joint) {
  const JointOptions& one = options.joints[joint];
  const auto last = std::find_if(order.rbegin(), order.rend(), [&](std::size_t other) {
    return options.joints[other].bus == one.bus &&
           options.joints[other].drive.family == one.drive.family;
  });
  return last != order.rend() && *last == joint;
}

double CyclePlan::limit_hz() const noexcept {
  return worst.busy_ns > 0 ? 1e9 / static_cast<double>(worst.busy_ns) : 0.0;
}

double CyclePlan::reachable_hz() const noexcept {
  return worst.end_ns > 0 ? 1e9 / static_cast<double>(worst.end_ns) : 0.0;
}

CyclePlan plan_cycle(const ArmOptions& options, std::size_t bus, double rate_hz,
                     std::int64_t latency_ns) {
  CyclePlan plan;
  plan.order = order_of_bus(options, bus);
  const Encoding encoding(options.buses[bus]);
  std::vector<DriveFrames> drives = frames_of_bus(options, bus, rate_hz);
  std::vector<CycleFrames> kinds;
  each_list(drives, [&](const std::vector<Numbered>& list) {
    for (const Numbered& one : list) kinds.push_back(encoding.of(one.frame));
  });
  plan.budget =
      bus_budget(kinds, rate_hz, options.buses[bus].bit_rate, options.buses[bus].data_bit_rate);
  thin_out(drives, encoding);
  std::vector<std::size_t> order;
  for (const std::size_t joint : plan.order) {
    const auto place = std::find_if(drives.begin(), drives.end(),
                                    [joint](const auto& drive) { return drive.joint == joint; });
    order.push_back(static_cast<std::size_t>(place - drives.begin()));
  }
  const auto composed = [&](Stuffing stuffing) {
    return compose(drives, order, Composer(encoding, stuffing, latency_ns, 1.0));
  };
  plan.best = lay_out(wire_of(composed(Stuffing::kBest)));
  plan.frames = composed(Stuffing::kWorst);
  plan.worst = lay_out(wire_of(plan.frames));
  for (const PlannedFrame& frame : plan.frames) {
    plan.latency_ns = std::max(plan.latency_ns, frame.wire.latency_ns);
  }
  return plan;
}

}  // namespace geodesic::drivers
