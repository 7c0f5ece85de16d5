// Tuning without a daemon around it: what is taken, refused, undone; the hand-over between two
// threads; and that a saved file is noticed whatever way it was saved.
#include <gtest/gtest.h>

#include <atomic>
#include <thread>

#include "config/setup.hpp"
#include "control/mechanism/dynamics.hpp"
#include "tests/config/bench.hpp"
#include "tests/tools/geodesicd_fixture.hpp"
#include "tools/geodesicd/file_watch.hpp"
#include "tools/geodesicd/setup_exchange.hpp"
#include "tools/geodesicd/tuner.hpp"

namespace geodesic::tools {
namespace {

using config::replaced;

constexpr const char* kBox = "[[payload]]\nname = \"box\"\nmass = 2\ncom = [0.1, 0, 0]\n";

class Tuning : public config::Bench {
 public:
  Tuning() { write("robot.toml", text()); }

  static std::string text() {
    std::string text(config::kRobotToml);
    text.append(kBox);
    return text;
  }

  Tuner tuner() {
    CommandLine line;
    line.robot = folder() / "robot.toml";
    config::LoadResult start = load();
    EXPECT_TRUE(start.ok) << config::all_of(start.messages);
    return {line, std::move(start), [this](std::unique_ptr<const control::Setup> setup) {
              if (verdict == Tuner::Verdict::kTaken) in_use = std::move(setup);
              ++handed_over;
              return verdict;
            }};
  }

  static std::string text_of(const TuneOutcome& outcome) {
    std::string all;
    for (const config::Change& change : outcome.changes) all += to_string(change) + "\n";
    for (const std::string& problem : outcome.problems) all += "refused: " + problem + "\n";
    for (const std::string& note : outcome.notes) all += "note: " + note + "\n";
    return all;
  }

