// The simulated ODrive by itself, spoken to in bytes.
#include "drivers/odrive/simulated.hpp"

#include <gtest/gtest.h>

#include <bit>
#include <cmath>
#include <string>
#include <tuple>

#include "tests/drivers/odrive/bench.hpp"

namespace geodesic::drivers::odrive::test {
namespace {

Frame bytes(std::uint32_t id, std::initializer_list<int> data) {
  Frame frame;
  frame.id = id;
  for (const int byte : data) {
    frame.data[frame.length++] = static_cast<std::uint8_t>(byte);
  }
  return frame;
}
Frame remote(std::uint32_t id) {
  Frame frame;
  frame.id = id;
  frame.remote = true;
  return frame;
}

class OdriveSimulated : public ::testing::Test {
 protected:
  std::optional<Frame> ask(const Frame& frame, Simulated& of) {
    now_ns += 1'000'000;
    return of.receive(frame, now_ns, replies) == 1 ? std::optional(replies[0]) : std::nullopt;
  }
  std::optional<Frame> ask(const Frame& frame) { return ask(frame, drive); }
  void enable() {
    ask(bytes(0x0AB, {1, 0, 0, 0, 1, 0, 0, 0}));
    ask(bytes(0x0AF, {0, 0, 0xC8, 0x41, 0, 0, 0xC8, 0x41}));  // 25 rev/s, 25 A
    ask(bytes(0x0AE, {0, 0, 0, 0}));
    ask(bytes(0x0A7, {8, 0, 0, 0}));
  }
  double torque() { return drive.torque_nm(now_ns); }

