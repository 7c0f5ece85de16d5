// Builds an arm of n joints with its drives, brings it up, and times the phases of its cycle.
#include "tests/bench/cycle.hpp"

#include <fmt/format.h>
#include <malloc.h>

#include <algorithm>
#include <array>
#include <stdexcept>

#include "control/controller.hpp"
#include "drivers/arm.hpp"
#include "drivers/families.hpp"
#include "rt/clock.hpp"
#include "tests/bench/memory_bus.hpp"
#include "tests/bench/robots.hpp"
#include "tools/geodesicd/telemetry.hpp"

namespace geodesic::bench {
namespace {

constexpr std::int64_t kPeriodNs = 1'000'000;
constexpr int kDrivesPerBus = 8;
constexpr int kStartCycles = 20'000;
constexpr int kSettleCycles = 1'500;  // the ramp of authority is over
constexpr std::array<const char*, 7> kPhases{"transmit", "receive", "update", "encode",
                                             "observe",  "publish", "sum"};

control::ControllerOptions tuning(int joints) {
  control::ControllerOptions options;
  for (int i = 1; i <= joints; ++i) {
    control::JointTuning joint;
    joint.name = fmt::format("joint{:02}", i);
    joint.damping = 0.1;
    joint.drive_damping = 1.0;
    joint.coulomb_friction = 0.2;
    joint.viscous_friction = 0.1;
    joint.position_lower = -3.0;
    joint.position_upper = 3.0;
    joint.wall_stiffness = 100.0;
    joint.wall_damping = 1.0;
    joint.velocity_limit = 10.0;
    joint.torque_limit = 50.0;
    joint.torque_rate_limit = 2000.0;
    options.joints.push_back(joint);
  }
  return options;
}

drivers::ArmOptions wiring(int joints) {
  drivers::ArmOptions options;
  options.simulated_time = true;
  for (int i = 0; i < joints; ++i) {
    const int bus = i / kDrivesPerBus;
    if (i % kDrivesPerBus == 0) {
      drivers::BusOptions line;
      line.name = fmt::format("bus{}", bus);
      line.interface = fmt::format("unix:/memory/{}", bus);
      line.fd = true;
      options.buses.push_back(line);
    }
    drivers::JointOptions joint;
    joint.name = fmt::format("joint{:02}", i + 1);
    joint.bus = static_cast<std::size_t>(bus);
    joint.drive.family = "damiao";
    joint.drive.id = static_cast<std::uint32_t>(i % kDrivesPerBus + 1);
    joint.drive.reply_id = joint.drive.id + 16;
    joint.drive.fd = true;
    joint.drive.position_range_rad = 12.5;
    joint.drive.velocity_range_rad_s = 10.0;
    joint.drive.torque_range_nm = 54.0;
    options.joints.push_back(joint);
  }
  return options;
}

std::int64_t heap_bytes() {
  return static_cast<std::int64_t>(::mallinfo2().uordblks);
}

/// An arm with everything that one cycle touches.
class Rig {
 public:
  explicit Rig(int joints)
      : before_(heap_bytes()),
        options_(wiring(joints)),
        arm_(options_, make_buses()),
        controller_({chain(joints), Eigen::Vector3d(0.0, 0.0, -9.81)}, tuning(joints)),
        telemetry_(std::make_unique<tools::Telemetry>(arm_, kPeriodNs)),
        object_bytes_(heap_bytes() - before_) {
    command_.joints = arm_.joints();
  }

  using Durations = std::array<std::int64_t, kPhases.size()>;

