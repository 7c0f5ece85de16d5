// The simulated arm in real time: replies leave when a real wire would have carried them.
#include <sched.h>

#include <algorithm>
#include <limits>
#include <vector>

#include "rt/clock.hpp"
#include "tools/sim/loops.hpp"
#include "tools/sim/wire_model.hpp"

namespace geodesic::tools {
namespace {

constexpr std::int64_t kLongestNapNs = 5'000'000;  // watchdogs and the trace need no frame
constexpr std::int64_t kNever = std::numeric_limits<std::int64_t>::max();
constexpr int kMechanicsPriority = 10;
constexpr std::int64_t kMostLeadNs = 150'000;
constexpr std::int64_t kMostFlood = 64;          // frames at once
constexpr std::int64_t kGiveUpNs = 250'000'000;  // behind by more: time is lost, not caught up

class RealTime {
 public:
  explicit RealTime(const LoopContext& context)
      : in_(context),
        nap_ns_(std::min(kLongestNapNs, context.robot.period_ns)),
        latency_ns_(std::llround(context.robot.simulation.reply_latency_s * 1e9)) {
    for (const drivers::BusOptions& bus : in_.robot.arm.buses) {
      wires_.emplace_back(bus.bit_rate, bus.data_bit_rate);
    }
  }

  void run() {
    const std::int64_t end = in_.settings.seconds > 0.0
                                 ? in_.plant.now_ns() + std::llround(in_.settings.seconds * 1e9)
                                 : kNever;
    while (!in_.stop.load()) {
      const std::int64_t now = rt::now_ns();
      catch_up(now);
      bool heard = false;
      in_.buses.read([&](std::size_t bus, const drivers::Frame& frame, std::int64_t stamp_ns) {
        if (in_.settings.wire) {
          wires_[bus].push_host(frame, std::min(stamp_ns, now));
        } else {
          hear(bus, frame, now);
          heard = true;
        }
      });
      disturb(now);
      speak(now);
      carry(now, now + lead_ns_);
      in_.buses.flush();  // replies first, mechanics after
      if (heard) {
        heard_ns_ = now;
        ahead_due_ns_ = now + in_.robot.period_ns / 3;
      } else if (now >= ahead_due_ns_) {
        advance(std::min(heard_ns_ + in_.robot.period_ns, end));
        ahead_due_ns_ = kNever;
      } else {
        advance(std::min(now, end));
      }
      if (now >= end) return;
      wait_until(std::min({next_due() - lead_ns_, now + nap_ns_, ahead_due_ns_, end}));
    }
  }

 private:
  void disturb(std::int64_t now) {
    const std::int64_t frames =
        std::clamp<std::int64_t>((now - flooded_ns_) / kFloodFrameNs, 0, kMostFlood);
    flooded_ns_ = frames > 0 ? now : flooded_ns_;
    for (std::size_t bus = 0; bus < in_.buses.size(); ++bus) {
      in_.buses.hold(bus, in_.plant.held(bus));
      if (in_.plant.babbling(bus)) in_.buses.flood(bus, static_cast<std::size_t>(frames));
    }
  }

  void catch_up(std::int64_t now) {
    const std::int64_t behind = now - in_.plant.now_ns();
    if (behind < kGiveUpNs) return;
    in_.report.slipped_s += static_cast<double>(behind) * 1e-9;
    in_.plant.skip(now);
  }

  // Mechanics never compete with the host for a processor, whatever the answers do.
  void advance(std::int64_t to) {
    const int priority = in_.settings.priority;
    const bool lower = in_.report.realtime && priority > kMechanicsPriority &&
                       to - in_.plant.now_ns() >= in_.plant.step_ns();
    const auto set = [](int value) {
      const sched_param parameter{value};
      sched_setscheduler(0, SCHED_FIFO, &parameter);
    };
    if (lower) set(kMechanicsPriority);
    in_.plant.advance(to);
    if (lower) set(priority);
  }

  // A host wakes late by some tens of microseconds, each time about as much. Waking earlier by that
  // keeps the replies on time on the whole; none is early by more than kMostLeadNs.
  void wait_until(std::int64_t due) {
    in_.buses.wait(due, in_.waiting_mask);
    const std::int64_t late = rt::now_ns() - due;
    if (late < 0) return;  // a frame woke us
    lead_ns_ += (std::min(late, kMostLeadNs) - lead_ns_) / 16;
  }

  // All that has left the wires by `until`, in order of time.
  void carry(std::int64_t now, std::int64_t until) {
    for (;;) {
      std::size_t first = wires_.size();
      std::int64_t earliest = until;
      for (std::size_t bus = 0; bus < wires_.size(); ++bus) {
        const auto end = wires_[bus].next_end_ns();
        if (!end || *end > earliest) continue;
        earliest = *end;
        first = bus;
      }
      if (first == wires_.size()) return;
      const auto delivery = wires_[first].pop(until);
      if (!delivery) return;
      if (delivery->reply) {
        in_.buses.queue(first, delivery->frame);
        const double late = static_cast<double>(now - delivery->end_ns) * 1e-9;
        in_.report.late_max_s = std::max(in_.report.late_max_s, late);
      } else {
        in_.plant.advance(delivery->end_ns);
        hear(first, delivery->frame, delivery->end_ns);
      }
    }
  }

  void hear(std::size_t bus, const drivers::Frame& frame, std::int64_t now) {
    answers_.clear();
    in_.plant.hear(bus, frame, now, answers_);
    send(bus, now);
  }

  void speak(std::int64_t now) {
    for (std::size_t bus = 0; bus < in_.buses.size(); ++bus) {
      answers_.clear();
      in_.plant.speak(bus, now, answers_);
      send(bus, now);
    }
  }

  void send(std::size_t bus, std::int64_t now) {
    for (const Plant::Answer& answer : answers_) {
      if (in_.settings.wire) {
        wires_[bus].push_reply(answer.frame, now + latency_ns_);
      } else {
        in_.buses.queue(bus, answer.frame);
      }
    }
  }

  std::int64_t next_due() const {
    std::int64_t next = kNever;
    for (const WireModel& wire : wires_) next = std::min(next, wire.next_end_ns().value_or(next));
    return next;
  }

  const LoopContext& in_;
  // Without a wire the reply is due at once: nothing but the drives may stand between the command
  // and it. So once the cycle's commands have been answered and act, the mechanics of the period
  // they act in are computed ahead, while nobody waits.
  std::int64_t heard_ns_ = 0;
  std::int64_t ahead_due_ns_ = kNever;
  std::int64_t nap_ns_;  // mechanics in arrears would make the first answer late
  std::int64_t latency_ns_;
  std::int64_t lead_ns_ = 0;
  std::int64_t flooded_ns_ = 0;
  std::vector<WireModel> wires_;
  std::vector<Plant::Answer> answers_;
};

}  // namespace

void run_in_real_time(const LoopContext& context) {
  RealTime(context).run();
}

}  // namespace geodesic::tools
