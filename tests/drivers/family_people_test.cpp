// What every drive family tells people and tools, each as a test of every family there is: its
// frames in words, its frames in a cycle, its scanner. The rules of driving are
// family_rules_test.cpp's.
#include <gtest/gtest.h>

#include <set>
#include <string>
#include <vector>

#include "tests/drivers/family_benches.hpp"
#include "tests/drivers/family_dialogue.hpp"

namespace geodesic::drivers::test {
namespace {

using control::DriveCondition;
using control::DriveMode;

class FamilyForPeople : public testing::TestWithParam<FamilyBench> {
 protected:
  const FamilyBench& bench() const { return GetParam(); }
  /// @param share  of the most torque.
  DriveCommand enable(double share) const {
    return {.mode = DriveMode::kEnable, .torque_nm = share * bench().options.torque_range_nm};
  }
};

TEST_P(FamilyForPeople, EveryFrameOfADialogueCanBeToldInWords) {
  FamilyDialogue bus(bench().of(), bench().options);
  std::set<std::string> kinds;
  std::size_t untold = 0;
  std::string first;
  bus.witness = [&](const Frame& frame) {
    const auto words = bench().of().decode(frame, bench().options);
    untold += words ? 0U : 1U;
    if (!words && untold == 1) {
      first = testing::PrintToString(frame.id) + " of " + std::to_string(frame.length) + " bytes";
    }
    if (words) {
      kinds.insert(words->kind);
    }
  };
  ASSERT_TRUE(bus.run_until(DriveCondition::kEnabled, enable(0.0))) << bus.why();
  bus.run(20, enable(0.5));
  bus.run(20, {.mode = DriveMode::kDisable});
  EXPECT_EQ(untold, 0U) << "first: identifier " << first;
  EXPECT_GE(kinds.size(), 3U);
}

TEST_P(FamilyForPeople, ACycleIsWhatTheBudgetCounts) {
  const double rate_hz = 1000.0;
  const std::vector<CyclicFrame> declared = bench().of().cyclic_frames(bench().options, rate_hz);
  double commands = 0.0;
  double bytes = 0.0;
  for (const CyclicFrame& frame : declared) {
    commands += frame.reply ? 0.0 : frame.share;
    bytes += frame.reply ? 0.0 : frame.share * frame.bytes;
  }
  FamilyDialogue bus(bench().of(), bench().options);
  ASSERT_TRUE(bus.run_until(DriveCondition::kEnabled, enable(0.0))) << bus.why();
  bus.run(50, enable(0.0));
  double sent = 0.0;
  double sent_bytes = 0.0;
  const std::int64_t from_ns = bus.now_ns;
  bus.witness_sent = [&](const Frame& frame) {
    ++sent;
    sent_bytes += frame.remote ? 0.0 : frame.length;
  };
  bus.run(1000, enable(0.1));
  const double cycles = static_cast<double>(bus.now_ns - from_ns) * 1e-6;
  EXPECT_NEAR(sent / cycles, commands, 0.05 * commands + 0.01);
  EXPECT_NEAR(sent_bytes / cycles, bytes, 0.1 * bytes + 0.1);
}

TEST_P(FamilyForPeople, TheScannerFindsItAndDoesNotTouchIt) {
  const auto scanner = bench().of().make_scanner(bench().options.fd);
  ASSERT_NE(scanner, nullptr);
  FamilyDialogue bus(bench().of(), bench().options);
  bus.shaft(0.5, 0.0);
  bus.hold(*scanner, 60'000);
  ASSERT_TRUE(scanner->over());
  const std::vector<FoundDrive> found = scanner->found();
  ASSERT_EQ(found.size(), 1U);
  EXPECT_EQ(found[0].id, bench().options.id);
  EXPECT_FALSE(bus.simulated().enabled());
  ASSERT_TRUE(bus.run_until(DriveCondition::kDisabled, {})) << bus.why();
  bus.run(20);
  EXPECT_NEAR(bus.drive().state().position_rad, 0.5, 0.02);
}

INSTANTIATE_TEST_SUITE_P(Families, FamilyForPeople, testing::ValuesIn(family_benches()),
                         [](const testing::TestParamInfo<FamilyBench>& tested) {
                           return tested.param.name;
                         });

}  // namespace
}  // namespace geodesic::drivers::test
