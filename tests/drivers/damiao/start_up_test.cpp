// The start-up dialogue against the simulated drive: what it reads, writes, refuses and survives.
#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <cstring>
#include <set>
#include <string>

#include "tests/drivers/damiao/bench.hpp"

namespace geodesic::drivers::damiao::test {
namespace {

using control::DriveCondition;

TEST(DamiaoStartUp, ConfiguresADriveAndEndsDisabled) {
  Bench bench;
  bench.drive.set_shaft(1.0, 0.0);
  EXPECT_EQ(bench.driver.state().condition, DriveCondition::kUnknown);
  bench.cycle();
  EXPECT_EQ(bench.driver.state().condition, DriveCondition::kConfiguring);
  const int cycles = bench.run_until(DriveCondition::kDisabled);
  EXPECT_GT(cycles, 8);
  EXPECT_LT(cycles, 20);
  EXPECT_EQ(bench.driver.complaint().quantity, nullptr);
  EXPECT_EQ(bench.drive.register_raw(9), 1000U);  // 50 ms in 50 µs
  EXPECT_EQ(bench.sent_writes(), 1U);             // CTRL_MODE was right, so it is left alone
  EXPECT_EQ(bench.driver.firmware(), bench.drive.register_raw(14));
  EXPECT_EQ(bench.sent_special(Special::kEnable), 0U);
  EXPECT_NEAR(bench.driver.state().position_rad, 1.0, 4e-4);
  for (const RegisterFact& fact : kRegisters) {
    const std::uint8_t number = fact.number;
    const std::set<std::uint8_t> read_once{21, 22, 23, 7, 8, 10, 14};
    const long expected = number == 9 ? 2 : (read_once.contains(number) ? 1 : 0);
    const Frame read = encode_read(bench.options.id, false, number);
    EXPECT_EQ(std::count(bench.sent.begin(), bench.sent.end(), read), expected);
  }
}

TEST(DamiaoStartUp, WritesMitModeWhereTheDriveIsInAnother) {
  Bench bench;
  bench.drive.set_register(10, 3);
  ASSERT_GT(bench.run_until(DriveCondition::kDisabled), 0);
  EXPECT_EQ(bench.drive.register_raw(10), 1U);
  EXPECT_EQ(bench.sent_writes(), 2U);
}

TEST(DamiaoStartUp, SpeaksFdToAnFdDrive) {
  DriveOptions options = bench_options();
  options.fd = true;
  Bench bench(options);
  ASSERT_GT(bench.run_until(DriveCondition::kDisabled), 0);
  for (const Frame& frame : bench.sent) {
    EXPECT_TRUE(frame.fd && frame.bit_rate_switch);
  }
}

TEST(DamiaoStartUp, EveryMismatchIsRefusedByTheNameOfItsRegister) {
  struct Case {
    std::uint8_t number;
    std::uint32_t raw;
    double found;
    double expected;
    const char* name;
  };
  const double nan = std::nan("");
  for (const Case& one : {Case{21, Bench::raw(12.566), 12.566, 12.5, "PMAX (register 21)"},
                          Case{22, Bench::raw(8.0), 8.0, 30.0, "VMAX (register 22)"},
                          Case{23, Bench::raw(28.0), 28.0, 10.0, "TMAX (register 23)"},
                          Case{23, Bench::raw(nan), nan, 10.0, "TMAX (register 23)"}}) {
    Bench bench;
    bench.drive.set_register(one.number, one.raw);
    ASSERT_GT(bench.run_until(DriveCondition::kRefused), 0) << one.name;
    const DriveComplaint& complaint = bench.driver.complaint();
    ASSERT_NE(complaint.quantity, nullptr);
    EXPECT_EQ(std::string(complaint.quantity).rfind(one.name, 0), 0U) << complaint.quantity;
    EXPECT_TRUE(std::isnan(one.found) ? std::isnan(complaint.found)
                                      : std::abs(complaint.found - one.found) < 1e-5);
    EXPECT_EQ(complaint.expected, one.expected);
    EXPECT_NE(complaint.fix, nullptr);
    bench.run(200, enable(1.0));
    EXPECT_EQ(bench.driver.state().condition, DriveCondition::kRefused);
    EXPECT_EQ(bench.sent_special(Special::kEnable), 0U);
    EXPECT_EQ(bench.sent_writes(), 0U);
  }
}

/// A drive that stores something else than it is told, or says so of its identifiers.
class Liar {
 public:
  Liar(std::uint8_t number, std::uint32_t raw) : number_(number), raw_(raw) {}

