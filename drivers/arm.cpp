// All joints on all buses: who is sent to, who has answered, and joint units to drive units. What
// may be configured is checked in arm_options.cpp.
#include "drivers/arm.hpp"

#include <poll.h>

#include <algorithm>
#include <ctime>
#include <span>
#include <stdexcept>
#include <string>
#include <utility>

#include "drivers/arm_parts.hpp"
#include "drivers/cycle_plan.hpp"
#include "drivers/families.hpp"
#include "drivers/lockstep_tick.hpp"
#include "rt/clock.hpp"

namespace geodesic::drivers {

using namespace arm;  // NOLINT(google-build-using-namespace): its own parts

namespace {

constexpr std::size_t kBatch = 64;
constexpr int kMaxBatches = 16;    ///< read from one bus at one wake-up
constexpr int kMaxWakeUps = 4096;  ///< of one cycle
constexpr std::int64_t kSimulatedPatienceNs = rt::kNanosecondsPerSecond;
constexpr int kSimulatedWaits = 8;  ///< in a row for one joint, each up to that long
/// Arrival stamps come from another clock than now_ns(); a reply that seems to precede its command
/// by no more than this belongs to it.
constexpr std::int64_t kStampToleranceNs = 50'000;
/// A drive answers each frame once. In quarters of a frame: what is received beyond what was sent,
/// less one a cycle, may reach this (a link that doubles one frame in four never does, a second
/// drive with the same identifiers does within kSurplusLimit * 2 / 3 cycles)...
constexpr int kSurplusLimit = 64;
/// ...and what was lost before hides no more than this.
constexpr int kSurplusFloor = -64;
constexpr DriveComplaint kDoubled{
    "answers to one command", 2.0, 1.0,
    "a second drive answers with this one's identifiers: give each its own, then ask for a law"};

}  // namespace

struct Arm::Impl {
  Impl(const ArmOptions& options, std::vector<std::unique_ptr<Bus>> buses);

  void read_replies(std::int64_t tick_ns, std::int64_t deadline_ns) noexcept;
  bool wait(std::int64_t deadline_ns) noexcept;
  void drain(Line& line, std::int64_t tick_ns) noexcept;
  void take(Line& line, ReceivedFrame& received, std::int64_t tick_ns) noexcept;
  void take_in(Line& line, std::size_t index, ReceivedFrame& received,
               std::int64_t tick_ns) noexcept;

