// A robot on two buses, one of which dies and comes back: what the other one's joints notice of it.
// What the arms do about it is tests/control/arms_test.cpp's business.
#include <chrono>
#include <filesystem>
#include <mutex>
#include <optional>

#include "drivers/arm.hpp"
#include "drivers/bus/socket_bus_hub.hpp"
#include "drivers/families.hpp"
#include "tests/drivers/bus/bus_testing.hpp"

namespace geodesic::drivers {
namespace {

namespace fs = std::filesystem;
using control::DriveCondition;
using testing::kMillisecond;

/// A wire with one simulated drive on it, that can be taken away.
class Side {
 public:
  Side(std::string path, const DriveOptions& drive) : path_(std::move(path)), options_(drive) {
    connect();
  }
  ~Side() { die(); }
  Side(const Side&) = delete;
  Side& operator=(const Side&) = delete;

  void connect() {
    hub_.emplace(SocketBusHubOptions{.path = path_});
    stop_.store(false);
    BusOptions hearing;
    hearing.interface = "unix:" + path_;
    bus_ = open_bus(hearing);
    drive_ = find_family(options_.family)->make_simulated(options_);
    thread_ = std::thread([this] { answer(); });
  }
  /// Drive and wire at once.
  void die() {
    stop_.store(true);
    if (thread_.joinable()) thread_.join();
    bus_.reset();
    hub_.reset();
  }
  void hold(bool held) { hub_->hold(held); }

 private:
  void answer() {
    std::array<ReceivedFrame, 16> in;
    std::array<Frame, SimulatedDrive::kMaxReplies> replies;
    while (!stop_.load()) {
      pollfd waiting{.fd = bus_->descriptor(), .events = POLLIN, .revents = 0};
      ::poll(&waiting, 1, 5);
      const std::size_t count = bus_->receive(in);
      for (std::size_t i = 0; i < count; ++i) {
        bus_->send(std::span(replies).first(drive_->receive(in[i].frame, rt::now_ns(), replies)));
      }
    }
  }

  std::string path_;
  DriveOptions options_;
  std::optional<SocketBusHub> hub_;
  std::unique_ptr<Bus> bus_;
  std::unique_ptr<SimulatedDrive> drive_;
  std::atomic<bool> stop_{false};
  std::thread thread_;
};

// NOLINTNEXTLINE(cppcoreguidelines-virtual-class-destructor)
class TwoBuses : public ::testing::Test {
 protected:
  TwoBuses() {
    std::string name = (fs::temp_directory_path() / "geodesic-two-XXXXXX").string();
    folder_ = ::mkdtemp(name.data());
    for (const char* side : {"left", "right"}) {
      BusOptions bus;
      bus.name = side;
      bus.interface = "unix:" + (folder_ / side).string();
      JointOptions joint;
      joint.name = side;
      joint.bus = options_.buses.size();
      joint.drive.family = "damiao";
      joint.drive.id = 1;
      joint.drive.reply_id = 0x11;
      joint.drive.position_range_rad = 12.5;
      joint.drive.velocity_range_rad_s = 30.0;
      joint.drive.torque_range_nm = 10.0;
      joint.drive.watchdog_ns = 10'000'000'000;  // this machine may pause
      options_.buses.push_back(bus);
      options_.joints.push_back(joint);
      sides_.push_back(std::make_unique<Side>((folder_ / side).string(), joint.drive));
    }
    arm_ = std::make_unique<Arm>(options_);
    arm_->tend();
    command_.joints = 2;
    for (control::JointCommand& one : command_.joint) one.mode = control::DriveMode::kEnable;
  }
  ~TwoBuses() override {
    arm_.reset();
    sides_.clear();
    fs::remove_all(folder_);
  }

  /// Cycles of 2 ms, tended in between, until it holds or 5 s have passed.
  bool cycles_until(const std::function<bool(const control::ArmState&)>& holds) {
    const std::int64_t end = rt::now_ns() + testing::kPatienceNs;
    while (rt::now_ns() < end) {
      const std::int64_t tick = rt::now_ns();
      arm_->transmit(command_, tick);
      const control::ArmState& state = arm_->receive(tick, tick + 20 * kMillisecond);
      longest_ns_ = std::max(longest_ns_, rt::now_ns() - tick);
      if (holds(state)) return true;
      arm_->tend();
      ::usleep(2000);
    }
    return false;
  }
  bool both_enabled() {
    return cycles_until([](const control::ArmState& state) {
      return state.joint[0].condition == DriveCondition::kEnabled &&
             state.joint[1].condition == DriveCondition::kEnabled;
    });
  }

  fs::path folder_;
  ArmOptions options_;
  std::vector<std::unique_ptr<Side>> sides_;
  std::unique_ptr<Arm> arm_;
  control::ArmCommand command_;
  std::int64_t longest_ns_ = 0;
};

TEST_F(TwoBuses, OneMayDieAndTheOtherCarriesOn) {
  ASSERT_TRUE(both_enabled());
  sides_[0]->die();
  ASSERT_TRUE(cycles_until([](const control::ArmState& state) { return state.bus[0].down; }));
  longest_ns_ = 0;
  int cycles = 0;
  int fresh = 0;
  cycles_until([&](const control::ArmState& state) {
    EXPECT_TRUE(state.bus[0].down);
    EXPECT_FALSE(state.bus[1].down || state.bus[1].stalled);
    EXPECT_FALSE(state.joint[0].fresh);
    EXPECT_EQ(state.joint[1].condition, DriveCondition::kEnabled);
    fresh += state.joint[1].fresh ? 1 : 0;
    return ++cycles == 100;
  });
  EXPECT_GE(fresh, 95) << "of 100 replies on the bus that lives";

  sides_[0]->connect();  // and its drive has been off
  EXPECT_TRUE(cycles_until(
      [](const control::ArmState& state) { return !state.bus[0].down && state.joint[0].fresh; }));
  arm_->restart(1);
  command_.joint[0].mode = control::DriveMode::kMonitor;  // as when a law is asked for again
  EXPECT_TRUE(cycles_until([](const control::ArmState& state) {
    return state.joint[0].condition == DriveCondition::kDisabled;
  }));
  command_.joint[0].mode = control::DriveMode::kEnable;
  EXPECT_TRUE(both_enabled());
}

TEST_F(TwoBuses, OneMayStandStillAndTheOtherCarriesOn) {
  ASSERT_TRUE(both_enabled());
  sides_[0]->hold(true);
  ASSERT_TRUE(cycles_until([](const control::ArmState& state) { return state.bus[0].stalled; }));
  int cycles = 0;
  int fresh = 0;
  cycles_until([&](const control::ArmState& state) {
    EXPECT_FALSE(state.bus[1].down || state.bus[1].stalled);
    fresh += state.joint[1].fresh ? 1 : 0;
    return ++cycles == 50;
  });
  EXPECT_GE(fresh, 45);
  sides_[0]->hold(false);
  EXPECT_TRUE(cycles_until([](const control::ArmState& state) {
    return !state.bus[0].stalled && state.joint[0].fresh;
  }));
}

}  // namespace
}  // namespace geodesic::drivers