  Durations cycle() {
    tick_ns_ += kPeriodNs;
    const std::int64_t begin = rt::now_ns();
    arm_.transmit(command_, tick_ns_);
    const std::int64_t transmitted = rt::now_ns();
    for (MemoryBus* bus : buses_) {
      bus->answer(tick_ns_);
    }
    const std::int64_t answered = rt::now_ns();
    state_ = arm_.receive(tick_ns_, tick_ns_ + kPeriodNs);
    const std::int64_t received = rt::now_ns();
    command_ = controller_.update(state_, kPeriodNs);
    const std::int64_t updated = rt::now_ns();
    arm_.prepare(command_, tick_ns_ + kPeriodNs);
    const std::int64_t encoded = rt::now_ns();
    controller_.observe();
    const std::int64_t observed = rt::now_ns();
    telemetry_->push(++index_, state_, command_, controller_.report());
    const std::int64_t published = rt::now_ns();
    tools::Record record;
    while (telemetry_->pop(record)) {
    }
    return {transmitted - begin,
            received - answered,
            updated - received,
            encoded - updated,
            observed - encoded,
            published - observed,
            transmitted - begin + published - answered};
  }

  void bring_up() {
    for (int i = 0; i < kStartCycles && controller_.report().state != kActive; ++i) {
      cycle();
    }
    for (int i = 0; i < kSettleCycles; ++i) {
      cycle();
    }
    if (controller_.report().state != kActive) {
      throw std::runtime_error(
          fmt::format("an arm of {} joints did not become active but {}", arm_.joints(), state()));
    }
  }

  const char* state() const { return control::to_string(controller_.report().state); }
  std::size_t buses() const { return buses_.size(); }
  std::int64_t object_bytes() const { return object_bytes_; }

 private:
  static constexpr auto kActive = control::SupervisorState::kActive;

  std::vector<std::unique_ptr<drivers::Bus>> make_buses() {
    std::vector<std::unique_ptr<drivers::Bus>> made;
    for (std::size_t i = 0; i < options_.buses.size(); ++i) {
      auto bus = std::make_unique<MemoryBus>();
      buses_.push_back(bus.get());
      made.push_back(std::move(bus));
    }
    for (const drivers::JointOptions& joint : options_.joints) {
      auto drive = drivers::find_family(joint.drive.family)->make_simulated(joint.drive);
      drive->set_shaft(0.02, 0.0);
      buses_[joint.bus]->add(std::move(drive));
    }
    return made;
  }

  std::int64_t before_;
  drivers::ArmOptions options_;
  std::vector<MemoryBus*> buses_;
  drivers::Arm arm_;
  control::Controller controller_;
  std::unique_ptr<tools::Telemetry> telemetry_;
  std::int64_t object_bytes_;
  control::ArmState state_;
  control::ArmCommand command_;
  std::int64_t tick_ns_ = kPeriodNs;
  std::int64_t index_ = 0;
};

Phase distribution(const char* name, std::vector<std::int64_t>& samples) {
  std::sort(samples.begin(), samples.end());
  const std::size_t n = samples.size();
  return {name, static_cast<double>(samples.front()), static_cast<double>(samples[n / 2]),
          static_cast<double>(samples[n * 99 / 100])};
}

CycleFigures measure(int joints, long cycles) {
  const auto rig = std::make_unique<Rig>(joints);
  rig->bring_up();
  std::array<std::vector<std::int64_t>, kPhases.size()> samples;
  for (auto& phase : samples) {
    phase.reserve(static_cast<std::size_t>(cycles));
  }
  const std::int64_t before = heap_bytes();
  for (long i = 0; i < cycles; ++i) {
    const Rig::Durations durations = rig->cycle();
    for (std::size_t phase = 0; phase < kPhases.size(); ++phase) {
      samples[phase].push_back(durations[phase]);
    }
  }
  CycleFigures figures;
  figures.heap_bytes_grown = heap_bytes() - before;
  figures.joints = joints;
  figures.buses = static_cast<int>(rig->buses());
  figures.cycles = cycles;
  figures.state = rig->state();
  figures.object_bytes = rig->object_bytes();
  for (std::size_t phase = 0; phase < kPhases.size(); ++phase) {
    figures.phases.push_back(distribution(kPhases[phase], samples[phase]));
  }
  return figures;
}

}  // namespace

std::vector<CycleFigures> measure_cycle(const CycleOptions& options) {
  std::vector<CycleFigures> all;
  for (const int joints : options.joints) {
    all.push_back(measure(joints, options.cycles));
  }
  return all;
}

}  // namespace geodesic::bench
