// Looks after an open CAN interface from the thread that tends its bus.
#include "drivers/bus/link_keeper.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <cerrno>
#include <cstring>
#include <utility>

#include "drivers/bus/bit_timing.hpp"
#include "drivers/bus/link_plan.hpp"

namespace geodesic::drivers {
namespace {

constexpr std::int64_t kLooksApartNs = 100'000'000;
constexpr std::int64_t kWindowNs = 1'000'000'000;
// A bus that is held for long is emptied again and again; it is told once in this time.
constexpr std::int64_t kPurgesToldApartNs = 10'000'000'000;
// Frames of nobody's that take more than this part of the bus may cost us ours.
constexpr double kBabbleShare = 0.25;

bool worse(ControllerState now, ControllerState before) {
  const auto rank = [](ControllerState state) {
    return state == ControllerState::kWarning   ? 1
           : state == ControllerState::kPassive ? 2
           : state == ControllerState::kBusOff  ? 3
                                                : 0;
  };
  return rank(now) > rank(before);
}

}  // namespace

LinkKeeper::LinkKeeper(const BusOptions& options, LinkPort& port, const CanLink& link)
    : options_(options), port_(port), link_(link) {
  came_back(link);
  health_.reopened = 0;
}

void LinkKeeper::tell(bool warning, std::string text) {
  const std::string label =
      options_.name.empty() || options_.name == options_.interface ? "" : options_.name + ": ";
  news_.push_back({warning, label + std::move(text)});
}

std::vector<BusNews> LinkKeeper::take_news() {
  return std::exchange(news_, {});
}

void LinkKeeper::came_back(const CanLink& link) {
  link_ = link;
  const LinkHealth before = health_;
  health_ = link.controller.value_or(LinkHealth{});
  health_.device = link.name;
  health_.purged = before.purged;
  health_.reopened = before.reopened + 1;
  window_ns_ = 0;
}

void LinkKeeper::went() {
  health_.device.clear();
  health_.state = ControllerState::kUnknown;
  health_.foreign_frames_hz = 0.0;
}

void LinkKeeper::look(std::int64_t now_ns, std::uint64_t received) {
  if (now_ns < next_look_ns_) {
    return;
  }
  next_look_ns_ = now_ns + kLooksApartNs;
  int error = 0;
  const auto found = port_.read(link_.name, error);
  if (!found || found->index != link_.index) {
    return;  // who sends finds out and has it opened anew
  }
  const CanLink before = std::exchange(link_, *found);
  const LinkHealth kept = health_;
  health_ = link_.controller.value_or(LinkHealth{});
  health_.device = link_.name;
  health_.purged = kept.purged;
  health_.reopened = kept.reopened;
  health_.foreign_frames_hz = kept.foreign_frames_hz;
  tell_changes(before);
  tell_foreign(now_ns, received);
}

void LinkKeeper::tell_changes(const CanLink& before) {
  if (before.up && !link_.up) {
    tell(true, fmt::format("somebody set interface {} down; it is left so; fix: {}", link_.name,
                           link_command(link_.name, options_, &link_)));
  } else if (!before.up && link_.up) {
    tell(false, fmt::format("interface {} is up again", link_.name));
  }
  if (!link_.controller || !before.controller || !link_.up) {
    return;
  }
  const LinkHealth& now = *link_.controller;
  const LinkHealth& then = *before.controller;
  const std::string counters =
      fmt::format("transmit errors {}, receive errors {}", now.transmit_errors, now.receive_errors);
  const bool left = now.bus_offs > then.bus_offs;
  if (left || (now.state == ControllerState::kBusOff && then.state != now.state)) {
    tell(true,
         fmt::format("{} left the bus (bus-off, {} times so far), {}", link_.name, now.bus_offs,
                     !stays_off()   ? fmt::format("it restarts {} ms later; look for a short "
                                                    "or a wrong bit rate",
                                                  link_.restart_ms.value_or(0))
                     : may_change() ? std::string("and stays away until a law is asked for "
                                                  "(restart_ms = 0)")
                                    : fmt::format("and stays away; fix: ip link set {} type "
                                                  "can restart",
                                                  link_.name)));
  } else if (worse(now.state, then.state)) {
    tell(true, fmt::format("{} is {}: {}; bus-off comes at 256; check termination (60 ohm between "
                           "CAN_H and CAN_L), cables, and that all have the same bit rate",
                           link_.name, to_string(now.state), counters));
  } else if (now.state == ControllerState::kActive && worse(then.state, now.state)) {
    tell(false, fmt::format("{} is error-active again: {}", link_.name, counters));
  }
}

// What the wire carried and nobody here let in: another robot's drives, or a node gone mad.
void LinkKeeper::tell_foreign(std::int64_t now_ns, std::uint64_t received) {
  if (!link_.has_controller()) {
    return;  // a virtual one counts what it sends as received
  }
  if (window_ns_ == 0 || link_.received < window_wire_) {
    window_ns_ = now_ns;
    window_wire_ = link_.received;
    window_received_ = received;
    return;
  }
  const std::int64_t elapsed = now_ns - window_ns_;
  if (elapsed < kWindowNs) {
    return;
  }
  const auto wire = static_cast<double>(link_.received - window_wire_);
  const auto ours = static_cast<double>(received - window_received_);
  health_.foreign_frames_hz = std::max(0.0, wire - ours) * 1e9 / static_cast<double>(elapsed);
  window_ns_ = now_ns;
  window_wire_ = link_.received;
  window_received_ = received;
  const double capacity =
      1e9 / static_cast<double>(frame_time_ns(8, false, false, false, options_.bit_rate,
                                              options_.data_bit_rate, Stuffing::kBest));
  const bool babbles = health_.foreign_frames_hz > kBabbleShare * capacity;
  if (babbles && !babbling_) {
    tell(true, fmt::format("{:.0f} frames a second on {} are nobody's of this robot, {:.0f} % of "
                           "what the bus can carry: a node babbles, or another machine shares the "
                           "bus; `candump {}` shows who",
                           health_.foreign_frames_hz, link_.name,
                           100.0 * health_.foreign_frames_hz / capacity, link_.name));
  }
  babbling_ = babbles;
}

bool LinkKeeper::purge(std::int64_t now_ns, std::int64_t held_ns) {
  int error = 0;
  const auto found = port_.read(link_.name, error);
  if (!found || found->index != link_.index || (!found->up && !half_purged_)) {
    return false;  // gone, or set down by somebody, who may have reasons
  }
  LinkChange change;
  change.up = false;
  NetlinkVerdict verdict = port_.change(link_.index, change);
  if (verdict.error == EPERM) {
    forbidden_ = true;
    tell(true, fmt::format("{}: nothing has left for {:.0f} ms, and what waits can only be thrown "
                           "away with CAP_NET_ADMIN: one cycle of old commands may still reach the "
                           "drives when the bus moves again",
                           link_.name, static_cast<double>(held_ns) * 1e-6));
    return false;
  }
  if (verdict.error == 0) {
    change.up = true;
    verdict = port_.change(link_.index, change);
    half_purged_ = verdict.error != 0;
  }
  if (verdict.error != 0) {
    tell(true, fmt::format("{}: its queue cannot be emptied ({}{}{})", link_.name,
                           std::strerror(verdict.error), verdict.reason.empty() ? "" : ": ",
                           verdict.reason));
    return false;
  }
  ++health_.purged;
  if (purge_told_ns_ == 0 || now_ns - purge_told_ns_ > kPurgesToldApartNs) {
    purge_told_ns_ = now_ns;
    tell(true, fmt::format("{}: nothing has left for {:.0f} ms; taken down and up again, so that "
                           "no old command can reach a drive",
                           link_.name, static_cast<double>(held_ns) * 1e-6));
  }
  return true;
}

}  // namespace geodesic::drivers
