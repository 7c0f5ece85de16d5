// A bench to try the tools at: simulated drives with a little inertia on a socket bus of their own,
// and the program `geodesic` as people start it. No test here.
#pragma once

#include <fcntl.h>
#include <gtest/gtest.h>
#include <poll.h>
#include <signal.h>  // NOLINT(modernize-deprecated-headers): kill is POSIX, not C++
#include <sys/wait.h>
#include <unistd.h>

#include <algorithm>
#include <array>
#include <atomic>
#include <cmath>
#include <functional>
#include <list>
#include <memory>
#include <mutex>
#include <string>
#include <thread>
#include <vector>

#include "drivers/bus/socket_bus_hub.hpp"
#include "drivers/families.hpp"
#include "rt/clock.hpp"
#include "tests/tools/geodesicd_fixture.hpp"

namespace geodesic::tools::test {

/// A drive on the bench: what moves it, and what it did.
struct BenchDrive {
  std::unique_ptr<drivers::SimulatedDrive> drive;
  std::function<void(drivers::Frame&)> mangle;  ///< what it answers, spoilt
  double inertia = 0.01;                        ///< [kg·m²]
  double friction = 0.01;                       ///< viscous [N·m·s/rad]
  double position = 0.0;
  double velocity = 0.0;
  double peak_torque = 0.0;
  double peak_velocity = 0.0;
  double furthest = 0.0;
  bool was_enabled = false;
  std::int64_t enabled_ns = 0;  ///< last seen enabled
};

class SimulatedBench {
 public:
  explicit SimulatedBench(const TemporaryFolder& folder)
      : name_("unix:" + (folder / "bus").string()), hub_(options_of(name_)) {
    drivers::BusOptions options;
    options.name = "bench";
    options.interface = name_;
    options.fd = true;
    bus_ = drivers::open_bus(options);
  }
  ~SimulatedBench() {
    stop_.store(true);
    if (thread_.joinable()) thread_.join();
  }
  SimulatedBench(const SimulatedBench&) = delete;
  SimulatedBench& operator=(const SimulatedBench&) = delete;

  BenchDrive& add(const drivers::DriveOptions& options) {
    BenchDrive& added = drives_.emplace_back();
    added.drive = drivers::find_family(options.family)->make_simulated(options);
    return added;
  }
  void start() {
    thread_ = std::thread([this] { run(); });
  }

  const std::string& name() const { return name_; }
  /// With the bench held still.
  void with(const std::function<void()>& act) {
    const std::lock_guard hold(mutex_);
    act();
  }
  bool any_enabled() {
    bool any = false;
    with([&] {
      for (const BenchDrive& one : drives_) any = any || one.drive->enabled();
    });
    return any;
  }
  /// Waits until `what` holds. @return it does, within `patience_ms`.
  bool comes(const std::function<bool()>& what, int patience_ms = 5000) {
    for (int i = 0; i < patience_ms / 5; ++i) {
      bool holds = false;
      with([&] { holds = what(); });
      if (holds) return true;
      std::this_thread::sleep_for(std::chrono::milliseconds(5));
    }
    return false;
  }

 private:
  static drivers::SocketBusHubOptions options_of(const std::string& name) {
    drivers::SocketBusHubOptions options;
    options.path = name;
    return options;
  }

  void run() {
    std::array<drivers::ReceivedFrame, 64> batch;
    std::array<drivers::Frame, drivers::SimulatedDrive::kMaxReplies> replies;
    std::int64_t last_ns = rt::now_ns();
    while (!stop_.load()) {
      pollfd wait{bus_->descriptor(), POLLIN, 0};
      ::poll(&wait, 1, 1);
      const std::lock_guard hold(mutex_);
      const std::int64_t now_ns = rt::now_ns();
      const std::size_t count = std::min(bus_->receive(batch), batch.size());
      for (BenchDrive& one : drives_) {
        for (std::size_t i = 0; i < count; ++i) {
          if (batch[i].frame.error) continue;
          answer(one, replies, one.drive->receive(batch[i].frame, now_ns, replies));
        }
        answer(one, replies, one.drive->speak(now_ns, replies));
        move(one, now_ns, static_cast<double>(now_ns - last_ns) * 1e-9);
      }
      last_ns = now_ns;
    }
  }

  void answer(BenchDrive& one, std::span<drivers::Frame> replies, std::size_t count) {
    for (std::size_t i = 0; i < count; ++i) {
      if (one.mangle) one.mangle(replies[i]);
      bus_->send(replies.subspan(i, 1));
    }
  }

  static void move(BenchDrive& one, std::int64_t now_ns, double elapsed_s) {
    const double torque = one.drive->torque_nm(now_ns);
    const double step_s = std::min(elapsed_s, 0.01);
    one.velocity += (torque - one.friction * one.velocity) / one.inertia * step_s;
    one.position += one.velocity * step_s;
    one.drive->set_shaft(one.position, one.velocity);
    one.peak_torque = std::max(one.peak_torque, std::abs(torque));
    one.peak_velocity = std::max(one.peak_velocity, std::abs(one.velocity));
    one.furthest = std::max(one.furthest, std::abs(one.position));
    if (one.drive->enabled()) {
      one.was_enabled = true;
      one.enabled_ns = now_ns;
    }
  }

