// The real-time thread's cycle with simulated drives in the same process: no socket, no clock, no
// thread, so every run is the same.
#include "tools/geodesicd/daemon.hpp"

#include <gtest/gtest.h>
#include <sys/eventfd.h>

#include <memory>
#include <vector>

#include "drivers/bus/descriptor.hpp"
#include "drivers/families.hpp"
#include "drivers/lockstep_tick.hpp"
#include "rt/clock.hpp"
#include "rt/thread_health.hpp"
#include "tests/tools/geodesicd_fixture.hpp"

namespace geodesic::tools {
namespace {

using control::Fault;
using control::SupervisorState;

/// A bus whose drives answer within send(); their shafts do not move.
class InstantBus final : public drivers::Bus {
 public:
  explicit InstantBus(const config::Robot& robot) : readable_(::eventfd(1, EFD_CLOEXEC)) {
    for (const drivers::JointOptions& joint : robot.arm.joints) {
      drives.push_back(drivers::find_family(joint.drive.family)->make_simulated(joint.drive));
      drives.back()->set_temperature(30.0);
    }
    silent.resize(drives.size());
    waiting_.reserve(64);
  }

  std::size_t send(std::span<const drivers::Frame> frames) noexcept override {
    waiting_.clear();
    for (const drivers::Frame& frame : frames) {
      if (drivers::is_tick(frame)) waiting_.push_back({frame, rt::now_ns()});
      for (std::size_t i = 0; i < drives.size(); ++i) {
        drivers::ReceivedFrame reply;
        const std::int64_t now_ns = rt::now_ns();
        if (drives[i]->receive(frame, now_ns, {&reply.frame, 1}) == 1 && !silent[i]) {
          reply.stamp_ns = now_ns;
          waiting_.push_back(reply);
        }
      }
    }
    return frames.size();
  }

  std::size_t receive(std::span<drivers::ReceivedFrame> out) noexcept override {
    const std::size_t count = std::min(out.size(), waiting_.size());
    std::copy_n(waiting_.begin(), count, out.begin());
    waiting_.clear();
    return count;
  }

  int descriptor() const noexcept override { return readable_.get(); }
  const control::BusState& state() const noexcept override { return state_; }
  const drivers::BusCounters& counters() const noexcept override { return counters_; }

  std::vector<std::unique_ptr<drivers::SimulatedDrive>> drives;
  std::vector<bool> silent;

 private:
  drivers::Descriptor readable_;
  std::vector<drivers::ReceivedFrame> waiting_;
  control::BusState state_;
  drivers::BusCounters counters_;
};

class DaemonTest : public testing::Test {
 protected:
  DaemonTest() {
    robot_.arm.simulated_time = true;
    auto bus = std::make_unique<InstantBus>(robot_);
    bus_ = bus.get();
    std::vector<std::unique_ptr<drivers::Bus>> buses;
    buses.push_back(std::move(bus));
    arm_ = std::make_unique<drivers::Arm>(robot_.arm, std::move(buses));
    controller_ = std::make_unique<control::Controller>(
        control::Mechanism(robot_.tree, robot_.gravity), robot_.controller);
    DaemonOptions options;
    options.period_ns = robot_.period_ns;
    options.lifetime.safety = robot_.controller.safety;
    daemon_ = std::make_unique<Daemon>(*arm_, *controller_, options);
  }

  rt::Next step(std::int64_t skipped = 0) {
    tick_.index += 1 + skipped;
    tick_.skipped = skipped;
    tick_.due_ns = tick_.woke_ns = 1'000'000'000 + tick_.index * robot_.period_ns;
    const rt::Next next = daemon_->step(tick_);
    Record record;
    while (daemon_->telemetry().pop(record)) {
      last_ = record;
    }
    Event event;
    while (daemon_->telemetry().pop(event)) {
      events_.push_back(event);
    }
    return next;
  }

  /// Steps until the state is reached, at most 20 s of ticks.
  bool reach(SupervisorState state) {
    for (int i = 0; i < 20'000 && last_.state != state; ++i) {
      step();
    }
    return last_.state == state;
  }

  /// @return cycles until the end of the run; -1: none within 20 s of ticks.
  int run_to_end() {
    for (int i = 0; i < 20'000; ++i) {
      if (step() == rt::Next::kStop) {
        return i;
      }
    }
    return -1;
  }

  std::vector<SupervisorState> states() const {
    std::vector<SupervisorState> states;
    for (const Event& event : events_) {
      if (event.kind == Event::Kind::kState) {
        states.push_back(event.to);
      }
    }
    return states;
  }

  bool any_enabled() const {
    return std::any_of(bus_->drives.begin(), bus_->drives.end(),
                       [](const auto& drive) { return drive->enabled(); });
  }