  Record now{};
  Tuner::Verdict verdict = Tuner::Verdict::kTaken;
  std::unique_ptr<const control::Setup> in_use;
  int handed_over = 0;
};

TEST_F(Tuning, SetsWhatWasAskedAndNothingElse) {
  Tuner tuner = this->tuner();
  const TuneOutcome outcome = tuner.set({{"joint.elbow.damping", "0.5"}, {"payload", "box"}}, now);
  EXPECT_TRUE(outcome.ok);
  EXPECT_EQ(text_of(outcome),
            "robot.payload: \"none\" -> \"box\"\njoint.elbow.damping: 0 -> 0.5 N·m·s/rad\n");
  ASSERT_NE(in_use, nullptr);
  EXPECT_EQ(in_use->options.joints[1].damping, 0.5);
  EXPECT_EQ(in_use->mechanism.moving_mass(), 1.3 + 0.9 + 2.0);
  EXPECT_EQ(tuner.tuned().size(), 2U);
}

TEST_F(Tuning, OneWrongValueAndNothingIsTaken) {
  Tuner tuner = this->tuner();
  EXPECT_EQ(text_of(tuner.set({{"joint.elbow.damping", "0.5"}, {"joint.elbow.dampnig", "1"}}, now)),
            "refused: there is no option \"joint.elbow.dampnig\"; did you mean "
            "\"joint.elbow.damping\"?\n");
  EXPECT_EQ(text_of(tuner.set({{"robot.rate_hz", "500"}}, now)),
            "refused: robot.rate_hz needs a restart: change it in the file\n");
  EXPECT_NE(text_of(tuner.set({{"joint.elbow.damping", "-1"}}, now)).find("at least 0"),
            std::string::npos);
  EXPECT_NE(text_of(tuner.set({{"joint.elbow.damping", "1 2"}}, now)).find("is no value"),
            std::string::npos);
  EXPECT_NE(text_of(tuner.set({{"simulation.floor_z_m", "1"}}, now)).find("simulated arm"),
            std::string::npos);
  EXPECT_NE(text_of(tuner.set({}, now)).find("nothing to set"), std::string::npos);
  EXPECT_EQ(handed_over, 0);
  EXPECT_TRUE(tuner.tuned().empty());
  EXPECT_EQ(tuner.undoable(), 0U);
}

// To the bit: the options' own bytes, and the gravity that the model computes.
TEST_F(Tuning, UndoIsExact) {
  Tuner tuner = this->tuner();
  const control::Setup before = config::make_setup(tuner.robot());
  ASSERT_TRUE(tuner.set({{"joint.elbow.coulomb_friction", "0.1"}, {"payload", "box"}}, now).ok);
  ASSERT_TRUE(tuner.set({{"joint.elbow.coulomb_friction", "0.3"}, {"payload", "none"}}, now).ok);
  ASSERT_TRUE(tuner.set({{"gravity", "[0, 0, -9.81]"}}, now).ok);
  EXPECT_EQ(text_of(tuner.undo(now)), "robot.gravity: [0, 0, -9.81] -> [0, -9.81, 0] m/s²\n");
  EXPECT_EQ(text_of(tuner.undo(now)),
            "robot.payload: \"none\" -> \"box\"\njoint.elbow.coulomb_friction: 0.3 -> 0.1 N·m\n");
  ASSERT_TRUE(tuner.undo(now).ok);
  EXPECT_FALSE(tuner.undo(now).ok);
  EXPECT_TRUE(tuner.tuned().empty());
  const control::Setup& after = *in_use;
  EXPECT_EQ(before.options.joints[1].coulomb_friction, after.options.joints[1].coulomb_friction);
  control::Workspace a(before.mechanism);
  control::Workspace b(after.mechanism);
  const Eigen::Vector2d q(0.3, -1.1);
  const Eigen::Vector2d v(1.0, -2.0);
  const Eigen::VectorXd expected = control::bias(before.mechanism, a, q, v);
  EXPECT_EQ(expected, Eigen::VectorXd(control::bias(after.mechanism, b, q, v)));
}

TEST_F(Tuning, FileWinsForWhatItChanges) {
  Tuner tuner = this->tuner();
  ASSERT_TRUE(
      tuner.set({{"joint.elbow.damping", "0.5"}, {"joint.shoulder.damping", "0.5"}}, now).ok);
  write("robot.toml", replaced(text(), "name = \"elbow\"", "name = \"elbow\"\ndamping = 0.7"));
  EXPECT_EQ(text_of(tuner.reload(now)),
            "joint.elbow.damping: 0.5 -> 0.7 N·m·s/rad\n"
            "note: joint.elbow.damping: the file's 0.7 takes the place of the tuned 0.5\n");
  ASSERT_EQ(tuner.tuned().size(), 1U);
  EXPECT_EQ(tuner.tuned().front().path, "joint.shoulder.damping");
  EXPECT_EQ(text_of(tuner.undo(now)), "joint.shoulder.damping: 0.5 -> 0 N·m·s/rad\n");
}

TEST_F(Tuning, AFileThatNeedsARestartIsRefusedByName) {
  Tuner tuner = this->tuner();
  std::string changed = replaced(text(), "rate_hz = 1000", "rate_hz = 500");
  changed = replaced(changed, "name = \"elbow\"", "name = \"elbow\"\ndamping = 0.7");
  write("robot.toml", changed);
  const TuneOutcome outcome = tuner.reload(now);
  EXPECT_FALSE(outcome.ok);
  EXPECT_TRUE(outcome.changes.empty());
  EXPECT_NE(text_of(outcome).find("robot.toml:5:11: robot.rate_hz: 1000 -> 500 Hz needs a restart"),
            std::string::npos)
      << text_of(outcome);
  EXPECT_EQ(tuner.robot().controller.joints[1].damping, 0.0);
  write("robot.toml", replaced(changed, "rate_hz = 500", "rate_hz = 1000"));
  EXPECT_EQ(text_of(tuner.reload(now)), "joint.elbow.damping: 0 -> 0.7 N·m·s/rad\n");
}

TEST_F(Tuning, ABadFileSaysWhereAndChangesNothing) {
  Tuner tuner = this->tuner();
  write("robot.toml", replaced(text(), "rate_hz = 1000", "rate_hz = "));
  EXPECT_NE(text_of(tuner.reload(now)).find("robot.toml:5:"), std::string::npos);
  write("robot.toml", text());
  write("two.urdf", "<robot");
  EXPECT_NE(text_of(tuner.reload(now)).find("two.urdf"), std::string::npos);
  // What stands is what was read last, not what the disk holds now.
  EXPECT_EQ(text_of(tuner.set({{"joint.elbow.damping", "0.5"}}, now)),
            "joint.elbow.damping: 0 -> 0.5 N·m·s/rad\n");
  std::filesystem::remove(folder() / "robot.toml");
  EXPECT_NE(text_of(tuner.reload(now)).find("there is no file"), std::string::npos);
  EXPECT_TRUE(tuner.undo(now).ok);
}

TEST_F(Tuning, MassesOfTheUrdfMoveOver) {
  Tuner tuner = this->tuner();
  write("two.urdf", replaced(config::kTwoUrdf, "<mass value=\"0.9\"/>", "<mass value=\"1.1\"/>"));
  EXPECT_EQ(text_of(tuner.reload(now)), "urdf.link.lower.mass: 0.9 -> 1.1 kg\n");
  EXPECT_EQ(in_use->mechanism.moving_mass(), 1.3 + 1.1);
}

TEST_F(Tuning, LimitsThatExcludeTheArmAreRefusedWithTheFigure) {
  Tuner tuner = this->tuner();
  now.joint[1].position = 1.25;
  now.joint[1].velocity = -0.75;
  now.joint[1].model = -4.5F;
  now.joint[1].temperature_c = 61.0F;
  now.joint[1].age_us = 0;
  now.authority = 1.0F;
  const auto refused = [&](const char* key, const char* value, const char* figure) {
    const std::string said = text_of(tuner.set({{std::string("joint.elbow.") + key, value}}, now));
    EXPECT_NE(said.find("refused: joint.elbow." + std::string(key)), std::string::npos) << said;
    EXPECT_NE(said.find(figure), std::string::npos) << said;
  };
  refused("position_upper", "1.0", "is at 1.25 rad");
  now.joint[1].position = -0.75;
  refused("position_lower", "-0.6", "is at -0.75 rad");
  now.joint[1].position = 1.25;
  refused("velocity_limit", "0.5", "moves at 0.75 rad/s");
  refused("torque_limit", "4", "is held up by 4.5 N·m");
  EXPECT_EQ(handed_over, 0);
  EXPECT_TRUE(tuner.set({{"joint.elbow.position_upper", "1.3"}}, now).ok);
  now.joint[1].age_us = JointRecord::kNever;
  EXPECT_TRUE(tuner.set({{"joint.elbow.position_upper", "1.0"}}, now).ok);
}

TEST_F(Tuning, WhatTheRealTimeThreadRefusesIsNotTaken) {
  Tuner tuner = this->tuner();
  verdict = Tuner::Verdict::kRefused;
  EXPECT_FALSE(tuner.set({{"joint.elbow.damping", "0.5"}}, now).ok);
  verdict = Tuner::Verdict::kBusy;
  EXPECT_FALSE(tuner.set({{"joint.elbow.damping", "0.5"}}, now).ok);
  EXPECT_TRUE(tuner.tuned().empty());
  verdict = Tuner::Verdict::kUnknown;
  EXPECT_TRUE(tuner.set({{"joint.elbow.damping", "0.5"}}, now).ok);
  EXPECT_FALSE(tuner.set({{"joint.elbow.damping", "0.6"}}, now).ok) << "the first is on its way";
  tuner.refused();
  EXPECT_TRUE(tuner.tuned().empty());
  EXPECT_EQ(tuner.robot().controller.joints[1].damping, 0.0);
  EXPECT_TRUE(tuner.set({{"joint.elbow.damping", "0.5"}}, now).ok);
  tuner.taken();
  EXPECT_EQ(tuner.tuned().size(), 1U);
}

TEST_F(Tuning, ATunedPayloadThatTheFileTakesAwayIsRefused) {
  Tuner tuner = this->tuner();
  ASSERT_TRUE(tuner.set({{"payload", "box"}}, now).ok);
  write("robot.toml", config::kRobotToml);
  EXPECT_NE(text_of(tuner.reload(now)).find("there is no [[payload]] \"box\""), std::string::npos);
  ASSERT_TRUE(tuner.undo(now).ok);
  EXPECT_EQ(text_of(tuner.reload(now)), "payload.box: there -> -\n");
}

// Two threads, many setups: each arrives once, and nothing is freed that is in use (sanitizers look
// on when this runs under them).
TEST(SetupExchange, HandsOverWithoutWaiting) {
  const config::Robot robot = small_robot();
  control::Controller controller(config::make_mechanism(robot, {}), robot.controller);
  SetupExchange exchange;
  std::atomic<bool> over{false};
  std::atomic<int> taken{0};
  std::thread realtime([&] {
    double seen = 0.0;
    control::ArmState state;
    while (!over.load()) {
      if (const control::Setup* setup = exchange.follow(controller)) {
        seen += setup->options.joints[0].damping;
        ++taken;
      }
      state.tick_ns += 1'000'000;
      controller.update(state, 1'000'000);
    }
    EXPECT_GT(seen, 0.0);
  });
  int given = 0;
  for (int i = 1; i <= 200; ++i) {
    config::Robot other = robot;
    other.controller.joints[0].damping = i;
    ASSERT_FALSE(exchange.busy());
    exchange.offer(std::make_unique<const control::Setup>(config::make_setup(other)));
    ASSERT_TRUE(exchange.busy());
    SetupExchange::Verdict verdict = SetupExchange::Verdict::kNone;
    while (verdict == SetupExchange::Verdict::kNone) {
      std::this_thread::yield();
      verdict = exchange.collect();
    }
    EXPECT_EQ(verdict, SetupExchange::Verdict::kTaken);
    ++given;
  }
  over.store(true);
  realtime.join();
  EXPECT_EQ(taken.load(), given);
}

class Watching : public ::testing::Test {
 public:
  /// Whether a change is told within the settling time and a look; the clock is the test's own.
  bool told(FileWatch& watch) {
    int times = 0;
    for (int i = 0; i < 130; ++i) {
      now_ += std::chrono::milliseconds(10);
      if (watch.changed(now_)) ++times;
    }
    EXPECT_LE(times, 1);
    return times > 0;
  }
  static void save(const std::filesystem::path& file, const std::string& text) {
    std::ofstream(file) << text;
  }

