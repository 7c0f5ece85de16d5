// The start-up dialogue against the simulated drive: what is asked in which order, what is refused.
#include "drivers/cia402/start_up.hpp"

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <fstream>
#include <string>

#include "tests/drivers/cia402/bench.hpp"
#include "tests/drivers/vectors/row.hpp"

namespace geodesic::drivers::cia402::test {
namespace {

using control::DriveCondition;

bool contains(const char* text, const char* part) {
  return text != nullptr && std::string(text).find(part) != std::string::npos;
}

TEST(Cia402StartUp, SaysNothingOfADriveThatDoesNotAnswer) {
  Bench bench;
  bench.cut = true;
  bench.run(1500);
  EXPECT_EQ(bench.driver.state().condition, DriveCondition::kUnknown);
  EXPECT_EQ(bench.sent_on(cob::kNmt).size(), 1U);  // a drive that boots slowly is left to boot
  bench.run(1000);
  EXPECT_EQ(bench.sent_on(cob::kNmt).size(), 2U);
  bench.cut = false;
  EXPECT_GT(bench.run_until(DriveCondition::kDisabled), 0);
}

TEST(Cia402StartUp, ADriveThatIsSwitchedOnLaterIsTakenAtItsBootUp) {
  Bench bench;
  bench.cut = true;
  bench.run(100);
  bench.cut = false;
  bench.drive.power_cycle();
  EXPECT_GT(bench.run_until(DriveCondition::kDisabled), 0);
  EXPECT_EQ(bench.sent_on(cob::kNmt).size(), 2U);  // reset, start
}

TEST(Cia402StartUp, SetsUpEverythingWithinATenthOfASecondAtOneKilohertz) {
  Bench bench;
  const int cycles = bench.run_until(DriveCondition::kDisabled);
  EXPECT_GT(cycles, 40);
  EXPECT_LT(cycles, 100);
  const Dictionary& d = bench.drive.dictionary();
  EXPECT_EQ(d.value(object::kMode), 10U);
  EXPECT_EQ(d.value(object::kMaxTorque), 1500U);
  EXPECT_EQ(d.value(object::kAbortConnection), 1U);
  EXPECT_EQ(d.value(object::kProducerHeartbeat), 20U);
  EXPECT_EQ(d.value(object::kTransmitId), 0x183U);
  EXPECT_EQ(d.value({0x1801, 1, 4}), 0x283U);
  EXPECT_EQ(d.value({0x1802, 1, 4}), 0x80000383U);
  EXPECT_EQ(d.value({0x1803, 1, 4}), 0x80000483U);
  EXPECT_EQ(d.value({0x1402, 1, 4}), 0x80000403U);
  EXPECT_EQ(bench.drive.nmt_state(), NmtState::kOperational);
  EXPECT_EQ(bench.drive.power_state(), PowerState::kSwitchOnDisabled);
  EXPECT_EQ(bench.driver.revision(), 0x00010002U);
  EXPECT_FALSE(bench.drive.enabled());
}

TEST(Cia402StartUp, OneRequestIsUnderWayAtATime) {
  Bench bench;
  bench.deaf = true;
  bench.run(49);
  EXPECT_TRUE(bench.sent_on(0x603).empty());
  bench.deaf = false;
  for (int i = 0; i < 100; ++i) {
    bench.cycle();
    EXPECT_LE(bench.frames, 3U);
    EXPECT_LE(bench.due, 2U);
  }
}

TEST(Cia402StartUp, ConfiguresPdosInTheOrderAndBytesOfTheReference) {
  const std::string file = GEODESIC_TEST_DATA "/vectors/cia402.csv";
  std::ifstream stream(file);
  std::vector<Frame> wanted;
  for (const auto& row : drivers::test::read_rows(stream, file)) {
    if (row.command && row.says("configuration sequence")) {
      wanted.push_back(row.frame);
    }
  }
  ASSERT_EQ(wanted.size(), 15U);
  DriveOptions options = bench_options();
  put(options, Setting::kReceiveTimer, static_cast<double>(ReceiveTimer::kOff));
  Bench bench(options);
  ASSERT_GT(bench.run_until(DriveCondition::kDisabled), 0);
  const auto configures = [](const Frame& frame) {
    const unsigned index = frame.data[1] + 256U * frame.data[2];
    const bool writes = frame.data[0] != 0x40;
    return writes && (index == 0x1800 || index == 0x1A00 || index == 0x1400 || index == 0x1600);
  };
  std::vector<Frame> sent;
  for (const Frame& frame : bench.sent_on(0x603)) {
    if (configures(frame)) {
      sent.push_back(frame);
    }
  }
  // The reference calls its RPDO1 0x203 already while it is switched off, as we do.
  EXPECT_EQ(sent, wanted);
}

TEST(Cia402StartUp, WhatContradictsTheConfigurationIsNamedFoundAndExpected) {
  struct Case {
    Object object;
    std::uint32_t found;
    double told;
    double expected;
    const char* name;
  };
  DriveOptions options = bench_options();
  put(options, Setting::kVendor, 0x1234);
  put(options, Setting::kProduct, 0x5678);
  put(options, Setting::kLeastRevision, 0x00020000);
  for (const Case& one : {
           Case{object::kDeviceType, 0x00020191, 0x191, 0x192, "0x1000:0"},
           Case{object::kVendor, 0x1235, 0x1235, 0x1234, "0x1018:1"},
           Case{object::kProduct, 0x5679, 0x5679, 0x5678, "0x1018:2"},
           Case{object::kRevision, 0x0001FFFF, 0x1FFFF, 0x20000, "0x1018:3"},
           Case{object::kSupportedModes, 0x1A0, 0, 0x200, "0x6502:0"},
           Case{object::kRatedTorque, 281, 281, 280, "0x6076:0"},
           Case{object::kEncoderIncrements, 65536, 65536, 16384, "0x608F:1"},
           Case{object::kEncoderRevolutions, 2, 2, 1, "0x608F:2"},
           Case{object::kGearMotor, 101, 101, 100, "0x6091:1"},
           Case{object::kGearShaft, 2, 2, 1, "0x6091:2"},
       }) {
    Bench bench(options);
    bench.drive.dictionary().set_factory(one.object, one.found);
    ASSERT_GT(bench.run_until(DriveCondition::kRefused), 0) << one.name;
    const DriveComplaint& complaint = bench.driver.complaint();
    EXPECT_TRUE(contains(complaint.quantity, one.name)) << complaint.quantity;
    EXPECT_EQ(complaint.found, one.told) << one.name;
    EXPECT_EQ(complaint.expected, one.expected) << one.name;
    EXPECT_NE(complaint.fix, nullptr);
    EXPECT_EQ(bench.drive.dictionary().value(object::kConsumerHeartbeat), 0U);  // nothing was set
    bench.run(50, enable(1.0));
    EXPECT_EQ(bench.driver.state().condition, DriveCondition::kRefused);
    EXPECT_FALSE(bench.drive.enabled());
  }
}

TEST(Cia402StartUp, AnAbortedTransferIsNamedWithItsMeaning) {
  for (const Object object :
       {object::kRatedTorque, object::kEncoderIncrements, object::kConsumerHeartbeat,
        object::kProducerHeartbeat, object::kAbortConnection, object::kMaxTorque, object::kMode,
        object::kModeDisplay, object::kSupportedModes, object::kTransmitId, object::kReceiveId,
        object::kTransmitCount, object::kVelocity, object::kTargetTorque}) {
    Bench bench;
    bench.drive.dictionary().remove(object);
    ASSERT_GT(bench.run_until(DriveCondition::kRefused), 0) << std::hex << object.index;
    EXPECT_TRUE(contains(bench.driver.complaint().fix, "the drive aborts (0x06"));
    EXPECT_TRUE(std::isnan(bench.driver.complaint().found));
  }
}

TEST(Cia402StartUp, WhatADriveMayLackIsDoneWithout) {
  DriveOptions options = bench_options();
  put(options, Setting::kGearMotor, 1);
  for (const Object object :
       {object::kVendor, object::kRevision, object::kEncoderRevolutions, object::kGearMotor,
        object::kGearShaft, object::kReceiveTimer, Object{0x1802, 1, 4}, Object{0x1403, 1, 4}}) {
    Bench bench(options);
    bench.drive.dictionary().remove(object);
    EXPECT_GT(bench.run_until(DriveCondition::kEnabled, enable()), 0) << std::hex << object.index;
  }
  put(options, Setting::kReceiveTimer, static_cast<double>(ReceiveTimer::kRequired));
  Bench bench(options);
  bench.drive.dictionary().remove(object::kReceiveTimer);
  ASSERT_GT(bench.run_until(DriveCondition::kRefused), 0);
  EXPECT_TRUE(contains(bench.driver.complaint().quantity, "0x1400:5"));
}

TEST(Cia402StartUp, FiguresOfAManualStandWhereTheDriveHasNone) {
  DriveOptions options = bench_options();
  put(options, Setting::kRatedTorqueCheck, static_cast<double>(Check::kManual));
  put(options, Setting::kEncoderCheck, static_cast<double>(Check::kManual));
  put(options, Setting::kGearCheck, static_cast<double>(Check::kManual));
  Bench bench(options);
  for (const Object object : {object::kRatedTorque, object::kEncoderIncrements,
                              object::kEncoderRevolutions, object::kGearMotor}) {
    bench.drive.dictionary().remove(object);
  }
  EXPECT_GT(bench.run_until(DriveCondition::kEnabled, enable()), 0);
}

TEST(Cia402StartUp, AnOldErrorIsClearedOnlyWhenToldTo) {
  Bench bench;
  bench.drive.inject_error(2);
  ASSERT_GT(bench.run_until(DriveCondition::kError), 0);
  bench.run(300);
  EXPECT_EQ(bench.driver.state().condition, DriveCondition::kError);
  EXPECT_EQ(bench.sent_controlwords(control_word::kFaultReset), 0U);
  EXPECT_TRUE(contains(bench.driver.complaint().fix, "clear_errors"));
  DriveOptions options = bench_options();
  options.clear_errors = true;
  Bench clearing(options);
  clearing.drive.inject_error(2);
  ASSERT_GT(clearing.run_until(DriveCondition::kDisabled), 0);
  EXPECT_EQ(clearing.sent_controlwords(control_word::kFaultReset), 1U);
  EXPECT_EQ(clearing.driver.state().error, 0);
  EXPECT_EQ(clearing.driver.complaint().quantity, nullptr);
  EXPECT_GT(clearing.run_until(DriveCondition::kEnabled, enable()), 0);
}

TEST(Cia402StartUp, AnErrorWhoseCauseLastsIsNotClearedForEver) {
  DriveOptions options = bench_options();
  options.clear_errors = true;
  Bench bench(options);
  bench.drive.set_temperature(120.0);
  bench.run(1000);
  EXPECT_EQ(bench.driver.state().condition, DriveCondition::kError);
  EXPECT_EQ(bench.sent_controlwords(control_word::kFaultReset),
            static_cast<std::size_t>(Driver::kMaxClears));
}

TEST(Cia402StartUp, EveryWayToBeginLeadsThere) {
  for (int reset = 0; reset < 3; ++reset) {
    DriveOptions options = bench_options();
    put(options, Setting::kReset, reset);
    Bench bench(options);
    bench.run(5);
    ASSERT_GT(bench.run_until(DriveCondition::kEnabled, enable()), 0) << reset;
    bench.run(5, enable(3.0));
    bench.cycle();
    bench.driver.restart();  // it is enabled: the start-up ends that
    bench.run(5);
    EXPECT_FALSE(bench.drive.enabled());
    bench.drive.power_cycle();
    ASSERT_GT(bench.run_until(DriveCondition::kEnabled, enable(1.0)), 0) << reset;
  }
}

TEST(Cia402StartUp, AnswersToOtherRequestsAreNotTaken) {
  Bench bench;
  bench.run(3);
  for (int i = 0; i < 100; ++i) {  // of a master that asks for something else
    bench.driver.receive({encode_read_reply(3, object::kHomeOffset, 1), bench.now_ns});
    bench.driver.receive({encode_write_reply(3, object::kHomeOffset), bench.now_ns});
    bench.driver.receive({encode_abort(3, object::kHomeOffset, Abort::kNoObject), bench.now_ns});
  }
  EXPECT_GT(bench.run_until(DriveCondition::kDisabled), 0);
}

}  // namespace
}  // namespace geodesic::drivers::cia402::test
