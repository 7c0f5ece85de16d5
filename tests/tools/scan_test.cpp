// `geodesic scan` on simulated drives: who is found, that the proposal loads, that nothing is
// disturbed, and what is said when nobody answers, somebody answers nonsense, or a daemon is there.
#include <gtest/gtest.h>

#include <nlohmann/json.hpp>

#include "config/robot.hpp"
#include "drivers/bus/bus_lock.hpp"
#include "tests/drivers/family_benches.hpp"
#include "tests/tools/simulated_bench.hpp"
#include "tools/geodesic/bench_bus.hpp"
#include "tools/geodesic/scan_proposal.hpp"

namespace geodesic::tools::test {
namespace {

TEST(Scan, FindsDrivesAndProposesARobotThatLoads) {
  const TemporaryFolder folder;
  SimulatedBench bench(folder);
  bench.add(damiao(1));
  bench.add(damiao(0x22));
  bench.add(damiao(3, true));
  bench.start();
  Program scan(folder, {"scan", bench.name(), "--family", "damiao", "--write",
                        (folder / "mine").string(), "--json"});
  ASSERT_EQ(scan.wait(), 0) << scan.err();
  const auto answer = nlohmann::json::parse(scan.out());
  ASSERT_EQ(answer["drives"].size(), 3U);
  EXPECT_EQ(answer["drives"][0]["id"], 1);
  EXPECT_EQ(answer["drives"][1]["reply_id"], 0x32);
  EXPECT_EQ(answer["drives"][1]["fd"], false);
  EXPECT_EQ(answer["drives"][2]["fd"], true);
  EXPECT_EQ(answer["drives"][2]["firmware"], "5016");
  EXPECT_NE(answer["drives"][2]["remarks"].dump().find("classic CAN only"), std::string::npos);
  EXPECT_EQ(answer["complete"], true);
  EXPECT_FALSE(bench.any_enabled());

  const config::LoadResult loaded = config::load_robot(folder / "mine" / "robot.toml");
  std::string messages;
  for (const auto& message : loaded.messages) messages += to_string(message) + "\n";
  ASSERT_TRUE(loaded.ok) << messages << answer["toml"].get<std::string>();
  ASSERT_EQ(loaded.robot.arm.joints.size(), 3U);
  EXPECT_EQ(loaded.robot.arm.joints[1].drive.id, 0x22U);
  EXPECT_EQ(loaded.robot.arm.joints[1].drive.torque_range_nm, 10.0);
  EXPECT_EQ(loaded.robot.arm.buses[0].interface, bench.name());

  Program again(folder, {"scan", bench.name(), "--family", "damiao", "--classic", "--write",
                         (folder / "mine").string()});
  EXPECT_EQ(again.wait(), 1);
  EXPECT_NE(again.err().find("exists already"), std::string::npos) << again.err();
  EXPECT_NE(again.out().find("0x22"), std::string::npos);
}

TEST(Scan, FindsEveryFamilyThatHasAScannerSideBySide) {
  const TemporaryFolder folder;
  SimulatedBench bench(folder);
  bench.add(damiao(1));
  bench.add(damiao(2));
  for (const drivers::test::FamilyBench& other : drivers::test::family_benches()) {
    if (other.name == "robstride") bench.add(other.options);
  }
  bench.start();
  Program scan(
      folder, {"scan", bench.name(), "--classic", "--json", "--write", (folder / "mine").string()});
  ASSERT_EQ(scan.wait(), 0) << scan.err();
  const auto answer = nlohmann::json::parse(scan.out());
  // Nobody takes a drive of another family for one of its own.
  ASSERT_EQ(answer["drives"].size(), 3U) << answer.dump(2);
  EXPECT_EQ(answer["drives"][0]["family"], "damiao");
  EXPECT_EQ(answer["drives"][2]["family"], "robstride");
  EXPECT_TRUE(config::load_robot(folder / "mine" / "robot.toml").ok)
      << answer["toml"].get<std::string>();
  std::size_t scanners = 0;
  for (const drivers::Family& family : drivers::families()) {
    if (family.make_scanner == nullptr || !family.make_scanner(false)) continue;
    ++scanners;
    EXPECT_NE(scan.err().find(std::string(family.name)), std::string::npos);
  }
  EXPECT_GE(scanners, 1U);
  EXPECT_FALSE(bench.any_enabled());
}

TEST(Scan, SaysWhenNobodyAnswersOrNonsenseComes) {
  const TemporaryFolder folder;
  SimulatedBench bench(folder);
  std::uint8_t noise = 1;
  bench.add(damiao(1)).mangle = [&noise](drivers::Frame& frame) {
    for (std::uint8_t& byte : frame.data) byte = noise = static_cast<std::uint8_t>(noise * 37 + 11);
  };
  bench.start();
  Program scan(folder, {"scan", bench.name(), "--family", "damiao", "--classic"});
  EXPECT_EQ(scan.wait(), 1);
  EXPECT_NE(scan.out().find("no drive has answered"), std::string::npos) << scan.out();

  Program nowhere(folder, {"scan", "unix:" + (folder / "none").string()});
  EXPECT_EQ(nowhere.wait(), 1);
  EXPECT_NE(nowhere.err().find("error:"), std::string::npos) << nowhere.err();
  Program unknown(folder, {"scan", bench.name(), "--family", "damia"});
  EXPECT_EQ(unknown.wait(), 1);
  EXPECT_NE(unknown.err().find("did you mean \"damiao\"?"), std::string::npos) << unknown.err();
}

TEST(Scan, LeavesABusAloneThatADaemonCommands) {
  const TemporaryFolder folder;
  SimulatedBench bench(folder);
  bench.add(damiao(1));
  bench.start();
  const drivers::BusLock daemon(bench.name());
  Program scan(folder, {"scan", bench.name()});
  EXPECT_EQ(scan.wait(), 1);
  EXPECT_NE(scan.err().find("is commanded already by process"), std::string::npos) << scan.err();
}

TEST(Scan, EndsByASignalAndTellsWhatItHasFound) {
  const TemporaryFolder folder;
  SimulatedBench bench(folder);
  bench.add(damiao(1));
  bench.start();
  Program scan(folder, {"scan", bench.name(), "--family", "damiao"});
  std::this_thread::sleep_for(std::chrono::milliseconds(400));
  scan.signal(SIGINT);
  EXPECT_EQ(scan.wait(), 1);
  EXPECT_NE(scan.err().find("stopped before the end"), std::string::npos) << scan.err();
  EXPECT_FALSE(bench.any_enabled());
}

TEST(Scan, ListsInterfacesThatAreUp) {
  const TemporaryFolder folder;
  const auto make = [&](const char* name, const char* type, const char* flags, const char* mtu) {
    std::filesystem::create_directories(folder / name);
    std::ofstream(folder / name / "type") << type << "\n";
    std::ofstream(folder / name / "flags") << flags << "\n";
    std::ofstream(folder / name / "mtu") << mtu << "\n";
  };
  make("can1", "280", "0x40081", "72");
  make("can0", "280", "0x40081", "16");
  make("can2", "280", "0x40080", "16");
  make("eth0", "1", "0x1003", "1500");
  EXPECT_EQ(can_interfaces(folder.path()), (std::vector<std::string>{"can0", "can1"}));
  EXPECT_FALSE(carries_fd("can0", folder.path()));
  EXPECT_TRUE(carries_fd("can1", folder.path()));
  EXPECT_TRUE(carries_fd("unix:/tmp/x", folder.path()));
  EXPECT_TRUE(can_interfaces(folder / "nothing").empty());
}

Sighting sighting(const char* family, std::uint32_t id) {
  Sighting one{"can0", family, false, {}};
  one.drive.id = id;
  one.drive.reply_id = id + 0x10;
  one.drive.options = {{"position_range_rad", "12.5"}, {"velocity_range_rad_s", "30"}};
  return one;
}

TEST(ScanProposal, SaysWhatIsMissingAndWhatClashes) {
  std::vector<Sighting> sightings{sighting("damiao", 1), sighting("another", 1)};
  compare(sightings);
  ASSERT_EQ(sightings[0].drive.remarks.size(), 1U);
  EXPECT_NE(sightings[0].drive.remarks[0].find("family another has answered"), std::string::npos);
  sightings.pop_back();
  sightings[0].drive.remarks.emplace_back("two\nlines\" = []");
  const Proposal proposal = propose(sightings);
  EXPECT_NE(proposal.toml.find("# NOTE: two lines\" = []\n"), std::string::npos) << proposal.toml;
  EXPECT_NE(proposal.toml.find("torque_range_nm = 1.0  # not told"), std::string::npos);
  ASSERT_EQ(proposal.gaps.size(), 1U);
  EXPECT_NE(proposal.gaps[0].find("torque_range_nm"), std::string::npos);
  sightings[0].drive.reply_id = 0;
  EXPECT_NE(propose(sightings).toml.find("# WRONG: the drive's reply id"), std::string::npos);
}

}  // namespace
}  // namespace geodesic::tools::test