  TemporaryFolder folder;

 private:
  FileWatch::Clock::time_point now_ = FileWatch::Clock::now();
};

TEST_F(Watching, TellsEveryWayOfSavingOnce) {
  const std::filesystem::path file = folder / "robot.toml";
  save(file, "1");
  FileWatch watch({file});
  EXPECT_EQ(watch.problem(), "");
  EXPECT_FALSE(told(watch));
  save(file, "22");
  EXPECT_TRUE(told(watch));
  EXPECT_FALSE(told(watch));
  save(folder / "robot.toml~", "333");  // as editors do: beside, then renamed over it
  EXPECT_FALSE(told(watch));
  std::filesystem::rename(folder / "robot.toml~", file);
  EXPECT_TRUE(told(watch));
  std::filesystem::rename(file, folder / "backup");  // moved away, written anew
  save(file, "4444");
  EXPECT_TRUE(told(watch));
  save(folder / "other.toml", "5");
  EXPECT_FALSE(told(watch));
  std::filesystem::remove(file);
  EXPECT_TRUE(told(watch));
  save(file, "666666");
  EXPECT_TRUE(told(watch));
}

TEST_F(Watching, FollowsSymbolicLinks) {
  std::filesystem::create_directory(folder / "data");
  const std::filesystem::path real = folder / "data" / "real.toml";
  save(real, "1");
  std::filesystem::create_symlink(real, folder / "robot.toml");
  FileWatch watch({folder / "robot.toml"});
  EXPECT_FALSE(told(watch));
  save(real, "22");
  EXPECT_TRUE(told(watch));
}

TEST_F(Watching, OutlivesTheFolder) {
  const std::filesystem::path inner = folder / "inner";
  std::filesystem::create_directory(inner);
  save(inner / "robot.toml", "1");
  FileWatch watch({inner / "robot.toml"});
  EXPECT_FALSE(told(watch));
  std::filesystem::remove_all(inner);
  EXPECT_TRUE(told(watch));
  EXPECT_FALSE(told(watch));
  EXPECT_NE(watch.problem(), "");
  std::filesystem::create_directory(inner);
  save(inner / "robot.toml", "22");
  EXPECT_TRUE(told(watch));
  save(inner / "robot.toml", "333");
  EXPECT_TRUE(told(watch));
  EXPECT_EQ(watch.problem(), "");
}

}  // namespace
}  // namespace geodesic::tools