  std::string name_;
  drivers::SocketBusHub hub_;
  std::unique_ptr<drivers::Bus> bus_;
  std::list<BenchDrive> drives_;
  std::mutex mutex_;
  std::atomic<bool> stop_{false};
  std::thread thread_;
};

/// `geodesic WORDS...`, started; what it prints goes to files.
class Program {
 public:
  Program(const TemporaryFolder& folder, std::vector<std::string> words)
      : out_(folder / "out"), err_(folder / "err") {
    words.insert(words.begin(), std::string(GEODESIC_BINARY_DIR) + "/tools/geodesic");
    std::vector<char*> arguments;
    for (std::string& word : words) arguments.push_back(word.data());
    arguments.push_back(nullptr);
    std::array<int, 2> pipe{};
    EXPECT_EQ(::pipe2(pipe.data(), O_CLOEXEC), 0);
    const int out = ::open(out_.c_str(), O_WRONLY | O_CREAT | O_TRUNC | O_CLOEXEC, 0600);
    const int err = ::open(err_.c_str(), O_WRONLY | O_CREAT | O_TRUNC | O_CLOEXEC, 0600);
    pid_ = ::fork();
    if (pid_ == 0) {
      ::dup2(pipe[0], 0);
      ::dup2(out, 1);
      ::dup2(err, 2);
      ::execv(arguments[0], arguments.data());
      ::_exit(127);
    }
    ::close(pipe[0]);
    ::close(out);
    ::close(err);
    in_ = pipe[1];
  }
  ~Program() {
    end_input();
    if (pid_ > 0) {
      ::kill(pid_, SIGKILL);
      ::waitpid(pid_, nullptr, 0);
    }
  }
  Program(const Program&) = delete;
  Program& operator=(const Program&) = delete;

  void say(const std::string& text) {
    EXPECT_EQ(::write(in_, text.data(), text.size()), static_cast<ssize_t>(text.size()));
  }
  void end_input() {
    if (in_ >= 0) ::close(in_);
    in_ = -1;
  }
  void signal(int number) const { ::kill(pid_, number); }
  /// Waits for its end. @return its exit status; 1000 and more: the signal that ended it.
  int wait() {
    int status = 0;
    ::waitpid(pid_, &status, 0);
    pid_ = -1;
    return WIFEXITED(status) ? WEXITSTATUS(status) : 1000 + WTERMSIG(status);
  }
  std::string out() const { return read_text(out_); }
  std::string err() const { return read_text(err_); }

 private:
  std::filesystem::path out_;
  std::filesystem::path err_;
  pid_t pid_ = -1;
  int in_ = -1;
};

inline drivers::DriveOptions damiao(std::uint32_t id, bool fd = false) {
  drivers::DriveOptions options;
  options.family = "damiao";
  options.id = id;
  options.reply_id = id + 0x10;
  options.fd = fd;
  options.position_range_rad = 12.5;
  options.velocity_range_rad_s = 30.0;
  options.torque_range_nm = 10.0;
  return options;
}

/// A robot file with damiao drives 1, 2 ... as joints joint1, joint2 ... on `bus`.
inline std::string bench_robot(const TemporaryFolder& folder, const std::string& bus,
                               int joints = 2) {
  std::string urdf = "<robot name=\"bench\"><link name=\"base\"/>\n";
  std::string toml =
      "[robot]\nname = \"bench\"\nurdf = \"robot.urdf\"\nrate_hz = 500\n[[bus]]\n"
      "name = \"main\"\ninterface = \"" +
      bus + "\"\n";
  for (int i = 1; i <= joints; ++i) {
    const std::string n = std::to_string(i);
    urdf += "<link name=\"link" + n +
            "\"><inertial><mass value=\"0.5\"/><inertia ixx=\"0.01\" "
            "ixy=\"0\" ixz=\"0\" iyy=\"0.01\" iyz=\"0\" izz=\"0.01\"/></inertial></link>\n<joint "
            "name=\"joint" +
            n + "\" type=\"revolute\"><parent link=\"base\"/><child link=\"link" + n +
            "\"/><axis xyz=\"0 0 1\"/><limit lower=\"-3\" upper=\"3\" effort=\"10\" "
            "velocity=\"10\"/></joint>\n";
    toml += "[[joint]]\nname = \"joint" + n +
            "\"\nbus = \"main\"\n[joint.drive]\nfamily = "
            "\"damiao\"\nid = " +
            n + "\nreply_id = " + std::to_string(i + 16) +
            "\nposition_range_rad = 12.5\nvelocity_range_rad_s = 30\ntorque_range_nm = 10\n";
  }
  std::ofstream(folder / "robot.urdf") << urdf << "</robot>\n";
  std::ofstream(folder / "robot.toml") << toml;
  return (folder / "robot.toml").string();
}

}  // namespace geodesic::tools::test
