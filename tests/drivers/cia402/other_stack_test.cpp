// Proof against another party's stack: the npm package `canopen` as master of our simulated drive,
// and as the slave that our driver brings to torque. Played from recordings in tests/data/canopen;
// with GEODESIC_OTHER_STACK naming a folder that has the package in its node_modules, the stack
// itself is spoken to, and recorded.
#include <fmt/format.h>
#include <gtest/gtest.h>
#include <sys/wait.h>
#include <unistd.h>

#include <algorithm>
#include <csignal>
#include <cstdio>
#include <cstdlib>
#include <fstream>
#include <memory>
#include <sstream>
#include <stdexcept>
#include <string>
#include <vector>

#include "tests/drivers/cia402/bench.hpp"

namespace geodesic::drivers::cia402::test {
namespace {

using control::DriveCondition;

constexpr const char* kScript = GEODESIC_SOURCE_DIR "/tests/drivers/cia402/other_stack.js";
constexpr const char* kRecordings = GEODESIC_TEST_DATA "/canopen/";

/// What we said in a cycle, as a recording has it.
std::string text_of(const std::vector<Frame>& frames) {
  std::string all;
  for (const Frame& frame : frames) {
    all += fmt::format("{}{:03X}#", all.empty() ? "" : " ", frame.id);
    for (const std::uint8_t byte : frame.payload()) {
      all += fmt::format("{:02X}", byte);
    }
  }
  return all;
}

Frame frame_of(const std::string& word) {
  const std::size_t hash = word.find('#');
  Frame made;
  made.id = static_cast<std::uint32_t>(std::stoul(word.substr(0, hash), nullptr, 16));
  for (std::size_t i = hash + 1; i + 1 < word.size(); i += 2) {
    made.data[made.length++] =
        static_cast<std::uint8_t>(std::stoul(word.substr(i, 2), nullptr, 16));
  }
  return made;
}

/// The stack itself, a process that is given a line for each cycle and gives one back.
class Process {
 public:
  Process(const char* role, const char* folder) {
    int to[2] = {-1, -1};
    int from[2] = {-1, -1};
    if (pipe(to) != 0 || pipe(from) != 0) {
      throw std::runtime_error("no pipes to another process");
    }
    std::signal(SIGPIPE, SIG_IGN);  // one that ended is told by what it does not answer
    child_ = fork();
    if (child_ == 0) {
      dup2(to[0], STDIN_FILENO);
      dup2(from[1], STDOUT_FILENO);
      for (const int end : {to[0], to[1], from[0], from[1]}) {
        close(end);
      }
      execlp("node", "node", kScript, role, folder, nullptr);
      _exit(127);
    }
    close(to[0]);
    close(from[1]);
    in_ = fdopen(from[0], "r");
    out_ = fdopen(to[1], "w");
  }
  ~Process() {
    fclose(out_);  // it ends when nothing more can come
    fclose(in_);
    waitpid(child_, nullptr, 0);
  }
  Process(const Process&) = delete;
  Process& operator=(const Process&) = delete;

  std::string ask(const std::string& line) {
    fprintf(out_, "%s\n", line.c_str());
    fflush(out_);
    std::string answer;
    for (int c = fgetc(in_); c != '\n'; c = fgetc(in_)) {
      if (c == EOF) {
        return "!wrong:it_ended";
      }
      answer += static_cast<char>(c);
    }
    return answer;
  }

 private:
  pid_t child_ = -1;
  FILE* in_ = nullptr;
  FILE* out_ = nullptr;
};

/// The other party, live or as recorded.
class OtherStack {
 public:
  explicit OtherStack(const char* role) {
    const std::string file = std::string(kRecordings).append(role).append(".txt");
    if (const char* folder = std::getenv("GEODESIC_OTHER_STACK")) {
      process_ = std::make_unique<Process>(role, folder);
      recording_.open(file, std::ios::out | std::ios::trunc);
    } else {
      recording_.open(file, std::ios::in);
    }
    EXPECT_TRUE(recording_) << file;
  }

  /// It hears `frames` and says what comes back; words of its script go to `words`.
  std::vector<Frame> hear(const std::vector<Frame>& frames) {
    const std::string ours = text_of(frames);
    std::string theirs;
    if (process_) {
      theirs = process_->ask(ours);
      recording_ << "> " << ours << "\n< " << theirs << "\n";
    } else {
      std::string recorded;
      if (!std::getline(recording_, recorded) || !std::getline(recording_, theirs)) {
        words.emplace_back("!wrong:the recording is over");
        return {};
      }
      if (recorded != "> " + ours) {
        words.push_back("!wrong:we said " + ours + ", recorded is " + recorded);
      }
      theirs.erase(0, 2);
    }
    std::vector<Frame> said;
    std::istringstream stream(theirs);
    for (std::string word; stream >> word;) {
      if (word[0] == '!') {
        words.push_back(word);
      } else {
        said.push_back(frame_of(word));
      }
    }
    return said;
  }