  void cycle(Bench& bench) const {
    bench.now_ns += Bench::kPeriodNs;
    std::array<Frame, 2> out;
    const std::size_t frames = bench.driver.transmit({}, bench.now_ns, out);
    for (std::size_t i = 0; i < frames; ++i) {
      std::array<Frame, 1> reply;
      if (bench.drive.receive(out[i], bench.now_ns, reply) == 1) {
        if (out[i].id == kRegisterId && out[i].data[2] != 0xCC && out[i].data[3] == number_) {
          std::memcpy(&reply[0].data[4], &raw_, 4);
        }
        bench.driver.receive({reply[0], bench.now_ns});
      }
    }
  }

 private:
  std::uint8_t number_;
  std::uint32_t raw_;
};

TEST(DamiaoStartUp, WrongIdentifiersAndUnkeptSettingsAreRefused) {
  struct Case {
    std::uint8_t number;
    double expected;
    const char* name;
  };
  for (const Case& one :
       {Case{7, 0x15, "MST_ID (register 7)"}, Case{8, 0x05, "ESC_ID (register 8)"},
        Case{9, 1000, "TIMEOUT (register 9)"}, Case{10, 1, "CTRL_MODE (register 10)"}}) {
    Bench bench;
    const Liar liar(one.number, 0x77);
    for (int i = 0; i < 50; ++i) {
      liar.cycle(bench);
    }
    EXPECT_EQ(bench.driver.state().condition, DriveCondition::kRefused) << one.name;
    ASSERT_NE(bench.driver.complaint().quantity, nullptr);
    EXPECT_EQ(std::string(bench.driver.complaint().quantity).rfind(one.name, 0), 0U);
    EXPECT_EQ(bench.driver.complaint().found, 0x77);
    EXPECT_EQ(bench.driver.complaint().expected, one.expected);
  }
}

TEST(DamiaoStartUp, RangesMayDifferByRounding) {
  DriveOptions options = bench_options();
  options.position_range_rad = 12.566;
  Bench bench(options);
  bench.drive.set_register(21, Bench::raw(12.566371));
  EXPECT_GT(bench.run_until(DriveCondition::kDisabled), 0);
}

TEST(DamiaoStartUp, OneRequestAtATimeRepeatedAfterItsTimeOut) {
  Bench bench;
  bench.cut = true;
  bench.run(100);
  EXPECT_EQ(bench.sent.size(), 5U);
  EXPECT_EQ(bench.driver.state().condition, DriveCondition::kUnknown);
  bench.cut = false;
  EXPECT_GT(bench.run_until(DriveCondition::kDisabled), 0);
}

TEST(DamiaoStartUp, LostAnswersDelayAndLateOnesDoNotMislead) {
  Bench bench;
  bench.drive.set_shaft(1.0, 0.0);
  int i = 0;
  while (bench.driver.state().condition != DriveCondition::kDisabled && i < 1000) {
    bench.deaf = i % 3 != 0;  // two of three answers are lost
    bench.cycle();
    if (!bench.sent.empty() && i % 3 == 1) {
      std::array<Frame, 1> late;
      if (bench.drive.receive(bench.sent.back(), bench.now_ns, late) == 1) {
        bench.driver.receive({late[0], bench.now_ns + 400'000});
        bench.driver.receive({late[0], bench.now_ns + 500'000});
      }
    }
    if (bench.driver.state().stamp_ns != 0) {
      EXPECT_NEAR(bench.driver.state().position_rad, 1.0, 4e-4);
    }
    ++i;
  }
  EXPECT_EQ(bench.driver.state().condition, DriveCondition::kDisabled);
}

TEST(DamiaoStartUp, ARegisterThatIsNeverAnsweredIsRefusedByName) {
  Bench bench;
  bench.run(2);  // the status, then the first register
  for (int i = 0; i < 30 * 20; ++i) {
    bench.now_ns += Bench::kPeriodNs;
    std::array<Frame, 2> out;
    bench.driver.transmit({}, bench.now_ns, out);
  }
  EXPECT_EQ(bench.driver.state().condition, DriveCondition::kRefused);
  ASSERT_NE(bench.driver.complaint().quantity, nullptr);
  EXPECT_NE(std::string(bench.driver.complaint().quantity).find("register"), std::string::npos);
}

TEST(DamiaoStartUp, ADriveLeftEnabledByAnotherIsDisabledFirst) {
  Bench bench;
  std::array<Frame, 1> reply;
  bench.drive.receive(encode_special(5, false, Special::kEnable), bench.now_ns, reply);
  ASSERT_TRUE(bench.drive.enabled());
  bench.run(2);
  EXPECT_FALSE(bench.drive.enabled());
  EXPECT_GT(bench.run_until(DriveCondition::kDisabled), 0);
}

TEST(DamiaoStartUp, AnErrorIsReportedAndLeftWhereItIsNotToBeCleared) {
  Bench bench;
  bench.drive.inject_error(13);
  ASSERT_GT(bench.run_until(DriveCondition::kError), 0);
  bench.run(100, enable());
  EXPECT_EQ(bench.driver.state().condition, DriveCondition::kError);
  EXPECT_EQ(bench.driver.state().error, 13);
  EXPECT_NE(bench.driver.complaint().quantity, nullptr);
  EXPECT_EQ(bench.sent_special(Special::kClearError), 0U);
  EXPECT_EQ(bench.sent_special(Special::kEnable), 0U);
  EXPECT_EQ(bench.frames, 1U);  // keeps asking, and reporting
  EXPECT_TRUE(bench.reported);
  bench.drive.power_cycle();  // as the complaint advises
  EXPECT_GT(bench.run_until(DriveCondition::kDisabled), 0);
  EXPECT_EQ(bench.driver.complaint().quantity, nullptr);
}

TEST(DamiaoStartUp, AnErrorIsClearedWhereThatIsAllowedAndTheCauseIsGone) {
  DriveOptions options = bench_options();
  options.clear_errors = true;
  Bench gone(options);
  gone.drive.inject_error(9);
  EXPECT_GT(gone.run_until(DriveCondition::kDisabled), 0);
  EXPECT_EQ(gone.sent_special(Special::kClearError), 1U);

  Bench stays(options);
  stays.drive.set_temperature(150.0);
  ASSERT_GT(stays.run_until(DriveCondition::kError), 0);
  stays.run(500);
  EXPECT_EQ(stays.sent_special(Special::kClearError),
            static_cast<std::size_t>(StartUp::kMaxClears));
  EXPECT_EQ(stays.driver.state().error, 12);
}

TEST(DamiaoStartUp, RestartBeginsAgainAfterARefusal) {
  Bench bench;
  bench.drive.set_register(23, Bench::raw(28.0));
  ASSERT_GT(bench.run_until(DriveCondition::kRefused), 0);
  bench.drive.set_register(23, Bench::raw(10.0));
  bench.driver.restart();
  EXPECT_EQ(bench.driver.state().condition, DriveCondition::kUnknown);
  EXPECT_EQ(bench.driver.complaint().quantity, nullptr);
  EXPECT_GT(bench.run_until(DriveCondition::kDisabled), 0);
}

}  // namespace
}  // namespace geodesic::drivers::damiao::test