  config::Robot robot_ = small_robot();
  InstantBus* bus_ = nullptr;
  std::unique_ptr<drivers::Arm> arm_;
  std::unique_ptr<control::Controller> controller_;
  std::unique_ptr<Daemon> daemon_;
  rt::Tick tick_;
  Record last_;
  std::vector<Event> events_;
};

TEST_F(DaemonTest, FromOffToActiveAndBackToOff) {
  ASSERT_TRUE(reach(SupervisorState::kActive));
  EXPECT_TRUE(any_enabled());
  for (int i = 0; i < 1500; ++i) {
    ASSERT_EQ(step(), rt::Next::kContinue);
  }
  EXPECT_FLOAT_EQ(last_.authority, 1.0F);
  EXPECT_NEAR(last_.joint[0].command, last_.joint[0].model, 1e-5);
  EXPECT_GT(std::abs(last_.joint[0].model), 4.0F) << "the arm lies level: gravity pulls";
  EXPECT_EQ(last_.joint[0].age_us, 0);

  daemon_->lifetime().ask_exit();
  EXPECT_GE(run_to_end(), 0);
  EXPECT_EQ(last_.state, SupervisorState::kOff);
  EXPECT_FALSE(any_enabled());
  EXPECT_FALSE(daemon_->lifetime().forced());
  using enum SupervisorState;
  EXPECT_EQ(states(),
            (std::vector{kConnecting, kReady, kEnabling, kActive, kStopping, kLowering, kOff}));
  daemon_->telemetry().finish();
  const Counters& counters = daemon_->telemetry().counters();
  EXPECT_EQ(counters.joint[0].frames.lost, 0U);
  EXPECT_GT(counters.joint[0].max_command, 4.0);
  EXPECT_EQ(counters.first_tick_ns, 1'001'000'000);
}

TEST_F(DaemonTest, FollowsRequests) {
  ASSERT_TRUE(reach(SupervisorState::kActive));
  ASSERT_TRUE(daemon_->request({control::Request::Kind::kLaw, control::LawKind::kHold}));
  step();
  EXPECT_EQ(last_.law, control::LawKind::kHold);
  ASSERT_TRUE(daemon_->request({control::Request::Kind::kStop, {}}));
  ASSERT_TRUE(reach(SupervisorState::kOff));
  EXPECT_FALSE(daemon_->lifetime().ending()) << "a stop without exit: the daemon stays";
  for (int i = 0; i < 50; ++i) {
    ASSERT_EQ(step(), rt::Next::kContinue);
  }
  EXPECT_FALSE(any_enabled());
  ASSERT_TRUE(daemon_->request({control::Request::Kind::kLaw, control::LawKind::kFloat}));
  EXPECT_TRUE(reach(SupervisorState::kActive)) << "starts anew";
}

TEST_F(DaemonTest, ASilentDriveIsAFaultWithItsEvidence) {
  ASSERT_TRUE(reach(SupervisorState::kActive));
  bus_->silent[1] = true;
  ASSERT_TRUE(reach(SupervisorState::kFault));
  const auto fault = std::find_if(events_.begin(), events_.end(), [](const Event& event) {
    return event.kind == Event::Kind::kFault && event.fault.fault == Fault::kJointSilent;
  });
  ASSERT_NE(fault, events_.end());
  EXPECT_EQ(fault->fault.joint, 1);
  EXPECT_GE(fault->frame_age_ns, 4 * robot_.period_ns);
  EXPECT_LE(fault->frame_age_ns, 10 * robot_.period_ns);
  EXPECT_GT(last_.joint[1].age_us, 4000);

  daemon_->lifetime().ask_exit();
  const int cycles = run_to_end();
  EXPECT_GE(cycles, 0);
  EXPECT_LE(cycles, 210) << "the silent drive is not waited for";
  EXPECT_FALSE(bus_->drives[0]->enabled());
}

TEST_F(DaemonTest, TorqueOffAtOnceDisablesEveryDrive) {
  ASSERT_TRUE(reach(SupervisorState::kActive));
  daemon_->lifetime().ask_torque_off();
  const int cycles = run_to_end();
  EXPECT_GE(cycles, 0);
  EXPECT_LE(cycles, 10);
  EXPECT_FALSE(any_enabled());
  EXPECT_TRUE(daemon_->lifetime().forced());
}

TEST_F(DaemonTest, SkippedPeriodsReachTheSupervisor) {
  ASSERT_TRUE(reach(SupervisorState::kActive));
  for (int i = 0; i < robot_.controller.safety.overrun_cycles; ++i) {
    EXPECT_EQ(last_.state, SupervisorState::kActive);
    step(1);
    EXPECT_TRUE(last_.overran);
  }
  EXPECT_EQ(last_.state, SupervisorState::kStopping);
}

TEST_F(DaemonTest, ACycleTouchesNoHeap) {
  ASSERT_TRUE(reach(SupervisorState::kActive));
  std::uint64_t allocations = 0;
  for (int i = 0; i < 2000; ++i) {
    ++tick_.index;
    tick_.due_ns += robot_.period_ns;
    const rt::RealtimeGuard guard;
    daemon_->step(tick_);
    allocations += guard.seen().allocations;
  }
  EXPECT_EQ(allocations, 0U);
  EXPECT_GE(daemon_->phases().compute_ns.count(), 2000U);
}

TEST_F(DaemonTest, AServiceThreadThatSleepsCostsRecordsAndNothingElse) {
  for (int i = 0; i < 5000; ++i) {
    ++tick_.index;
    tick_.due_ns = 1'000'000'000 + tick_.index * robot_.period_ns;
    ASSERT_EQ(daemon_->step(tick_), rt::Next::kContinue);
  }
  EXPECT_EQ(daemon_->telemetry().records_dropped(), 5000U - 2048U);
  EXPECT_EQ(daemon_->telemetry().events_dropped(), 0U);
  EXPECT_EQ(controller_->report().state, SupervisorState::kActive);
}

}  // namespace
}  // namespace geodesic::tools
