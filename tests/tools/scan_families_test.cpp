// What scanning and zeroing promise, held against every family there is, in memory: each finds its
// own drives and nobody else's, moves and enables nothing, and the proposal has no error in it.
#include <gtest/gtest.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <memory>
#include <string>
#include <vector>

#include "tests/drivers/family_benches.hpp"
#include "tools/geodesic/scan_proposal.hpp"

namespace geodesic::tools::test {
namespace {

using drivers::test::FamilyBench;

/// Drives side by side on one bus; time goes by in steps of half a millisecond, as BenchBus'
/// pauses.
struct Shelf {
  void add(const FamilyBench& bench) {
    drives.push_back(bench.of().make_simulated(bench.options));
    drives.back()->set_shaft(0.3, 0.0);
  }

  /// @return it came to its end within a minute.
  bool hold(drivers::BenchDialogue& dialogue) {
    for (int i = 0; i < 120'000 && !dialogue.over(); ++i) {
      now_ns += 500'000;
      std::array<drivers::Frame, drivers::SimulatedDrive::kMaxReplies> said;
      const std::optional<drivers::Frame> asked = dialogue.transmit(now_ns);
      for (auto& drive : drives) {
        const std::size_t answers = asked ? drive->receive(*asked, now_ns + 100'000, said) : 0;
        for (std::size_t k = 0; k < answers; ++k) dialogue.receive({said[k], now_ns + 200'000});
        const std::size_t spoken = drive->speak(now_ns + 300'000, said);
        for (std::size_t k = 0; k < spoken; ++k) dialogue.receive({said[k], now_ns + 300'000});
        EXPECT_FALSE(drive->enabled());
        EXPECT_EQ(drive->torque_nm(now_ns + 400'000), 0.0);
      }
    }
    return dialogue.over();
  }

  std::vector<std::unique_ptr<drivers::SimulatedDrive>> drives;
  std::int64_t now_ns = 1'000'000'000;
};

std::vector<drivers::FoundDrive> scan(Shelf& shelf, const drivers::Family& family, bool fd) {
  const std::unique_ptr<drivers::Scanner> scanner = family.make_scanner(fd);
  if (!scanner) return {};
  EXPECT_TRUE(shelf.hold(*scanner)) << family.name;
  return scanner->found();
}

TEST(ScanFamilies, EachFindsItsOwnAndNobodyElses) {
  for (const FamilyBench& bench : drivers::test::family_benches()) {
    SCOPED_TRACE(bench.name);
    for (const drivers::Family& family : drivers::families()) {
      ASSERT_NE(family.make_scanner, nullptr) << family.name;
      Shelf shelf;
      shelf.add(bench);
      const auto found = scan(shelf, family, bench.options.fd);
      if (family.name != bench.family) {
        EXPECT_TRUE(found.empty()) << "a " << family.name << " scanner took it for its own";
        continue;
      }
      ASSERT_EQ(found.size(), 1U);
      EXPECT_EQ(found[0].id, bench.options.id);
      if (bench.options.reply_id != 0) {
        EXPECT_EQ(found[0].reply_id, bench.options.reply_id);
      }
      const Proposal proposal =
          propose({Sighting{"can0", std::string(bench.family), bench.options.fd, found[0]}});
      EXPECT_EQ(proposal.toml.find("# WRONG"), std::string::npos) << proposal.toml;
      EXPECT_EQ(proposal.toml.find("# REQUIRED"), std::string::npos) << proposal.toml;
    }
  }
}

TEST(ScanFamilies, FindsAllOfThemOnOneBus) {
  Shelf shelf;
  std::vector<FamilyBench> crowd;
  std::uint32_t id = 3;
  for (FamilyBench bench : drivers::test::family_benches()) {
    const bool taken = std::any_of(crowd.begin(), crowd.end(), [&](const FamilyBench& one) {
      return one.family == bench.family;
    });
    // A family without identifiers of its own in its answers cannot share a bus of classic ids.
    if (taken || bench.options.fd || bench.family == "cubemars") continue;
    bench.options.id = bench.family == "cia402" ? 3 : ++id;
    if (bench.options.reply_id != 0) bench.options.reply_id = bench.options.id + 0x10;
    shelf.add(bench);
    crowd.push_back(bench);
  }
  ASSERT_GE(crowd.size(), 2U);
  for (const FamilyBench& bench : crowd) {
    const auto found = scan(shelf, bench.of(), false);
    ASSERT_EQ(found.size(), 1U) << bench.name;
    EXPECT_EQ(found[0].id, bench.options.id) << bench.name;
  }
}

TEST(ScanFamilies, ZerosAreSetReadBackAndRecorded) {
  for (const FamilyBench& bench : drivers::test::family_benches()) {
    SCOPED_TRACE(bench.name);
    ASSERT_NE(bench.of().make_zeroing, nullptr);
    Shelf shelf;
    shelf.add(bench);
    const auto zeroing = bench.of().make_zeroing(bench.options);
    if (!zeroing) continue;  // not over the bus: `geodesic zero` says so
    ASSERT_TRUE(shelf.hold(*zeroing));
    EXPECT_FALSE(zeroing->report().empty());
    if (bench.name == "odrive_05") {  // that firmware forgets a zero: refused, with what to do
      EXPECT_FALSE(zeroing->done());
      EXPECT_NE(zeroing->report().find("offset"), std::string::npos) << zeroing->report();
      continue;
    }
    EXPECT_TRUE(zeroing->done()) << zeroing->report();
    if (!std::isnan(zeroing->before_rad())) {
      EXPECT_NEAR(zeroing->before_rad(), 0.3, 0.02);
    }
    if (!std::isnan(zeroing->after_rad())) {
      EXPECT_NEAR(zeroing->after_rad(), 0.0, 0.02);
    }
    // Nobody there: it ends by itself, and says so.
    Shelf empty;
    const auto alone = bench.of().make_zeroing(bench.options);
    ASSERT_TRUE(empty.hold(*alone));
    EXPECT_FALSE(alone->done());
    EXPECT_FALSE(alone->report().empty());
  }
}

}  // namespace
}  // namespace geodesic::tools::test
