// The simulated CiA 402 drive by itself, spoken to in bytes.
#include "drivers/cia402/simulated.hpp"

#include <gtest/gtest.h>

#include <cmath>
#include <fstream>
#include <numbers>
#include <optional>
#include <vector>

#include "tests/drivers/cia402/bench.hpp"
#include "tests/drivers/vectors/row.hpp"

namespace geodesic::drivers::cia402::test {
namespace {

class Cia402Simulated : public ::testing::Test {
 protected:
  void SetUp() override { speak(); }

  std::vector<Frame> ask(const Frame& frame) {
    std::array<Frame, 4> reply;
    now_ns += 1'000'000;
    const std::size_t count = drive.receive(frame, now_ns, reply);
    return {reply.begin(), reply.begin() + static_cast<std::ptrdiff_t>(count)};
  }
  std::vector<Frame> speak() {
    std::array<Frame, 4> said;
    const std::size_t count = drive.speak(now_ns, said);
    return {said.begin(), said.begin() + static_cast<std::ptrdiff_t>(count)};
  }
  std::optional<std::uint32_t> write(Object object, std::uint32_t value) {
    const Sdo reply = decode_sdo_reply(ask(encode_write(3, object, value)).at(0)).value();
    return reply.kind == Sdo::Kind::kAbort ? std::optional(reply.value) : std::nullopt;
  }
  std::uint32_t read(Object object) {
    return decode_sdo_reply(ask(encode_read(3, object)).at(0))->value;
  }
  /// Through RPDO1 as it stands, at the next SYNC.
  Report command(std::uint16_t word, std::int16_t torque = 0) {
    ask(encode_torque(3, {word, torque}));
    return decode_report(ask(encode_sync()).at(0)).value();
  }
  void configure() {
    for (const Frame& frame : reference_requests("configuration sequence")) {
      ask(frame);
    }
    write(object::kMode, 10);
    ask(encode_nmt({NmtCommand::kStart, 3}));
  }
  void power_up() {
    configure();
    command(0x06);
    command(0x07);
    ASSERT_EQ(power_state(command(0x0F).statusword), PowerState::kEnabled);
  }
  static std::vector<Frame> reference_requests(const char* what) {
    const std::string file = GEODESIC_TEST_DATA "/vectors/cia402.csv";
    std::ifstream stream(file);
    std::vector<Frame> found;
    for (const auto& row : drivers::test::read_rows(stream, file)) {
      if (row.command && row.says(what)) {
        found.push_back(row.frame);
      }
    }
    return found;
  }

