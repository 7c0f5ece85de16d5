// The service thread that fails: the arm comes to its stop, and nobody waits for ever.
#include "tools/geodesicd/service.hpp"

#include <gtest/gtest.h>
#include <spdlog/sinks/ostream_sink.h>

#include <chrono>
#include <memory>
#include <sstream>
#include <stdexcept>
#include <thread>

#include "tests/drivers/fake_bus.hpp"
#include "tests/tools/geodesicd_fixture.hpp"

namespace geodesic::tools {
namespace {

using std::chrono::milliseconds;

class ServiceTest : public testing::Test {
 protected:
  ServiceTest() {
    rt::ThreadOptions options;
    options.best_effort = true;
    loop_ = std::make_unique<rt::CyclicThread>(options);
    std::vector<std::unique_ptr<drivers::Bus>> buses;
    buses.push_back(std::make_unique<drivers::test::FakeBus>(wire_));
    arm_ = std::make_unique<drivers::Arm>(robot_.arm, std::move(buses));
    controller_ = std::make_unique<control::Controller>(
        control::Mechanism(robot_.tree, robot_.gravity), robot_.controller);
    daemon_ = std::make_unique<Daemon>(*arm_, *controller_, DaemonOptions());
    config::LoadResult loaded;
    loaded.robot = robot_;
    tuning_ = std::make_unique<Tuning>(CommandLine(), loaded, daemon_->setups(), log_);
    keeper_ = std::make_unique<BusKeeper>(*arm_, robot_.arm.buses);
    service_ = std::make_unique<Service>(ServiceOptions(), words_, *daemon_, *loop_, socket_, log_,
                                         *tuning_, *keeper_, nullptr);
  }

  bool ends_within_10_s() const {
    for (int i = 0; i < 1000 && loop_->running(); ++i) {
      std::this_thread::sleep_for(milliseconds(10));
    }
    return !loop_->running();
  }

  TemporaryFolder folder_;
  config::Robot robot_ = small_robot();
  drivers::test::FakeWire wire_;
  std::ostringstream said_;
  Log log_{LogOptions(), std::make_shared<spdlog::sinks::ostream_sink_mt>(said_)};
  ControlServer socket_{folder_ / "service.sock"};
  Vocabulary words_{robot_};
  std::unique_ptr<rt::CyclicThread> loop_;
  std::unique_ptr<drivers::Arm> arm_;
  std::unique_ptr<control::Controller> controller_;
  std::unique_ptr<Daemon> daemon_;
  std::unique_ptr<Tuning> tuning_;
  std::unique_ptr<BusKeeper> keeper_;
  std::unique_ptr<Service> service_;
};

TEST_F(ServiceTest, AFailureEndsTheRunByAControlledStop) {
  ASSERT_FALSE(loop_->start(*daemon_).has_value());
  service_->start([] { throw std::runtime_error("no memory left"); });
  EXPECT_TRUE(ends_within_10_s());
  EXPECT_TRUE(service_->stop());
  EXPECT_NE(said_.str().find("the service thread failed: no memory left; controlled stop"),
            std::string::npos)
      << said_.str();
}

TEST_F(ServiceTest, WhoHangsIsNotWaitedFor) {
  std::atomic<bool> hangs{true};
  ASSERT_FALSE(loop_->start(*daemon_).has_value());
  service_->start([&hangs] {
    while (hangs.load()) std::this_thread::sleep_for(milliseconds(1));
  });
  daemon_->lifetime().ask_exit();
  EXPECT_TRUE(ends_within_10_s()) << "the real-time thread must not need the service thread";
  EXPECT_FALSE(service_->stop());
  hangs.store(false);
  EXPECT_TRUE(service_->stop());
}

TEST_F(ServiceTest, TellsWhoAskedForTheEnd) {
  ASSERT_FALSE(loop_->start(*daemon_).has_value());
  service_->start([] {});
  service_->asked_to_end(1);
  service_->asked_to_end(3);
  daemon_->lifetime().ask_exit();
  EXPECT_TRUE(ends_within_10_s());
  EXPECT_TRUE(service_->stop());
  EXPECT_NE(said_.str().find("asked to end: controlled stop"), std::string::npos);
  EXPECT_NE(said_.str().find("for the third time: torque off"), std::string::npos);
}

}  // namespace
}  // namespace geodesic::tools
