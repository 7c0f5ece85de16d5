// `geodesic jog` on simulated drives: what the drive really gets while somebody asks, when nobody
// asks any more, and when the program is interrupted or killed.
#include <gtest/gtest.h>

#include <nlohmann/json.hpp>
#include <sstream>

#include "drivers/bus/bus_lock.hpp"
#include "tests/tools/simulated_bench.hpp"

namespace geodesic::tools::test {
namespace {

std::vector<nlohmann::json> lines_of(const Program& program) {
  std::vector<nlohmann::json> lines;
  std::istringstream text(program.out());
  for (std::string line; std::getline(text, line);) lines.push_back(nlohmann::json::parse(line));
  return lines;
}

struct JogBench {
  JogBench() : bench(folder) {
    one = &bench.add(damiao(1));
    two = &bench.add(damiao(2));
    bench.start();
    robot = bench_robot(folder, bench.name());
  }
  /// Says a line every 50 ms until `what` holds.
  bool say_until(Program& jog, const std::string& line, const std::function<bool()>& what) {
    for (int i = 0; i < 200; ++i) {
      jog.say(line);
      if (bench.comes(what, 50)) return true;
    }
    return false;
  }
  TemporaryFolder folder;
  SimulatedBench bench;
  BenchDrive* one = nullptr;
  BenchDrive* two = nullptr;
  std::string robot;
};

TEST(Jog, PushesWhileAskedAndLetsGoAfterwards) {
  JogBench b;
  Program jog(b.folder,
              {"jog", b.robot, "joint1", "--torque", "0.4", "--velocity", "0.5", "--json"});
  ASSERT_TRUE(b.say_until(jog, "+\n", [&] { return b.one->position > 0.05; })) << jog.err();
  // Nobody asks: zero and disabled by itself.
  const std::int64_t last_ns = rt::now_ns();
  EXPECT_TRUE(b.bench.comes([&] { return !b.one->drive->enabled(); }, 2000));
  EXPECT_LT(rt::now_ns() - last_ns, 1'000'000'000);
  ASSERT_TRUE(b.say_until(jog, "-0.3\n", [&] { return b.one->velocity < -0.1; })) << jog.err();
  jog.say("q\n");
  EXPECT_EQ(jog.wait(), 0) << jog.err();
  EXPECT_FALSE(b.bench.any_enabled());
  EXPECT_FALSE(b.two->was_enabled);
  EXPECT_LE(b.one->peak_torque, 0.4 + 10.0 / 4095.0);
  EXPECT_LE(b.one->peak_velocity, 1.0);
  const auto lines = lines_of(jog);
  ASSERT_GE(lines.size(), 2U);
  EXPECT_NE(lines.front()["phase"], "pushing");
  EXPECT_EQ(lines.back()["end"], "stopped");
  EXPECT_EQ(lines.back()["disabled"], true);
  EXPECT_LE(lines.back()["peak_torque"], 0.4);
}

TEST(Jog, EndsDisabledHoweverItEnds) {
  JogBench b;
  for (const int number : {SIGINT, SIGTERM}) {
    Program jog(b.folder, {"jog", b.robot, "joint1"});
    ASSERT_TRUE(b.say_until(jog, "+\n", [&] { return b.one->drive->enabled(); })) << jog.err();
    jog.signal(number);
    EXPECT_EQ(jog.wait(), 0) << jog.err();
    EXPECT_FALSE(b.bench.any_enabled());
    EXPECT_NE(jog.out().find("disabled; moved"), std::string::npos) << jog.out();
  }
  {
    Program jog(b.folder, {"jog", b.robot, "joint1"});
    ASSERT_TRUE(b.say_until(jog, "+\n", [&] { return b.one->drive->enabled(); })) << jog.err();
    jog.end_input();
    EXPECT_EQ(jog.wait(), 0);
    EXPECT_FALSE(b.bench.any_enabled());
  }
  Program killed(b.folder, {"jog", b.robot, "joint1"});
  ASSERT_TRUE(b.say_until(killed, "+\n", [&] { return b.one->drive->enabled(); })) << killed.err();
  killed.signal(SIGKILL);
  EXPECT_EQ(killed.wait(), 1000 + SIGKILL);
  // Nothing of ours is left: the drive's own watchdog (50 ms) ends it.
  EXPECT_TRUE(b.bench.comes(
      [&] { return b.one->drive->torque_nm(rt::now_ns()) == 0.0 && !b.one->drive->enabled(); },
      2000));
}

TEST(Jog, EndsInAFaultAndSaysWhy) {
  JogBench b;
  {
    Program jog(b.folder, {"jog", b.robot, "joint1", "--json"});
    ASSERT_TRUE(b.say_until(jog, "+\n", [&] { return b.one->drive->enabled(); })) << jog.err();
    b.bench.with([&] { b.one->drive->inject_error(0xA); });
    EXPECT_EQ(jog.wait(), 3);
    EXPECT_NE(jog.err().find("over-current"), std::string::npos) << jog.err();
    EXPECT_EQ(lines_of(jog).back()["end"], "fault");
    EXPECT_FALSE(b.bench.any_enabled());
  }
  Program refused(b.folder, {"jog", b.robot, "joint1"});
  EXPECT_EQ(refused.wait(), 1);
  EXPECT_NE(refused.err().find("over-current"), std::string::npos) << refused.err();
  {
    Program jog(b.folder, {"jog", b.robot, "joint2"});
    ASSERT_TRUE(b.say_until(jog, "-\n", [&] { return b.two->drive->enabled(); })) << jog.err();
    b.bench.with([&] {
      b.two->mangle = [](drivers::Frame& frame) { frame.id = 0x7AA; };  // it falls silent
    });
    EXPECT_EQ(jog.wait(), 3);
    EXPECT_NE(jog.err().find("silent"), std::string::npos) << jog.err();
    EXPECT_TRUE(b.bench.comes([&] { return !b.two->drive->enabled(); }, 1000));
  }
}

TEST(Jog, RefusesBeforeAnyTorque) {
  JogBench b;
  const auto refused = [&](std::vector<std::string> words, int status, const char* text) {
    words.insert(words.begin(), "jog");
    Program jog(b.folder, words);
    EXPECT_EQ(jog.wait(), status) << text;
    EXPECT_NE((jog.err() + jog.out()).find(text), std::string::npos) << jog.err();
  };
  refused({b.robot, "joint1", "--torque", "2.6"}, 1, "at most 2.5 N·m for this joint (hard bound)");
  refused({b.robot, "joint1", "--torque=-1"}, 1, "expected more than 0");
  refused({b.robot, "joint1", "--torque", "nan"}, 1, "expected more than 0");
  refused({b.robot, "joint1", "--velocity", "9"}, 1, "at most 2 rad/s");
  refused({b.robot, "joint1", "--travel", "9"}, 1, "at most 3.2 rad");
  refused({b.robot, "elbow"}, 1, "joints: joint1, joint2");
  refused({b.robot}, 2, "JOINT is required");
  {
    const drivers::BusLock daemon(b.bench.name());
    refused({b.robot, "joint1"}, 1, "is commanded already by process");
  }
  b.bench.with([&] { b.one->mangle = [](drivers::Frame& frame) { frame.data.fill(0xA5); }; });
  refused({b.robot, "joint1"}, 1, "joint joint1:");
  EXPECT_FALSE(b.one->was_enabled);
  EXPECT_FALSE(b.two->was_enabled);
}

TEST(Jog, TakesWhatItDoesNotUnderstandAsLettingGo) {
  JogBench b;
  Program jog(b.folder, {"jog", b.robot, "joint1", "--torque", "0.4"});
  ASSERT_TRUE(b.say_until(jog, "+\n", [&] { return b.one->drive->enabled(); })) << jog.err();
  jog.say("faster!\n9.5\n");
  EXPECT_TRUE(b.bench.comes([&] { return !b.one->drive->enabled(); }, 2000));
  jog.say("q\n");
  EXPECT_EQ(jog.wait(), 0);
  EXPECT_NE(jog.err().find("9.5 is more than the bound of 0.4"), std::string::npos) << jog.err();
}

TEST(Doctor, AsksEachDrive) {
  JogBench b;
  Program doctor(b.folder, {"doctor", b.robot, "--exchanges", "20", "--json"});
  doctor.wait();  // what this machine is like does not matter here
  const auto answer = nlohmann::json::parse(doctor.out());
  const auto says = [&](const char* area, const char* what) {
    for (const auto& finding : answer["findings"]) {
      if (finding["area"] == area && finding["what"] == what) {
        return finding["grade"].get<std::string>() + ": " + finding["text"].get<std::string>();
      }
    }
    return std::string("nothing");
  };
  EXPECT_EQ(says("joint joint1", "drive"), "OK: 0x1 (damiao) is as the robot file says");
  EXPECT_NE(says("joint joint2", "round trip").find("median"), std::string::npos);
  EXPECT_NE(says("joint joint2", "round trip").find("over 20 questions"), std::string::npos);
  EXPECT_EQ(says("bus main", "interface").substr(0, 3), "OK:");
  EXPECT_FALSE(b.bench.any_enabled());
  EXPECT_FALSE(b.one->was_enabled);

  b.bench.with([&] { b.two->mangle = [](drivers::Frame& frame) { frame.id = 0x7AA; }; });
  Program silent(b.folder, {"doctor", b.robot, "--exchanges", "5"});
  EXPECT_EQ(silent.wait(), 1);
  EXPECT_NE(silent.out().find("drive 0x2 does not answer"), std::string::npos) << silent.out();
  EXPECT_NE(silent.out().find("fix:           geodesic scan unix:"), std::string::npos)
      << silent.out();
}

}  // namespace
}  // namespace geodesic::tools::test