  Simulated drive{bench_options()};
  Simulated old_drive{old_options()};
  std::int64_t now_ns = 0;
  std::array<Frame, SimulatedDrive::kMaxReplies> replies;
};

TEST_F(OdriveSimulated, AnswersRequestsInTheBytesOfTheVectors) {
  EXPECT_EQ(ask(remote(0x0A0)), bytes(0x0A0, {2, 4, 4, 0x3A, 0, 6, 9, 0}));
  EXPECT_EQ(ask(remote(0x0A3)), bytes(0x0A3, {0, 0, 0, 0, 0, 0, 0, 0}));
  EXPECT_EQ(ask(bytes(0x0A3, {})), bytes(0x0A3, {0, 0, 0, 0, 0, 0, 0, 0}));
  drive.set_shaft(-1.5 * kTurn, 0.25 * kTurn);
  EXPECT_EQ(ask(remote(0x0A9)), bytes(0x0A9, {0, 0, 0xC0, 0xBF, 0, 0, 0x80, 0x3E}));
  EXPECT_FALSE(ask(remote(0x0C9)));  // another node
  EXPECT_FALSE(ask(bytes(0x0A9, {1})));
  EXPECT_FALSE(ask(remote(0x0A0), old_drive));  // 0.5 never answers it
  EXPECT_TRUE(ask(remote(0x0A4), old_drive));
  EXPECT_FALSE(ask(remote(0x0A4)));  // a command in 0.6
  Frame frame = remote(0x0A9);
  frame.extended = true;
  EXPECT_FALSE(ask(frame));
}

TEST_F(OdriveSimulated, SpeaksByTimersOfItsOwn) {
  int heartbeats = 0;
  int estimates = 0;
  for (int i = 0; i < 1000; ++i) {
    now_ns += 1'000'000;
    const std::size_t count = drive.speak(now_ns, replies);
    for (std::size_t k = 0; k < count; ++k) {
      heartbeats += replies[k] == bytes(0x0A1, {0, 0, 0, 0, 1, 0, 0, 0}) ? 1 : 0;
      estimates += replies[k].id == 0x0A9 ? 1 : 0;
    }
    ask(bytes(0x0AE, {0, 0, 0, 0}));
    now_ns -= 1'000'000;
  }
  EXPECT_NEAR(heartbeats, 10, 1);
  EXPECT_NEAR(estimates, 1000, 2);
}

TEST_F(OdriveSimulated, HeartbeatsDifferBetweenFirmwares) {
  const auto heartbeat = [this](Simulated& of) {
    for (int i = 0; i < 200; ++i) {
      now_ns += 1'000'000;
      const std::size_t count = of.speak(now_ns, replies);
      for (std::size_t k = 0; k < count; ++k) {
        if (replies[k].id == 0x0A1) {
          return replies[k];
        }
      }
    }
    return Frame{};
  };
  drive.inject_error(kActiveBase + 9);
  old_drive.inject_error(kMotorBase + 4);
  EXPECT_EQ(heartbeat(drive).data[1] & 2, 2);
  const Frame old_one = heartbeat(old_drive);
  EXPECT_EQ(old_one.data[0] & 0x40, 0x40);
  EXPECT_EQ(old_one.data[5], 1);
  EXPECT_EQ(old_one.data[7], 0x80);
}

TEST_F(OdriveSimulated, MakesTorqueOnlyInClosedLoopAndTorqueMode) {
  const Frame torque_frame = bytes(0x0AE, {0, 0, 0x40, 0x3F, 0xDE, 0xAD, 0xBE, 0xEF});  // 0.75
  ask(torque_frame);
  EXPECT_EQ(torque(), 0.0);
  enable();
  EXPECT_TRUE(drive.enabled());
  ask(torque_frame);
  EXPECT_EQ(torque(), 0.75);
  ask(bytes(0x0AE, {0, 0, 0xC0, 0x7F}));  // NaN is not acted on
  EXPECT_EQ(torque(), 0.75);
  ask(bytes(0x0AB, {3, 0, 0, 0, 1, 0, 0, 0}));
  EXPECT_EQ(torque(), 0.0);
}

TEST_F(OdriveSimulated, SaturatesAtItsCurrentAndNearItsVelocityLimit) {
  enable();
  ask(bytes(0x0AE, {0, 0, 0x20, 0x41}));  // 10 N·m, but 25 A are 2.5
  EXPECT_EQ(torque(), 2.5);
  drive.set_shaft(0.0, 22.0 * kTurn);
  EXPECT_NEAR(torque(), 0.5, 1e-6);
  drive.set_shaft(0.0, 40.0 * kTurn);
  EXPECT_EQ(torque(), 0.0);
  EXPECT_FALSE(drive.enabled());
}

TEST_F(OdriveSimulated, ItsWatchdogIsFedBySetPointsOrIn05ByAnything) {
  const auto idle = [this](Simulated& of, const Frame& frame) {
    for (int i = 0; i < 100; ++i) {
      ask(frame, of);
    }
    return ask(remote(0x0A3), of)->data[3] == 1;  // 0.6: watchdog among the active errors
  };
  EXPECT_FALSE(idle(drive, bytes(0x0AE, {0, 0, 0, 0})));
  EXPECT_TRUE(idle(drive, remote(0x0A9)));
  for (int i = 0; i < 100; ++i) {
    ask(remote(0x0A9), old_drive);
  }
  ask(bytes(0x0A7, {8, 0, 0, 0}), old_drive);
  EXPECT_TRUE(old_drive.enabled());
  now_ns += 51'000'000;
  EXPECT_EQ(old_drive.torque_nm(now_ns), 0.0);
  EXPECT_FALSE(old_drive.enabled());
  ask(bytes(0x0A7, {8, 0, 0, 0}), old_drive);
  EXPECT_FALSE(old_drive.enabled());  // not without Clear_Errors
  ask(bytes(0x0B8, {}), old_drive);
  ask(bytes(0x0A7, {8, 0, 0, 0}), old_drive);
  EXPECT_TRUE(old_drive.enabled());
}

TEST_F(OdriveSimulated, TellsWhyItWasDisarmed) {
  enable();
  now_ns += 60'000'000;
  const Frame error = ask(remote(0x0A3)).value();
  EXPECT_EQ(error, bytes(0x0A3, {0, 0, 0, 1, 0, 0, 0, 1}));
  Simulated idle(bench_options());
  ask(remote(0x0A3), idle);
  now_ns += 60'000'000;
  EXPECT_EQ(ask(remote(0x0A3), idle), bytes(0x0A3, {0, 0, 0, 1, 0, 0, 0, 0}));
}

TEST_F(OdriveSimulated, EndpointsAreReadAndWrittenAndLostUnlessSaved) {
  Simulated with(endpoint_options());
  EXPECT_EQ(ask(bytes(0x0A4, {0, 202, 0, 0}), with), bytes(0x0A5, {0, 202, 0, 0, 0}));
  EXPECT_FALSE(ask(bytes(0x0A4, {1, 202, 0, 0, 1}), with));
  EXPECT_EQ(ask(bytes(0x0A4, {0, 202, 0, 0}), with), bytes(0x0A5, {0, 202, 0, 0, 1}));
  EXPECT_EQ(ask(bytes(0x0A4, {0, 203, 0, 0}), with), bytes(0x0A5, {0, 203, 0, 0, 10, 0, 0, 0}));
  EXPECT_FALSE(ask(bytes(0x0A4, {0, 99, 0, 0}), with));
  with.power_cycle();
  EXPECT_FALSE(ask(remote(0x0A3), with));  // it boots
  now_ns += Simulated::kBootNs;
  EXPECT_EQ(ask(bytes(0x0A4, {0, 202, 0, 0}), with), bytes(0x0A5, {0, 202, 0, 0, 0}));
  with.set_firmware_revision(11);
  EXPECT_EQ(ask(bytes(0x0A4, {1, 202, 0, 0, 1}), with), bytes(0x0A5, {0, 202, 0, 0}));
}

TEST_F(OdriveSimulated, ForgetsWholeTurnsAtPowerOffAndKeepsASavedZero) {
  drive.set_shaft(2.25 * kTurn, 0.0);
  const auto position = [this] {
    const Frame frame = ask(remote(0x0A9)).value();
    return *decode(frame, kEstimates.fields[0]);
  };
  EXPECT_NEAR(position(), 2.25, 1e-4);
  drive.power_cycle();
  ask(remote(0x0A9));
  now_ns += Simulated::kBootNs;
  EXPECT_NEAR(position(), 0.25, 1e-4);
  ask(bytes(0x0B9, {0, 0, 0, 0}));
  EXPECT_NEAR(position(), 0.0, 1e-4);
  ask(bytes(0x0B6, {1}));  // save
  ask(remote(0x0A9));
  now_ns += Simulated::kBootNs;
  EXPECT_NEAR(position(), 0.0, 1e-4);
}

TEST_F(OdriveSimulated, TakesFramesOfAnyLengthWithoutHarm) {
  for (std::uint32_t command = 0; command < 32; ++command) {
    for (int length = 0; length <= 8; ++length) {
      Frame frame = bytes(0x0A0 | command, {});
      frame.length = static_cast<std::uint8_t>(length);
      frame.data.fill(0xFF);
      ask(frame);
      ask(frame, old_drive);
      EXPECT_TRUE(std::isfinite(torque()));
      EXPECT_EQ(torque(), 0.0);
    }
  }
}

TEST_F(OdriveSimulated, FallsIntoTheErrorItIsTold) {
  for (std::uint8_t bit = 0; bit < 32; ++bit) {
    Simulated fresh(bench_options());
    fresh.inject_error(static_cast<std::uint8_t>(kActiveBase + bit));
    const Frame error = ask(remote(0x0A3), fresh).value();
    EXPECT_EQ(*decode(error, kError06.fields[0]), std::ldexp(1.0, bit));
  }
  for (const auto& [code, command, field] :
       {std::tuple{kMotorBase + 35, 0x0A3U, 0}, std::tuple{kEncoderBase + 8, 0x0A4U, 0},
        std::tuple{kControllerBase + 7, 0x0BDU, 0}}) {
    Simulated fresh(old_options());
    fresh.inject_error(static_cast<std::uint8_t>(code));
    const Message* message = find_message(Firmware::k05, command & kCommandMask);
    EXPECT_GT(*decode(ask(remote(command), fresh).value(), message->fields[0]), 0.0) << code;
    EXPECT_EQ(std::string(error_name(static_cast<std::uint8_t>(code))).find("unknown"),
              std::string::npos);
  }
}

}  // namespace
}  // namespace geodesic::drivers::odrive::test
