// `geodesic zero` on a simulated drive: asks, writes, reads back, records; and refuses before it
// writes.
#include <gtest/gtest.h>

#include <nlohmann/json.hpp>
#include <regex>
#include <sstream>

#include "drivers/bus/bus_lock.hpp"
#include "drivers/damiao/codec.hpp"
#include "tests/tools/simulated_bench.hpp"
#include "tools/geodesic/zero_record.hpp"

namespace geodesic::tools::test {
namespace {

std::vector<nlohmann::json> lines_of(const std::filesystem::path& file) {
  std::vector<nlohmann::json> lines;
  std::istringstream text(read_text(file));
  for (std::string line; std::getline(text, line);) lines.push_back(nlohmann::json::parse(line));
  return lines;
}

TEST(Zero, AsksWritesReadsBackAndRecords) {
  const TemporaryFolder folder;
  SimulatedBench bench(folder);
  bench.add(damiao(1)).position = 1.5;
  BenchDrive& two = bench.add(damiao(2));
  two.position = -0.75;
  bench.start();
  const std::string robot = bench_robot(folder, bench.name());
  {
    Program zero(folder, {"zero", robot, "joint2"});
    zero.say("yes\n");
    ASSERT_EQ(zero.wait(), 0) << zero.err();
    EXPECT_NE(zero.out().find("Type yes"), std::string::npos);
    EXPECT_NE(zero.out().find("before -0.75"), std::string::npos) << zero.out();
  }
  const auto first = lines_of(folder / "robot.zeros.jsonl");
  ASSERT_EQ(first.size(), 1U);
  EXPECT_EQ(first[0]["joint"], "joint2");
  EXPECT_EQ(first[0]["drive_id"], 2);
  EXPECT_EQ(first[0]["done"], true);
  EXPECT_NEAR(first[0]["before_rad"], -0.75, 1e-3);
  EXPECT_NEAR(first[0]["after_rad"], 0.0, 2e-3);
  EXPECT_TRUE(
      std::regex_match(first[0]["when"].get<std::string>(), std::regex("20..-..-..T..:..:..Z")));
  EXPECT_NE(first[0]["who"].get<std::string>().find('@'), std::string::npos);
  EXPECT_EQ(first[0]["interface"], bench.name());

  Program again(folder, {"zero", robot, "joint1", "--yes", "--json"});
  ASSERT_EQ(again.wait(), 0) << again.err();
  EXPECT_EQ(nlohmann::json::parse(again.out())["joint"], "joint1");
  EXPECT_EQ(lines_of(folder / "robot.zeros.jsonl").size(), 2U);
  EXPECT_FALSE(bench.any_enabled());
}

TEST(Zero, WritesNothingWithoutAYes) {
  const TemporaryFolder folder;
  SimulatedBench bench(folder);
  BenchDrive& one = bench.add(damiao(1));
  one.position = 0.5;
  bench.start();
  const std::string robot = bench_robot(folder, bench.name(), 1);
  for (const char* answer : {"y\n", "no\n", "\n", ""}) {
    Program zero(folder, {"zero", robot, "joint1"});
    zero.say(answer);
    zero.end_input();
    EXPECT_EQ(zero.wait(), 1);
    EXPECT_NE(zero.err().find("nothing was written"), std::string::npos) << zero.err();
  }
  {
    Program interrupted(folder, {"zero", robot, "joint1"});
    std::this_thread::sleep_for(std::chrono::milliseconds(300));
    interrupted.signal(SIGINT);
    EXPECT_EQ(interrupted.wait(), 1000 + SIGINT);
  }
  EXPECT_EQ(read_text(folder / "robot.zeros.jsonl"), "");
  std::array<drivers::Frame, 4> replies;
  bench.with([&] {
    one.drive->receive(drivers::damiao::encode_state_request(1, false), rt::now_ns(), replies);
  });
  const auto state = drivers::damiao::decode_report(replies[0], {12.5, 30.0, 10.0});
  ASSERT_TRUE(state);
  EXPECT_NEAR(state->position_rad, 0.5, 1e-3);
}

TEST(Zero, RecordsWhatADriveHasRefused) {
  const TemporaryFolder folder;
  SimulatedBench bench(folder);
  BenchDrive& one = bench.add(damiao(1));
  one.drive->inject_error(0x9);
  bench.start();
  const std::string robot = bench_robot(folder, bench.name(), 2);
  Program zero(folder, {"zero", robot, "joint1", "--yes"});
  EXPECT_EQ(zero.wait(), 1);
  EXPECT_NE(zero.err().find("under-voltage"), std::string::npos) << zero.err();
  Program silent(folder, {"zero", robot, "joint2", "--yes"});
  EXPECT_EQ(silent.wait(), 1);
  EXPECT_NE(silent.err().find("does not answer"), std::string::npos) << silent.err();
  const auto lines = lines_of(folder / "robot.zeros.jsonl");
  ASSERT_EQ(lines.size(), 2U);
  EXPECT_EQ(lines[0]["done"], false);
  EXPECT_TRUE(lines[1]["before_rad"].is_null());
}

TEST(Zero, RefusesBadCallsAndACommandedBus) {
  const TemporaryFolder folder;
  SimulatedBench bench(folder);
  bench.add(damiao(1));
  bench.start();
  const std::string robot = bench_robot(folder, bench.name(), 2);
  Program unknown(folder, {"zero", robot, "joint7", "--yes"});
  EXPECT_EQ(unknown.wait(), 1);
  EXPECT_NE(unknown.err().find("joints: joint1, joint2"), std::string::npos) << unknown.err();
  Program nothing(folder, {"zero", robot});
  EXPECT_EQ(nothing.wait(), 2);
  const drivers::BusLock daemon(bench.name());
  Program locked(folder, {"zero", robot, "joint1", "--yes"});
  EXPECT_EQ(locked.wait(), 1);
  EXPECT_NE(locked.err().find("is commanded already"), std::string::npos) << locked.err();
  EXPECT_EQ(read_text(folder / "robot.zeros.jsonl"), "");
}

TEST(ZeroRecord, RefusesAPlaceItCannotWriteTo) {
  EXPECT_EQ(zero_record_file("arm/robot.toml"), "arm/robot.zeros.jsonl");
  EXPECT_ANY_THROW(prepare_record("/nonexistent/robot.zeros.jsonl"));
  ZeroRecord record;
  record.report = "broken \xff text\n";
  record.before_rad = std::nan("");
  const std::string line = to_json_line(record);
  EXPECT_EQ(std::count(line.begin(), line.end(), '\n'), 1);
  EXPECT_TRUE(nlohmann::json::parse(line)["before_rad"].is_null());
}

}  // namespace
}  // namespace geodesic::tools::test