  bool said(const char* word) const {
    return std::find(words.begin(), words.end(), word) != words.end();
  }
  bool wrong() const {
    return std::any_of(words.begin(), words.end(),
                       [](const std::string& word) { return word.rfind("!wrong", 0) == 0; });
  }
  void expect_nothing_wrong() const {
    for (const std::string& word : words) {
      EXPECT_NE(word.rfind("!wrong", 0), 0U) << word;
    }
  }

  std::vector<std::string> words;

 private:
  std::unique_ptr<Process> process_;
  std::fstream recording_;
};

TEST(Cia402OtherStack, ItsMasterBringsOurSimulatedDriveToTorque) {
  OtherStack master("master");
  Simulated drive(bench_options());
  std::array<Frame, SimulatedDrive::kMaxReplies> reply;
  std::vector<Frame> heard;
  bool injected = false;
  drive.set_shaft(1.0, 0.0);
  for (std::int64_t now_ns = 0; now_ns < 10'000'000'000 && !master.said("!done") && !master.wrong();
       now_ns += 1'000'000) {
    const std::size_t spoken = drive.speak(now_ns, reply);
    heard.insert(heard.end(), reply.begin(), reply.begin() + static_cast<std::ptrdiff_t>(spoken));
    const std::vector<Frame> said = master.hear(heard);
    heard.clear();
    for (const Frame& frame : said) {
      const std::size_t count = drive.receive(frame, now_ns, reply);
      heard.insert(heard.end(), reply.begin(), reply.begin() + static_cast<std::ptrdiff_t>(count));
    }
    if (master.said("!enabled") && !injected) {
      EXPECT_NEAR(drive.torque_nm(now_ns), -7.0, 1e-12);
      drive.inject_error(2);
      injected = true;
    }
  }
  master.expect_nothing_wrong();
  EXPECT_TRUE(master.said("!done"));
  EXPECT_EQ(drive.power_state(), PowerState::kSwitchOnDisabled);
}

TEST(Cia402OtherStack, OurDriverBringsItsSlaveToTorque) {
  OtherStack slave("slave");
  DriveOptions options = bench_options();
  put(options, Setting::kHeartbeat, 1000);  // its timer runs by the clock, this bus does not
  put(options, Setting::kReset, static_cast<double>(Reset::kNone));
  Driver driver(options);
  std::int64_t now_ns = 1'000'000'000;
  std::array<Frame, Drive::kMaxFramesPerCycle> out;
  const auto cycle = [&](const DriveCommand& command) {
    now_ns += 1'000'000;
    const std::size_t frames = driver.transmit(command, now_ns, out);
    for (const Frame& frame :
         slave.hear({out.begin(), out.begin() + static_cast<std::ptrdiff_t>(frames)})) {
      driver.receive({frame, now_ns + 300'000});
    }
  };
  for (int i = 0; i < 500 && driver.state().condition != DriveCondition::kEnabled; ++i) {
    cycle(enable());
    ASSERT_FALSE(slave.wrong()) << slave.words.back();
    ASSERT_NE(driver.state().condition, DriveCondition::kRefused)
        << driver.complaint().quantity << ": " << driver.complaint().found << ", expected "
        << driver.complaint().expected << "; " << driver.complaint().fix;
  }
  ASSERT_EQ(driver.state().condition, DriveCondition::kEnabled);
  EXPECT_EQ(driver.revision(), 7U);
  const double per_increment = 2.0 * 3.14159265358979 / 1'638'400.0;
  for (const double torque : {1.0, -20.0, 41.0}) {
    cycle(enable(torque));
    cycle(enable(torque));
    EXPECT_NEAR(driver.state().torque_nm, torque, 0.5001 * 0.028);
    EXPECT_NEAR(driver.state().position_rad, -123456 * per_increment, 1e-9);
    EXPECT_NEAR(driver.state().velocity_rad_s, 16384 * per_increment, 1e-9);
  }
  for (int i = 0; i < 5; ++i) {
    cycle(disable());
  }
  EXPECT_EQ(driver.state().condition, DriveCondition::kDisabled);
  EXPECT_EQ(driver.state().torque_nm, 0.0);
  slave.expect_nothing_wrong();
}

}  // namespace
}  // namespace geodesic::drivers::cia402::test
