// The rules that hold for every drive protocol, each as a test of every family there is: driver and
// simulated drive on a bus in memory, made from the table of benches (family_benches.hpp).
#include <gtest/gtest.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <limits>

#include "rt/heap_counter.hpp"
#include "tests/drivers/family_benches.hpp"
#include "tests/drivers/family_dialogue.hpp"

namespace geodesic::drivers::test {
namespace {

using control::DriveCondition;
using control::DriveMode;

class FamilyRules : public testing::TestWithParam<FamilyBench> {
 protected:
  const FamilyBench& bench() const { return GetParam(); }
  double most() const { return bench().options.torque_range_nm; }

  DriveOptions clearing() const {
    DriveOptions options = bench().options;
    options.clear_errors = true;  // which is for start-up only
    return options;
  }

  static DriveCommand enable(double torque_nm = 0.0) {
    return {.mode = DriveMode::kEnable, .torque_nm = torque_nm};
  }

  bool enabled(FamilyDialogue& bus) const {
    return bench().always_on ? bus.torque_nm() != 0.0 : bus.simulated().enabled();
  }

  /// No torque, and not enabled, though it is commanded to for a second.
  void expect_out(FamilyDialogue& bus) {
    for (int i = 0; i < 1000; ++i) {
      bus.cycle(enable(0.5 * most()));
      ASSERT_EQ(bus.torque_nm(), 0.0) << "cycle " << i;
      ASSERT_FALSE(enabled(bus)) << "cycle " << i;
    }
    if (bench().tells_its_state) {
      EXPECT_NE(bus.condition(), DriveCondition::kEnabled);
    }
  }

  /// A drive may tell of itself every 100 ms only.
  static constexpr int kUntilTold = 300;

