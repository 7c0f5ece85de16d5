// The simulated arm locked to the commands: time passes by one period for each complete set, which
// a host in simulated time ends with its tick, and any other by commanding every drive.
#include <algorithm>
#include <cmath>
#include <vector>

#include "drivers/lockstep_tick.hpp"
#include "rt/clock.hpp"
#include "tools/sim/loops.hpp"

namespace geodesic::tools {
namespace {

class Lockstep {
 public:
  explicit Lockstep(const LoopContext& context)
      : in_(context),
        addressed_(context.plant.joints(), false),
        ticked_(context.buses.size(), false) {}

  void run() {
    const double seconds = in_.settings.seconds;
    while (!in_.stop.load()) {
      if (seconds > 0.0 && in_.plant.elapsed_s() >= seconds - 1e-9) return;
      if (complete()) {
        read();  // frames that belong to the same sending and have come meanwhile
        step();
        continue;
      }
      // A clock is read only while a set is incomplete: it may be a slow call.
      const std::int64_t left = addressed_any_ ? since_ns_ + kPatienceNs - rt::now_ns() : kNapNs;
      if (left < 0) {
        ++in_.report.incomplete_sets;
        step();
        continue;
      }
      in_.buses.wait_for(left + 1, in_.waiting_mask);
      read();
    }
  }

 private:
  static constexpr std::int64_t kPatienceNs = static_cast<std::int64_t>(kPatience * 1e9);
  static constexpr std::int64_t kNapNs = 100'000'000;

  struct Pending {
    std::size_t bus = 0;
    drivers::Frame frame;
  };

  void read() {
    in_.buses.read([&](std::size_t bus, const drivers::Frame& frame, std::int64_t /*stamp*/) {
      if (drivers::is_tick(frame)) {
        ticking_ = true;
        ticked_[bus] = true;
        begin_set();
        return;
      }
      pending_.push_back({bus, frame});
      const auto joint = in_.plant.addressee(bus, frame);
      if (!joint) return;
      addressed_[*joint] = true;
      if (!in_.plant.silent(*joint)) begin_set();
    });
  }

  void begin_set() {
    if (addressed_any_) return;
    addressed_any_ = true;
    since_ns_ = rt::now_ns();
  }

  bool complete() const {
    if (ticking_) {
      return std::all_of(ticked_.begin(), ticked_.end(), [](bool ticked) { return ticked; });
    }
    if (pending_.empty()) return false;
    bool somebody = false;
    for (std::size_t i = 0; i < addressed_.size(); ++i) {
      if (addressed_[i]) somebody = true;
      if (!addressed_[i] && !in_.plant.silent(i)) return false;
    }
    return somebody;
  }

  void step() {
    ++in_.report.sets;
    in_.plant.advance(in_.plant.now_ns() + in_.robot.period_ns);
    for (const Pending& pending : pending_) {
      answers_.clear();
      in_.plant.hear(pending.bus, pending.frame, in_.plant.now_ns(), answers_);
      for (const Plant::Answer& answer : answers_) in_.buses.queue(pending.bus, answer.frame);
    }
    for (std::size_t bus = 0; bus < in_.buses.size(); ++bus) {
      answers_.clear();
      in_.plant.speak(bus, in_.plant.now_ns(), answers_);
      for (const Plant::Answer& answer : answers_) in_.buses.queue(bus, answer.frame);
    }
    const auto flood = static_cast<std::size_t>(in_.robot.period_ns / kFloodFrameNs);
    for (std::size_t bus = 0; bus < in_.buses.size(); ++bus) {
      if (in_.plant.babbling(bus)) in_.buses.flood(bus, flood);
    }
    if (ticking_) {
      for (std::size_t bus = 0; bus < in_.buses.size(); ++bus) {
        in_.buses.queue(bus, drivers::tick_frame());
      }
    }
    in_.buses.flush();
    ticked_.assign(ticked_.size(), false);
    pending_.clear();
    addressed_.assign(addressed_.size(), false);
    addressed_any_ = false;
  }

  const LoopContext& in_;
  std::vector<Pending> pending_;
  std::vector<bool> addressed_;
  std::vector<bool> ticked_;    // buses on which the host has ended its cycle
  bool ticking_ = false;        // it does end them so
  bool addressed_any_ = false;  // a drive that answers, or a tick, is in the set
  std::int64_t since_ns_ = 0;   // real time of its first frame
  std::vector<Plant::Answer> answers_;
};

}  // namespace

void run_in_lockstep(const LoopContext& context) {
  Lockstep(context).run();
}

}  // namespace geodesic::tools