  bool simulated_time;
  std::vector<std::size_t> order;  ///< in which the joints are sent to
  std::vector<Joint> joints;
  std::vector<Line> lines;
  std::array<pollfd, control::kMaxBuses> waits{};
  std::array<ReceivedFrame, kBatch> batch{};
  bool prepared = false;  ///< what the next transmit() sends is encoded
  std::int64_t last_tick_ns = 0;
  std::int64_t last_read_ns = 0;
  control::ArmState state;
};

Arm::Impl::Impl(const ArmOptions& options, std::vector<std::unique_ptr<Bus>> buses)
    : simulated_time(options.simulated_time), order(sending_order(options)) {
  if (buses.size() != options.buses.size()) {
    throw std::invalid_argument("the arm was given " + std::to_string(buses.size()) +
                                " open buses; its options name " +
                                std::to_string(options.buses.size()));
  }
  for (std::unique_ptr<Bus>& bus : buses) {
    Line& line = lines.emplace_back();
    line.bus = std::move(bus);
    line.frames.resize(1);  // the tick of simulated time
  }
  for (const JointOptions& joint : options.joints) {
    Line& line = lines[joint.bus];
    const Family& family = *find_family(joint.drive.family);
    DriveOptions drive = joint.drive;
    drive.leader = is_leader(options, order, joints.size());
    const Joint& added =
        joints.emplace_back(family.make_drive(drive), joint, family.position_period_rad(drive));
    for (const IdFilter& reply : added.drive->reply_ids()) {
      line.routes.add(reply, joints.size() - 1);
    }
    line.frames.resize(line.frames.size() + Drive::kMaxFramesPerCycle);
    line.owners.resize(line.frames.size());
  }
  state.joints = joints.size();
  state.buses = lines.size();
}

void Arm::Impl::read_replies(std::int64_t tick_ns, std::int64_t deadline_ns) noexcept {
  for (int wake_up = 0; wake_up < kMaxWakeUps && wait(deadline_ns); ++wake_up) {
    for (Line& line : lines) {
      if (line.events == 0) {
        continue;
      }
      drain(line, tick_ns);
      // Closed, or down and in error: it would wake us at once for the rest of the cycle.
      line.gone = (line.events & (POLLHUP | POLLNVAL)) != 0 ||
                  ((line.events & POLLERR) != 0 && line.bus->state().down);
    }
  }
  for (Line& line : lines) {
    if (!line.read) {
      drain(line, tick_ns);  // error frames, late replies, foreign commanders
    }
  }
}

bool Arm::Impl::wait(std::int64_t deadline_ns) noexcept {
  std::array<Line*, control::kMaxBuses> waiting{};
  std::size_t count = 0;
  for (Line& line : lines) {
    line.events = 0;
    if (line.owed > 0 && !line.gone) {
      waits[count] = {line.bus->descriptor(), POLLIN, 0};
      waiting[count++] = &line;
    }
  }
  if (count == 0) {
    return false;
  }
  const std::int64_t left_ns = deadline_ns - rt::now_ns();
  if (left_ns <= 0) {
    return false;
  }
  timespec left{};
  left.tv_sec = static_cast<decltype(left.tv_sec)>(left_ns / rt::kNanosecondsPerSecond);
  left.tv_nsec = static_cast<decltype(left.tv_nsec)>(left_ns % rt::kNanosecondsPerSecond);
  if (ppoll(waits.data(), count, &left, nullptr) > 0) {
    for (std::size_t i = 0; i < count; ++i) {
      waiting[i]->events = waits[i].revents;
    }
  }
  return true;  // a signal or the deadline woke us: the clock decides the next time
}

void Arm::Impl::drain(Line& line, std::int64_t tick_ns) noexcept {
  line.read = true;
  for (int round = 0; round < kMaxBatches; ++round) {
    const std::size_t count = std::min(line.bus->receive(batch), batch.size());
    last_read_ns = count > 0 && !simulated_time ? rt::now_ns() : last_read_ns;
    for (std::size_t i = 0; i < count; ++i) {
      take(line, batch[i], tick_ns);
    }
    if (count < batch.size()) {
      return;
    }
  }
}

void Arm::Impl::take(Line& line, ReceivedFrame& received, std::int64_t tick_ns) noexcept {
  if (received.frame.error) {
    return;
  }
  if (simulated_time && is_tick(received.frame)) {
    line.owed = 0;
    line.missing = 0;
    return;
  }
  line.routes.find(received.frame, [&](std::size_t joint) {
    if (!joints[joint].drive->claims(received.frame)) {
      return false;
    }
    take_in(line, joint, received, tick_ns);
    return true;
  });
}

void Arm::Impl::take_in(Line& line, std::size_t index, ReceivedFrame& received,
                        std::int64_t tick_ns) noexcept {
  Joint& joint = joints[index];
  control::JointState& out = state.joint[index];
  // What was on its way before this cycle's command left cannot be its answer.
  const bool timely = received.stamp_ns >= line.sent_ns - kStampToleranceNs;
  if (simulated_time) {
    received.stamp_ns = timely ? tick_ns : last_tick_ns;
  }
  ++joint.counters.received;
  joint.surplus += joint.drive->speaks_unasked() ? 0 : 4;
  const bool report = joint.drive->receive(received);
  if (report) {
    if (joint.turn == Turn::kUnknown) {
      find_turn(joint.drive->state().position_rad * joint.scale + joint.offset, received.stamp_ns,
                out, joint);
    }
    to_joint(joint.drive->state(), joint, out);
    joint.last_good = received.frame;
    out.fresh = true;  // late for its cycle, but newer than what was known
  }
  if (timely && joint.due > 0 && !joint.answered) {
    ++joint.heard;
    joint.answered = report || joint.heard >= joint.due;
    line.owed -= joint.answered && !simulated_time ? 1 : 0;
  }
}

Arm::Arm(const ArmOptions& options) {
  std::vector<std::unique_ptr<Bus>> buses;
  for (const BusOptions& bus : filtered_buses(options)) {
    buses.push_back(open_bus(bus));
  }
  impl_ = std::make_unique<Impl>(options, std::move(buses));
}

Arm::Arm(const ArmOptions& options, std::vector<std::unique_ptr<Bus>> buses) {
  filtered_buses(options);  // for its checks
  impl_ = std::make_unique<Impl>(options, std::move(buses));
}

Arm::~Arm() = default;

void Arm::prepare(const control::ArmCommand& command, std::int64_t tick_ns) noexcept {
  static constexpr control::JointCommand kMonitor;
  for (Line& line : impl_->lines) {
    line.filled = 0;
  }
  for (const std::size_t i : impl_->order) {
    Joint& joint = impl_->joints[i];
    Line& line = impl_->lines[joint.line];
    const std::span<Frame> room =
        std::span(line.frames).subspan(line.filled, Drive::kMaxFramesPerCycle);
    const DriveCommand wanted = to_drive(i < command.joints ? command.joint[i] : kMonitor, joint);
    const std::size_t added = std::min(joint.drive->transmit(wanted, tick_ns, room), room.size());
    std::fill_n(line.owners.begin() + static_cast<std::ptrdiff_t>(line.filled), added, i);
    line.filled += added;
  }
  impl_->prepared = true;
}

void Arm::transmit(const control::ArmCommand& command, std::int64_t tick_ns) noexcept {
  if (!impl_->prepared) {
    prepare(command, tick_ns);
  }
  impl_->prepared = false;
  for (Joint& joint : impl_->joints) {
    joint.sent = 0;
    joint.due = 0;
    joint.heard = 0;
    joint.answered = false;
  }
  for (Line& line : impl_->lines) {
    line.sent_ns = rt::now_ns();
    line.owed = 0;
    std::size_t offered = line.filled;
    if (impl_->simulated_time) {
      line.frames[offered++] = tick_frame();
    }
    const std::span<const Frame> frames = std::span(line.frames).first(offered);
    const std::size_t sent = frames.empty() ? 0 : line.bus->send(frames);
    // A joint whose frames stayed here owes no reply.
    for (std::size_t i = 0; i < std::min(sent, line.filled); ++i) {
      Joint& joint = impl_->joints[line.owners[i]];
      ++joint.sent;
      ++joint.counters.sent;
    }
    // What has not ticked for long is waited for no more.
    line.owed = sent > line.filled && line.missing < kSimulatedWaits ? 1 : 0;
  }
  for (Joint& joint : impl_->joints) {
    joint.due = joint.sent > 0 ? joint.drive->answers_due(joint.sent) : 0;
    joint.surplus -= 4 * static_cast<int>(joint.due);
    impl_->lines[joint.line].owed += joint.due > 0 && !impl_->simulated_time ? 1 : 0;
  }
}

const control::ArmState& Arm::receive(std::int64_t tick_ns, std::int64_t deadline_ns) noexcept {
  Impl& arm = *impl_;
  control::ArmState& state = arm.state;
  state.tick_ns = tick_ns;
  for (std::size_t i = 0; i < arm.joints.size(); ++i) {
    state.joint[i].fresh = false;
  }
  for (Line& line : arm.lines) {
    line.read = false;
    line.gone = false;
  }
  arm.read_replies(tick_ns, arm.simulated_time ? rt::now_ns() + kSimulatedPatienceNs : deadline_ns);
  for (std::size_t i = 0; i < arm.joints.size(); ++i) {
    Joint& joint = arm.joints[i];
    const bool lost = joint.due > 0 && !joint.answered;
    joint.counters.lost += lost ? 1 : 0;
    joint.sent = 0;
    joint.due = 0;
    joint.surplus = std::max(joint.surplus - 1, kSurplusFloor);
    joint.doubled = joint.doubled || joint.surplus >= kSurplusLimit;
    const DriveState& drive = joint.drive->state();
    if (drive.condition == control::DriveCondition::kUnknown ||
        drive.condition == control::DriveCondition::kConfiguring) {
      joint.turn = Turn::kUnknown;  // it may have been off
    }
    const bool refused = joint.doubled || joint.turn == Turn::kRefused;
    state.joint[i].condition = refused ? control::DriveCondition::kRefused : drive.condition;
    state.joint[i].drive_error = drive.error;
  }
  for (std::size_t i = 0; i < arm.lines.size(); ++i) {
    arm.lines[i].missing += arm.simulated_time && arm.lines[i].owed > 0 ? 1 : 0;
    arm.lines[i].owed = 0;
    state.bus[i] = arm.lines[i].bus->state();
  }
  arm.last_tick_ns = tick_ns;
  return state;
}

void Arm::restart(control::BitSet joints) noexcept {
  for (std::size_t i = 0; i < impl_->joints.size(); ++i) {
    if (!control::has(joints, i)) {
      continue;
    }
    Joint& joint = impl_->joints[i];
    joint.drive->restart();
    joint.turn = Turn::kUnknown;
    joint.surplus = 0;
    joint.doubled = false;
    impl_->lines[joint.line].bus->ask_restart();
  }
}

void Arm::tend() noexcept {
  for (Line& line : impl_->lines) {
    line.bus->tend();
  }
}

LinkHealth Arm::bus_health(std::size_t bus) const {
  return impl_->lines[bus].bus->health();
}

std::vector<BusNews> Arm::take_bus_news(std::size_t bus) {
  return impl_->lines[bus].bus->take_news();
}

std::vector<int> Arm::descriptors() const {
  std::vector<int> all;
  for (const Line& line : impl_->lines) {
    all.push_back(line.bus->descriptor());
  }
  return all;
}

std::int64_t Arm::last_read_ns() const noexcept {
  return impl_->last_read_ns;
}

std::size_t Arm::joints() const noexcept {
  return impl_->joints.size();
}

std::size_t Arm::buses() const noexcept {
  return impl_->lines.size();
}

const JointCounters& Arm::joint_counters(std::size_t joint) const noexcept {
  return impl_->joints[joint].counters;
}

const BusCounters& Arm::bus_counters(std::size_t bus) const noexcept {
  return impl_->lines[bus].bus->counters();
}

const Frame& Arm::last_good_frame(std::size_t joint) const noexcept {
  return impl_->joints[joint].last_good;
}

const DriveComplaint& Arm::complaint(std::size_t joint) const noexcept {
  const Joint& one = impl_->joints[joint];
  if (one.turn == Turn::kRefused) {
    return one.lost;
  }
  return one.doubled ? kDoubled : one.drive->complaint();
}

}  // namespace geodesic::drivers