  /// After the mode has been another one, and only then, it is configured and enabled anew.
  void expect_back(FamilyDialogue& bus) {
    bus.run(2);
    ASSERT_TRUE(bus.run_until(DriveCondition::kDisabled, {})) << bus.why();
    ASSERT_TRUE(bus.run_until(DriveCondition::kEnabled, enable())) << bus.why();
    bus.run(20, enable(0.4 * most()));
    EXPECT_NEAR(bus.torque_nm(), 0.4 * most(), bench().step_nm);
  }
};

TEST_P(FamilyRules, GoodOptionsPassAndBadOnesAreToldInWords) {
  EXPECT_TRUE(bench().of().check(bench().options).empty());
  for (const double bad : {0.0, -1.0, std::nan(""), std::numeric_limits<double>::infinity()}) {
    DriveOptions options = bench().options;
    options.torque_range_nm = bad;
    const std::vector<std::string> wrong = bench().of().check(options);
    ASSERT_FALSE(wrong.empty()) << "torque range " << bad;
    EXPECT_GT(wrong.front().size(), 20U);
  }
  DriveOptions unwatched = bench().options;
  unwatched.watchdog_ns = 0;
  EXPECT_FALSE(bench().of().check(unwatched).empty()) << "no watchdog";
  DriveOptions nobody = bench().options;
  nobody.id = 0xFFFFFFFF;
  EXPECT_FALSE(bench().of().check(nobody).empty()) << "no such id";
}

TEST_P(FamilyRules, FromPowerOnToTorqueAndBack) {
  FamilyDialogue bus(bench().of(), bench().options);
  bus.shaft(0.7, 0.0);
  EXPECT_EQ(bus.condition(), DriveCondition::kUnknown);
  ASSERT_TRUE(bus.run_until(DriveCondition::kDisabled, {})) << bus.why();
  EXPECT_EQ(bus.drive().complaint().quantity, nullptr);
  bus.run(20);
  EXPECT_FALSE(enabled(bus));
  EXPECT_NEAR(bus.drive().state().position_rad, 0.7, 0.02);
  ASSERT_TRUE(bus.run_until(DriveCondition::kEnabled, enable())) << bus.why();
  EXPECT_NEAR(bus.torque_nm(), 0.0, bench().step_nm);
  bus.run(20, enable(0.5 * most()));
  EXPECT_NEAR(bus.torque_nm(), 0.5 * most(), bench().step_nm);
  EXPECT_EQ(bus.condition(), DriveCondition::kEnabled);
  EXPECT_EQ(bus.drive().state().error, 0);
  bus.run(20, {.mode = DriveMode::kDisable});
  EXPECT_EQ(bus.torque_nm(), 0.0);
  EXPECT_FALSE(enabled(bus));
  bus.run(kUntilTold, {.mode = DriveMode::kDisable});
  EXPECT_EQ(bus.condition(), DriveCondition::kDisabled);
}

TEST_P(FamilyRules, ANonFiniteCommandNeverLeaves) {
  for (const double bad : {std::nan(""), std::numeric_limits<double>::infinity(),
                           -std::numeric_limits<double>::infinity()}) {
    for (double DriveCommand::*member :
         {&DriveCommand::torque_nm, &DriveCommand::position_rad, &DriveCommand::velocity_rad_s,
          &DriveCommand::stiffness_nm_rad, &DriveCommand::damping_nm_s_rad}) {
      FamilyDialogue bus(bench().of(), bench().options);
      ASSERT_TRUE(bus.run_until(DriveCondition::kEnabled, enable())) << bus.why();
      bus.run(5, enable(0.5 * most()));
      DriveCommand command = enable(0.5 * most());
      command.*member = bad;
      for (int i = 0; i < 5; ++i) {
        bus.cycle(command);
        // The shaft stands still: what brakes makes next to nothing.
        ASSERT_NEAR(bus.torque_nm(), 0.0, 2.0 * bench().step_nm);
      }
      ASSERT_NE(bus.drive().complaint().quantity, nullptr);
      EXPECT_TRUE(std::isnan(bus.drive().complaint().found));
    }
  }
}

TEST_P(FamilyRules, CommandsAreClampedAndRoundedToNearest) {
  FamilyDialogue bus(bench().of(), bench().options);
  ASSERT_TRUE(bus.run_until(DriveCondition::kEnabled, enable())) << bus.why();
  bus.run(5, enable());
  for (const double sign : {1.0, -1.0}) {
    bus.run(5, enable(sign * 1e6));
    EXPECT_NEAR(bus.torque_nm(), sign * most(), bench().step_nm);
  }
  double sum = 0.0;
  constexpr int kSamples = 1000;
  for (int i = 0; i < kSamples; ++i) {
    const double wanted = most() * (-0.9 + 1.8 * i / kSamples);
    bus.run(2, enable(wanted));
    const double error = bus.torque_nm() - wanted;
    ASSERT_LE(std::abs(error), 0.6 * bench().step_nm) << wanted;
    sum += error;
  }
  EXPECT_LE(std::abs(sum / kSamples), 0.05 * bench().step_nm);  // truncation: half a code
}

TEST_P(FamilyRules, ScalingIsConfigurationNeverGuessed) {
  for (const double factor : {0.5, 1.3}) {
    DriveOptions options = bench().options;
    options.torque_range_nm *= factor;
    options.velocity_range_rad_s *= factor;
    if (!bench().of().check(options).empty()) {
      continue;  // other options bound it
    }
    FamilyDialogue bus(bench().of(), options);
    ASSERT_TRUE(bus.run_until(DriveCondition::kEnabled, enable())) << bus.why();
    bus.shaft(0.3, 0.25 * options.velocity_range_rad_s);
    bus.run(20, enable(0.25 * options.torque_range_nm));
    EXPECT_NEAR(bus.torque_nm(), 0.25 * options.torque_range_nm, 2.0 * bench().step_nm);
  }
}

TEST_P(FamilyRules, ADriveThatContradictsTheConfigurationIsRefusedBeforeAnyTorque) {
  if (bench().contradict == nullptr) {
    EXPECT_EQ(bench().options.family, "cubemars") << "the only one that tells nothing of itself";
    return;
  }
  DriveOptions other = bench().options;
  bench().contradict(other);
  FamilyDialogue bus(bench().of(), bench().options, other);
  ASSERT_TRUE(bus.run_until(DriveCondition::kRefused, {})) << bus.why();
  const DriveComplaint complaint = bus.drive().complaint();
  ASSERT_NE(complaint.quantity, nullptr);
  EXPECT_NE(complaint.fix, nullptr);
  EXPECT_FALSE(complaint.found == complaint.expected) << complaint.quantity;
  expect_out(bus);
  EXPECT_EQ(bus.condition(), DriveCondition::kRefused);
}

TEST_P(FamilyRules, RestartForgets) {
  DriveOptions other = bench().options;
  if (bench().contradict != nullptr) {
    bench().contradict(other);
    FamilyDialogue bus(bench().of(), bench().options, other);
    ASSERT_TRUE(bus.run_until(DriveCondition::kRefused, {}));
    bus.exchange(bench().options);
    bus.run(200);
    EXPECT_EQ(bus.condition(), DriveCondition::kRefused);
    bus.drive().restart();
    EXPECT_EQ(bus.condition(), DriveCondition::kUnknown);
    EXPECT_EQ(bus.drive().complaint().quantity, nullptr);
    EXPECT_TRUE(bus.run_until(DriveCondition::kDisabled, {})) << bus.why();
  }
  FamilyDialogue bus(bench().of(), clearing());
  ASSERT_TRUE(bus.run_until(DriveCondition::kEnabled, enable())) << bus.why();
  bus.cycle(enable(std::nan("")));
  EXPECT_NE(bus.drive().complaint().quantity, nullptr);
  bus.drive().restart();
  EXPECT_EQ(bus.condition(), DriveCondition::kUnknown);
  EXPECT_EQ(bus.drive().complaint().quantity, nullptr);
  // It may still run for as long as it takes to tell it; then it stays out.
  bus.run(200, enable(0.5 * most()));
  expect_out(bus);
  expect_back(bus);
}

TEST_P(FamilyRules, SilenceIsNoticed) {
  FamilyDialogue bus(bench().of(), bench().options);
  bus.cut = true;
  std::size_t sent = 0;
  for (int i = 0; i < 1000; ++i) {
    bus.cycle({});
    sent += bus.frames;
  }
  EXPECT_TRUE(sent >= 2 || bus.drive().speaks_unasked()) << "what is not answered is asked again";
  EXPECT_EQ(bus.condition(), DriveCondition::kUnknown);
  bus.cut = false;
  ASSERT_TRUE(bus.run_until(DriveCondition::kEnabled, enable())) << bus.why();
  bus.run(20, enable());
  const std::int64_t last_ns = bus.drive().state().stamp_ns;
  EXPECT_LT(bus.now_ns - last_ns, 25'000'000);
  bus.deaf = true;  // it hears us, we do not hear it
  for (int i = 0; i < 50; ++i) {
    bus.cycle(enable());
    EXPECT_FALSE(bus.reported);
  }
  EXPECT_LE(bus.drive().state().stamp_ns, last_ns + 1'000'000);
}

TEST_P(FamilyRules, TheDrivesOwnWatchdogIsSetAndWorks) {
  FamilyDialogue bus(bench().of(), bench().options);
  ASSERT_TRUE(bus.run_until(DriveCondition::kEnabled, enable())) << bus.why();
  bus.run(10, enable(0.5 * most()));
  bus.cut = true;
  const int cycles = static_cast<int>(bench().options.watchdog_ns / 1'000'000);
  for (int i = 0; i < cycles / 2; ++i) {
    bus.cycle(enable(0.5 * most()));
    ASSERT_NEAR(bus.torque_nm(), 0.5 * most(), bench().step_nm) << "too early, cycle " << i;
  }
  bus.run(cycles, enable(0.5 * most()));
  EXPECT_EQ(bus.torque_nm(), 0.0);
}

TEST_P(FamilyRules, AfterTheWatchdogTorqueDoesNotComeBackByItself) {
  FamilyDialogue bus(bench().of(), clearing());
  ASSERT_TRUE(bus.run_until(DriveCondition::kEnabled, enable())) << bus.why();
  bus.run(10, enable(0.5 * most()));
  bus.cut = true;
  bus.run(200, enable(0.5 * most()));
  bus.cut = false;
  bus.run(2, enable(0.5 * most()));
  expect_out(bus);
  expect_back(bus);
}

TEST_P(FamilyRules, AfterAFaultTorqueDoesNotComeBackByItself) {
  FamilyDialogue bus(bench().of(), clearing());
  ASSERT_TRUE(bus.run_until(DriveCondition::kEnabled, enable())) << bus.why();
  bus.run(10, enable(0.5 * most()));
  bus.simulated().inject_error(bench().error);
  bus.run(kUntilTold, enable(0.5 * most()));
  EXPECT_EQ(bus.condition(), DriveCondition::kError);
  EXPECT_NE(bus.drive().state().error, 0);
  EXPECT_STRNE(bench().of().error_name(bus.drive().state().error), "unknown error");
  expect_out(bus);
  if (!bench().clears_errors) {
    bus.simulated().power_cycle();
    expect_out(bus);
  }
  expect_back(bus);
}

TEST_P(FamilyRules, AnOldErrorIsClearedOnlyWhereThatIsAllowed) {
  FamilyDialogue kept(bench().of(), bench().options);
  kept.simulated().inject_error(bench().error);
  ASSERT_TRUE(kept.run_until(DriveCondition::kError, {})) << kept.why();
  expect_out(kept);
  EXPECT_EQ(kept.condition(), DriveCondition::kError);
  EXPECT_NE(kept.drive().complaint().quantity, nullptr);
  if (!bench().clears_errors) {
    return;
  }
  FamilyDialogue cleared(bench().of(), clearing());
  cleared.simulated().inject_error(bench().error);
  EXPECT_TRUE(cleared.run_until(DriveCondition::kDisabled, {})) << cleared.why();
}

TEST_P(FamilyRules, APowerCycleIsALossAndEverythingIsSetAnew) {
  FamilyDialogue bus(bench().of(), clearing());
  ASSERT_TRUE(bus.run_until(DriveCondition::kEnabled, enable())) << bus.why();
  bus.run(10, enable(0.5 * most()));
  bus.cut = true;  // the supply is gone for as long as a capacitor lasts at least
  bus.run(150, enable(0.5 * most()));
  bus.simulated().power_cycle();
  bus.cut = false;
  expect_out(bus);
  expect_back(bus);
  bus.cut = true;  // its watchdog too
  bus.run(200, enable(0.5 * most()));
  EXPECT_EQ(bus.torque_nm(), 0.0);
}

TEST_P(FamilyRules, AtPowerOnOnlyWholePeriodsOfPositionAreLost) {
  const double period = bench().of().position_period_rad(bench().options);
  ASSERT_TRUE(std::isfinite(period) && period >= 0.0);
  for (const double shaft : {0.4, 7.3, -5.1}) {
    FamilyDialogue bus(bench().of(), bench().options);
    ASSERT_TRUE(bus.run_until(DriveCondition::kDisabled, {})) << bus.why();
    bus.shaft(shaft, 0.0);
    bus.simulated().power_cycle();
    bus.drive().restart();
    ASSERT_TRUE(bus.run_until(DriveCondition::kDisabled, {})) << bus.why();
    bus.run(30);
    const double off = bus.drive().state().position_rad - shaft;
    EXPECT_NEAR(period > 0.0 ? std::remainder(off, period) : off, 0.0, 0.02) << shaft;
  }
}

TEST_P(FamilyRules, NoCommandIsASpecialFrameByAccident) {
  FamilyDialogue bus(bench().of(), bench().options);
  bus.shaft(0.2, 0.0);
  ASSERT_TRUE(bus.run_until(DriveCondition::kEnabled, enable())) << bus.why();
  bus.run(5, enable());
  const double step = std::max(bench().step_nm, most() / 4096.0);
  for (const double end : {1.0, -1.0}) {
    for (int i = -4; i < 40; ++i) {
      DriveCommand command = enable(end * (most() - 0.5 * i * step));
      command.position_rad = end * 1e3;
      command.velocity_rad_s = end * 1e3;
      command.stiffness_nm_rad = i % 2 == 0 ? 1e6 : 0.0;
      command.damping_nm_s_rad = i % 2 == 0 ? 1e6 : 0.0;
      bus.cycle(command);
      ASSERT_TRUE(bus.simulated().enabled()) << i;
      ASSERT_EQ(bus.condition(), DriveCondition::kEnabled) << i;
      ASSERT_EQ(bus.drive().state().error, 0) << i;
    }
  }
  bus.run(20, enable());
  EXPECT_NEAR(bus.drive().state().position_rad, 0.2, 0.02) << "its zero was moved";
}

TEST_P(FamilyRules, NothingAllocatesOnceBuilt) {
  FamilyDialogue bus(bench().of(), clearing());
  const std::uint64_t calls = rt::heap_calls();
  const bool enabled = bus.run_until(DriveCondition::kEnabled, enable());
  bus.run(20, enable(0.5 * most()));
  bus.cycle(enable(std::nan("")));
  bus.simulated().inject_error(bench().error);
  bus.run(50, enable(0.5 * most()));
  bus.drive().restart();
  bus.run(500);
  EXPECT_EQ(rt::heap_calls(), calls);
  EXPECT_TRUE(enabled);
}

std::string bench_name(const testing::TestParamInfo<FamilyBench>& tested) {
  return tested.param.name;
}

INSTANTIATE_TEST_SUITE_P(Families, FamilyRules, testing::ValuesIn(family_benches()), bench_name);

TEST(FamilyBenches, EveryFamilyHasOne) {
  const std::vector<FamilyBench> all = family_benches();
  for (const Family& family : families()) {
    EXPECT_TRUE(std::any_of(all.begin(), all.end(),
                            [&](const FamilyBench& bench) { return bench.family == family.name; }))
        << family.name << " has no entry in tests/drivers/family_benches.hpp";
  }
}

}  // namespace
}  // namespace geodesic::drivers::test
