// Round trips to a drive, for the doctor; see doctor_looks.hpp.
#include <fmt/format.h>
#include <poll.h>

#include <algorithm>
#include <array>
#include <memory>
#include <numeric>

#include "drivers/families.hpp"
#include "rt/clock.hpp"
#include "tools/geodesic/doctor_looks.hpp"
#include "tools/geodesic/jog_session.hpp"

namespace geodesic::tools {
namespace {

constexpr std::int64_t kConnectNs = 2'000'000'000;
constexpr std::int64_t kLeastPauseNs = 2'000'000;  ///< between two questions
constexpr std::int64_t kPatienceNs = 20'000'000;   ///< for an answer
constexpr std::int64_t kReportsNs = 500'000'000;   ///< of a drive that speaks by its own timer

/// A drive alone on its bus, asked for its state and nothing else.
class Questioner {
 public:
  explicit Questioner(const drivers::ArmOptions& arm, std::size_t joint)
      : options_(arm.joints[joint].drive) {
    options_.leader = true;
    drivers::ArmOptions alone;
    alone.buses.push_back(arm.buses[arm.joints[joint].bus]);
    alone.joints.push_back(arm.joints[joint]);
    alone.joints.front().bus = 0;
    bus_ = drivers::open_bus(drivers::filtered_buses(alone).front());
    drive_ = drivers::find_family(options_.family)->make_drive(options_);
  }

  drivers::Drive& drive() { return *drive_; }

  /// One question. @return time to the first report [ns], nothing if none came in time.
  std::optional<std::int64_t> ask() {
    std::array<drivers::Frame, drivers::Drive::kMaxFramesPerCycle> out;
    const std::int64_t sent_ns = rt::now_ns();
    const std::size_t count =
        drive_->transmit({.mode = control::DriveMode::kMonitor}, sent_ns, out);
    const std::size_t sent = count == 0 ? 0 : bus_->send(std::span(out).first(count));
    const bool due = sent > 0 && drive_->answers_due(sent) > 0;
    const std::optional<std::int64_t> stamp = listen(sent_ns, due ? kPatienceNs : kLeastPauseNs);
    if (!stamp || !due) return std::nullopt;
    return std::max<std::int64_t>(*stamp - sent_ns, 0);
  }

  /// Waits for a frame of the drive. @return its stamp.
  std::optional<std::int64_t> listen(std::int64_t begin_ns, std::int64_t patience_ns) {
    while (true) {
      const std::int64_t left_ns = begin_ns + patience_ns - rt::now_ns();
      if (left_ns <= 0) return std::nullopt;
      pollfd wait{bus_->descriptor(), POLLIN, 0};
      const timespec left{0, left_ns};
      if (::ppoll(&wait, 1, &left, nullptr) <= 0) continue;
      if ((wait.revents & (POLLHUP | POLLERR)) != 0) return std::nullopt;
      const std::size_t count = std::min(bus_->receive(batch_), batch_.size());
      std::optional<std::int64_t> stamp;
      for (std::size_t i = 0; i < count; ++i) {
        if (batch_[i].frame.error || !drive_->claims(batch_[i].frame)) continue;
        drive_->receive(batch_[i]);
        stamp = stamp ? stamp : batch_[i].stamp_ns;
      }
      if (stamp) return stamp;
    }
  }

 private:
  drivers::DriveOptions options_;
  std::unique_ptr<drivers::Bus> bus_;
  std::unique_ptr<drivers::Drive> drive_;
  std::array<drivers::ReceivedFrame, 64> batch_;
};

double micro(std::int64_t ns) {
  return static_cast<double>(ns) * 1e-3;
}

void pause_until(std::int64_t due_ns) {
  rt::sleep_until_ns(due_ns);
}

void judge(std::vector<std::int64_t> times_ns, int asked, std::int64_t period_ns,
           const std::string& interface, Area& area) {
  if (times_ns.empty()) {
    area.bad("round trip", fmt::format("none of {} questions was answered", asked),
             fmt::format("geodesic scan {}", interface));
    return;
  }
  std::sort(times_ns.begin(), times_ns.end());
  const std::int64_t median = times_ns[times_ns.size() / 2];
  const int lost = asked - static_cast<int>(times_ns.size());
  const std::string text =
      fmt::format("min {:.0f}, median {:.0f}, max {:.0f} us over {} questions, {} not answered",
                  micro(times_ns.front()), micro(median), micro(times_ns.back()), asked, lost);
  if (median > period_ns) {
    area.bad("round trip",
             fmt::format("{}: slower than the cycle of {:.0f} us", text, micro(period_ns)),
             "geodesic check ROBOT.toml   # what rate the bus carries; lower [robot] rate_hz");
  } else if (lost > 0 || times_ns.back() > period_ns) {
    area.warn("round trip", fmt::format("{}; a cycle has {:.0f} us", text, micro(period_ns)),
              fmt::format("ip -details -statistics link show {}   # wiring, load; then the "
                          "interrupt's thread above",
                          interface));
  } else {
    area.ok("round trip", text);
  }
}

}  // namespace

void look_at_drive(const drivers::ArmOptions& arm, std::size_t joint, std::int64_t period_ns,
                   int exchanges, const std::function<bool()>& stopped, Findings& findings) {
  const drivers::JointOptions& options = arm.joints[joint];
  const std::string& interface = arm.buses[options.bus].interface;
  Area area("joint " + options.name, findings);
  try {
    Questioner questioner(arm, joint);
    const drivers::Drive& drive = questioner.drive();
    const std::int64_t pause_ns = std::max(period_ns, kLeastPauseNs);
    std::int64_t next_ns = rt::now_ns();
    const std::int64_t end_ns = next_ns + kConnectNs;
    while (drive.state().condition != control::DriveCondition::kDisabled &&
           drive.state().condition != control::DriveCondition::kRefused && next_ns < end_ns &&
           !stopped()) {
      questioner.ask();
      pause_until(next_ns = std::max(next_ns + pause_ns, rt::now_ns()));
    }
    control::JointState state;
    state.condition = drive.state().condition;
    state.drive_error = drive.state().error;
    const std::string trouble = trouble_of(state, drive.complaint(), options);
    if (stopped()) return;
    if (!trouble.empty()) {
      area.bad("drive", trouble, fmt::format("geodesic scan {}", interface));
      return;
    }
    area.ok("drive", fmt::format("0x{:X} ({}) is as the robot file says", options.drive.id,
                                 options.drive.family));
    if (drive.speaks_unasked()) {
      const std::int64_t begin_ns = rt::now_ns();
      int reports = 0;
      while (rt::now_ns() < begin_ns + kReportsNs && !stopped()) {
        reports += questioner.listen(rt::now_ns(), kPatienceNs) ? 1 : 0;
      }
      const double hz = static_cast<double>(reports) * 1e9 /
                        static_cast<double>(std::max<std::int64_t>(rt::now_ns() - begin_ns, 1));
      area.ok("reports", fmt::format("by its own timer, {:.0f} frames a second", hz));
      return;
    }
    std::vector<std::int64_t> times_ns;
    int asked = 0;
    for (; asked < exchanges && !stopped(); ++asked) {
      if (const auto time_ns = questioner.ask()) times_ns.push_back(*time_ns);
      pause_until(next_ns = std::max(next_ns + pause_ns, rt::now_ns()));
    }
    if (asked > 0) judge(std::move(times_ns), asked, period_ns, interface, area);
  } catch (const drivers::BusError& error) {
    area.warn("round trip", error.what(),
              "geodesic status   # the daemon's own figures, while it commands the bus");
  }
}

}  // namespace geodesic::tools