  Simulated drive{bench_options()};
  std::int64_t now_ns = 0;
};

TEST_F(Cia402Simulated, AnswersTheReferenceMasterAsTheReferenceSlaveDoes) {
  drive.dictionary().set(object::kRatedTorque, 28000);
  const std::string file = GEODESIC_TEST_DATA "/vectors/cia402.csv";
  std::ifstream stream(file);
  const auto rows = drivers::test::read_rows(stream, file);
  int compared = 0;
  for (std::size_t i = 0; i + 1 < rows.size(); ++i) {
    if (rows[i].command && rows[i].frame.id == 0x603 && !rows[i + 1].command) {
      ASSERT_EQ(ask(rows[i].frame).at(0), rows[i + 1].frame) << rows[i].description;
      ++compared;
    }
  }
  EXPECT_EQ(compared, 21);
}

TEST_F(Cia402Simulated, BootsAndBeats) {
  Simulated fresh(bench_options());
  std::array<Frame, 4> out;
  EXPECT_EQ(fresh.receive(encode_read(3, object::kMode), 0, out), 0U);  // not yet
  ASSERT_EQ(fresh.speak(0, out), 1U);
  EXPECT_EQ(out[0], encode_heartbeat(3, NmtState::kBootUp));
  EXPECT_EQ(fresh.speak(1'000'000, out), 0U);
  EXPECT_EQ(write(object::kProducerHeartbeat, 20), std::nullopt);
  int beats = 0;
  for (int i = 0; i < 200; ++i, now_ns += 1'000'000) {
    for (const Frame& frame : speak()) {
      EXPECT_EQ(frame, encode_heartbeat(3, NmtState::kPreOperational));
      ++beats;
    }
  }
  EXPECT_EQ(beats, 10);
}

TEST_F(Cia402Simulated, AbortsWhatItMust) {
  const auto code = [](Abort abort) { return static_cast<std::uint32_t>(abort); };
  EXPECT_EQ(write({0x5FFF, 0, 4}, 0), code(Abort::kNoObject));
  EXPECT_EQ(write({0x6091, 9, 4}, 0), code(Abort::kNoSub));
  EXPECT_EQ(write(object::kStatusword, 0), code(Abort::kReadOnly));
  EXPECT_EQ(write({0x6072, 0, 4}, 1), code(Abort::kLength));
  EXPECT_EQ(write(object::kMode, 3), code(Abort::kRange));
  EXPECT_EQ(write(object::kAbortConnection, 9), code(Abort::kRange));
  EXPECT_EQ(write(object::kStoreAll, 1), code(Abort::kNotStored));
  EXPECT_EQ(write(object::kTransmitId, 0x183), std::nullopt);
  EXPECT_EQ(write(object::kTransmitCount, 0), code(Abort::kDeviceState));  // the PDO is valid
  EXPECT_EQ(write(object::kTransmitId, 0x184), code(Abort::kRange));
  EXPECT_EQ(write(object::kTransmitId, 0x80000183), std::nullopt);
  EXPECT_EQ(write({0x1A00, 1, 4}, 0x60760020), code(Abort::kNotMappable));
  EXPECT_EQ(write({0x1A00, 1, 4}, 0x60640020), std::nullopt);
  EXPECT_EQ(write({0x1A00, 2, 4}, 0x606C0020), std::nullopt);
  EXPECT_EQ(write({0x1A00, 3, 4}, 0x60770010), std::nullopt);
  EXPECT_EQ(write(object::kTransmitCount, 3), code(Abort::kPdoTooLong));
  EXPECT_EQ(write(object::kTransmitCount, 2), std::nullopt);
  EXPECT_EQ(write({0x1A00, 1, 4}, 0x60640020), code(Abort::kDeviceState));  // count is not 0
}

TEST_F(Cia402Simulated, HearsOnlyWhatIsForIt) {
  Frame frame = encode_read(3, object::kMode);
  EXPECT_EQ(ask(frame).size(), 1U);
  frame.id = 0x604;
  EXPECT_TRUE(ask(frame).empty());
  frame.id = 0x603;
  frame.length = 7;
  EXPECT_TRUE(ask(frame).empty());
  frame.length = 8;
  frame.extended = true;
  EXPECT_TRUE(ask(frame).empty());
  frame.extended = false;
  frame.fd = true;
  EXPECT_TRUE(ask(frame).empty());
  ask(encode_nmt({NmtCommand::kStart, 4}));
  EXPECT_EQ(drive.nmt_state(), NmtState::kPreOperational);
  ask(encode_nmt({NmtCommand::kStop, 0}));
  EXPECT_TRUE(ask(encode_read(3, object::kMode)).empty());  // stopped: no SDO
}

TEST_F(Cia402Simulated, PdosWorkOnlyInOperational) {
  configure();
  ask(encode_nmt({NmtCommand::kPreOperational, 3}));
  EXPECT_TRUE(ask(encode_sync()).empty());
  ask(encode_nmt({NmtCommand::kStart, 3}));
  EXPECT_EQ(ask(encode_sync()).size(), 1U);
}

TEST_F(Cia402Simulated, WalksTheStateMachineOneTransitionAtATime) {
  configure();
  EXPECT_EQ(power_state(command(0x0F).statusword), PowerState::kSwitchOnDisabled);
  EXPECT_EQ(power_state(command(0x06).statusword), PowerState::kReady);
  EXPECT_EQ(power_state(command(0x0F).statusword), PowerState::kReady);
  EXPECT_EQ(power_state(command(0x07).statusword), PowerState::kSwitchedOn);
  EXPECT_EQ(power_state(command(0x0F, 100).statusword), PowerState::kEnabled);
  EXPECT_NEAR(drive.torque_nm(now_ns), 2.8, 1e-12);
  EXPECT_EQ(power_state(command(0x02).statusword), PowerState::kSwitchOnDisabled);  // quick stop
  EXPECT_EQ(drive.torque_nm(now_ns), 0.0);
}

TEST_F(Cia402Simulated, StaysInQuickStopWhereTheOptionSaysSo) {
  power_up();
  write(object::kQuickStop, 6);
  EXPECT_EQ(power_state(command(0x02).statusword), PowerState::kQuickStop);
  EXPECT_EQ(drive.torque_nm(now_ns), 0.0);
  EXPECT_EQ(power_state(command(0x0F).statusword), PowerState::kEnabled);
}

TEST_F(Cia402Simulated, SaturatesAtMaxTorqueAndSaysSo) {
  power_up();
  EXPECT_EQ(write(object::kMaxTorque, 500), std::nullopt);
  const Report report = command(0x0F, 1000);
  EXPECT_EQ(report.torque_permille, 500);
  EXPECT_NE(report.statusword & kInternalLimit, 0);
  EXPECT_NEAR(drive.torque_nm(now_ns), 14.0, 1e-12);
}

TEST_F(Cia402Simulated, MakesNoTorqueInAnotherMode) {
  power_up();
  command(0x0F, 100);
  EXPECT_EQ(write(object::kMode, 8), std::nullopt);
  EXPECT_EQ(drive.torque_nm(now_ns), 0.0);
}

TEST_F(Cia402Simulated, TorqueOfTypeOneWaitsForSyncAndOfType255DoesNot) {
  power_up();
  ask(encode_torque(3, {0x0F, 100}));
  EXPECT_EQ(drive.torque_nm(now_ns), 0.0);
  ask(encode_sync());
  EXPECT_NEAR(drive.torque_nm(now_ns), 2.8, 1e-12);
  write(object::kReceiveType, 255);
  ask(encode_torque(3, {0x0F, 200}));
  EXPECT_NEAR(drive.torque_nm(now_ns), 5.6, 1e-12);
}

TEST_F(Cia402Simulated, ReportsEveryNthSync) {
  configure();
  write(object::kTransmitType, 3);
  std::size_t reports = 0;
  for (int i = 0; i < 9; ++i) {
    reports += ask(encode_sync()).size();
  }
  EXPECT_EQ(reports, 3U);
}

TEST_F(Cia402Simulated, FaultsLatchUntilAnEdgeOfReset) {
  power_up();
  drive.inject_error(2);
  EXPECT_EQ(speak().at(0), encode_emergency(3, {0x2310, 1}));
  EXPECT_EQ(read(object::kErrorCode), 0x2310U);
  EXPECT_EQ(power_state(command(0x0F, 100).statusword), PowerState::kFault);
  EXPECT_EQ(power_state(command(0x80).statusword), PowerState::kSwitchOnDisabled);
  EXPECT_EQ(speak().at(0), encode_emergency(3, {0, 0}));
  drive.inject_error(2);
  EXPECT_EQ(power_state(command(0x80).statusword), PowerState::kFault);  // no edge
  EXPECT_EQ(power_state(command(0x00).statusword), PowerState::kFault);
  EXPECT_EQ(power_state(command(0x80).statusword), PowerState::kSwitchOnDisabled);
}

TEST_F(Cia402Simulated, EachWatchdogActsAs0x6007Says) {
  for (const bool timer : {true, false}) {
    for (std::uint32_t reaction = 0; reaction <= 3; ++reaction) {
      drive.power_cycle();
      speak();
      power_up();
      write(object::kAbortConnection, reaction);
      write(timer ? object::kReceiveTimer : object::kConsumerHeartbeat, timer ? 50 : 0x7F0032);
      if (!timer) {
        ask(encode_heartbeat(0x7F, NmtState::kOperational));
      }
      command(0x0F, 100);
      now_ns += 45'000'000;
      EXPECT_NEAR(drive.torque_nm(now_ns), 2.8, 1e-12);
      now_ns += 10'000'000;
      EXPECT_NEAR(drive.torque_nm(now_ns), reaction == 0 ? 2.8 : 0.0, 1e-12);
      EXPECT_EQ(drive.power_state(), reaction == 0   ? PowerState::kEnabled
                                     : reaction == 1 ? PowerState::kFault
                                                     : PowerState::kSwitchOnDisabled);
      EXPECT_EQ(decode_emergency(speak().at(0))->code, timer ? 0x8250 : 0x8130);
      EXPECT_EQ(drive.nmt_state(),
                timer ? NmtState::kOperational : NmtState::kPreOperational);  // 0x1029 is 0
    }
  }
}

TEST_F(Cia402Simulated, AShortPdoIsComplainedOfAndNotObeyed) {
  power_up();
  Frame frame = encode_torque(3, {0x0F, 100});
  frame.length = 3;
  ask(frame);
  ask(encode_sync());
  EXPECT_EQ(drive.torque_nm(now_ns), 0.0);
  EXPECT_EQ(decode_emergency(speak().at(0))->code, 0x8210);
}

TEST_F(Cia402Simulated, CountsWholeIncrementsDownwards) {
  configure();
  const double increment = 2.0 * std::numbers::pi / 1'638'400.0;
  for (const double count : {0.0, 0.9, 1.0, -0.1, -1.0, 12345.6}) {
    drive.set_shaft(count * increment, 0.0);
    EXPECT_EQ(command(0).position, static_cast<std::int32_t>(std::floor(count + 1e-5))) << count;
  }
}

TEST_F(Cia402Simulated, KeepsOrLosesItsTurnsAtPowerOff) {
  DriveOptions options = bench_options();
  options.leader = true;
  for (const Turns turns : {Turns::kKept, Turns::kLost}) {
    put(options, Setting::kEncoderTurns, static_cast<double>(turns));
    Simulated one(options);
    one.set_shaft(1.0, 0.0);
    one.power_cycle();
    std::array<Frame, 4> out;
    one.speak(0, out);
    one.receive(encode_read(3, object::kPosition), 0, out);
    const auto position = static_cast<std::int32_t>(decode_sdo_reply(out[0])->value);
    const double whole = std::floor(1.0 / (2.0 * std::numbers::pi) * 1'638'400.0);
    const double turn = 16384.0;
    EXPECT_EQ(position, turns == Turns::kKept ? whole : whole - turn * std::floor(whole / turn));
  }
}

TEST_F(Cia402Simulated, WhatWasStoredSurvivesPowerOffAndTheRestDoesNot) {
  write(object::kHomeOffset, 500);
  write(object::kMaxTorque, 900);
  EXPECT_EQ(write(object::kStoreAll, kSave), std::nullopt);
  write(object::kMaxTorque, 800);
  write(object::kConsumerHeartbeat, 0x7F0032);
  drive.power_cycle();
  EXPECT_EQ(speak().at(0), encode_heartbeat(3, NmtState::kBootUp));
  EXPECT_EQ(read(object::kHomeOffset), 500U);
  EXPECT_EQ(read(object::kMaxTorque), 900U);
  EXPECT_EQ(read(object::kConsumerHeartbeat), 0U);
  EXPECT_EQ(read(object::kPosition), static_cast<std::uint32_t>(-500));
}

TEST_F(Cia402Simulated, ResetCommunicationForgetsCommunicationAlone) {
  write(object::kMaxTorque, 900);
  write(object::kProducerHeartbeat, 20);
  ask(encode_nmt({NmtCommand::kResetCommunication, 3}));
  speak();
  EXPECT_EQ(read(object::kMaxTorque), 900U);
  EXPECT_EQ(read(object::kProducerHeartbeat), 0U);
  ask(encode_nmt({NmtCommand::kResetNode, 3}));
  speak();
  EXPECT_EQ(read(object::kMaxTorque), 1000U);
}

}  // namespace
}  // namespace geodesic::drivers::cia402::test
