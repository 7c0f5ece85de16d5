// `geodesic jog`: one joint, a little torque, as long as a person asks for it. Bounds and decisions
// are jog_law's, the bus is jog_session's.
#include <fmt/format.h>
#include <sched.h>
#include <unistd.h>

#include <CLI/CLI.hpp>
#include <algorithm>
#include <cmath>
#include <csignal>
#include <cstdio>
#include <memory>
#include <nlohmann/json.hpp>
#include <optional>

#include "rt/clock.hpp"
#include "tools/geodesic/command.hpp"
#include "tools/geodesic/jog_input.hpp"
#include "tools/geodesic/jog_session.hpp"
#include "tools/geodesic/joint_choice.hpp"
#include "tools/sim/stop_signals.hpp"

namespace geodesic::tools {
namespace {

constexpr double kDefaultShare = 0.05;  ///< of the joint's torque limit
constexpr double kHardShare = 0.25;     ///< no more by any option
constexpr double kOverrunShare = 0.1;   ///< of the travel

/// Bounds of velocity (per second) and travel, default and hard: rad or m.
struct Reach {
  double velocity, hard_velocity, travel, hard_travel;
};
constexpr Reach kRevolute{0.5, 2.0, 0.25, 3.2};
constexpr Reach kPrismatic{0.03, 0.1, 0.02, 0.5};

struct JogArguments {
  RobotArguments robot;
  std::string joint;
  std::optional<double> torque;
  std::optional<double> velocity;
  std::optional<double> travel;
  bool json = false;
};

constexpr const char* kExamples =
    "  geodesic jog robot.toml elbow                     hold an arrow key to push\n"
    "  geodesic jog robot.toml elbow --torque 0.8 --velocity 0.3 --travel 0.5\n"
    "  while sleep 0.05; do echo +; done | geodesic jog robot.toml elbow --json";

/// What was asked for, or the default; more than the hard bound is refused, not clipped.
double bounded(const char* name, std::optional<double> asked, double usual, double hard,
               const char* unit) {
  const double value = asked.value_or(std::min(usual, hard));
  if (!(value > 0.0 && value <= hard)) {
    throw BadInput(
        fmt::format("--{} {:g}: expected more than 0 and at most {:.4g} {} for this "
                    "joint (hard bound)",
                    name, value, hard, unit));
  }
  return value;
}

JogOptions bounds_of(const JogArguments& arguments, const config::Robot& robot, std::size_t index) {
  const bool slides = std::string_view(unit_of(robot, index)) == "m";
  const Reach& reach = slides ? kPrismatic : kRevolute;
  const drivers::JointOptions& joint = robot.arm.joints[index];
  const control::JointTuning& tuning = robot.controller.joints[index];
  const double torque_limit =
      std::min(tuning.torque_limit, joint.drive.torque_range_nm / joint.ratio);
  const double velocity_limit = std::min(reach.hard_velocity, tuning.velocity_limit);
  JogOptions options;
  options.torque = bounded("torque", arguments.torque, kDefaultShare * torque_limit,
                           kHardShare * torque_limit, slides ? "N" : "N·m");
  options.velocity = bounded("velocity", arguments.velocity, reach.velocity, velocity_limit,
                             slides ? "m/s" : "rad/s");
  const double travel =
      bounded("travel", arguments.travel, reach.travel, reach.hard_travel, unit_of(robot, index));
  options.lower = -travel;
  options.upper = travel;
  options.overrun = kOverrunShare * travel;
  options.temperature_limit_c = tuning.temperature_limit_c;
  return options;
}

/// The travel around where the joint stands, less what its limits cut off. Beyond a limit, the way
/// back is free and the way out is none.
void place(JogOptions& options, double position, const control::JointTuning& tuning) {
  options.lower = std::min(position, std::max(position + options.lower, tuning.position_lower));
  options.upper = std::max(position, std::min(position + options.upper, tuning.position_upper));
}

void explain(std::FILE* out, const config::Robot& robot, std::size_t index,
             const JogOptions& options, const JogInput& input) {
  const bool slides = std::string_view(unit_of(robot, index)) == "m";
  const char* unit = slides ? "m" : "rad";
  fmt::print(out,
             "joint {}: at most {:.3g} {}, {:.3g} {}/s, from {:+.3f} to {:+.3f} {}\n"
             "Nothing holds the joint when you let go: support what may fall.\n{}\n",
             robot.arm.joints[index].name, options.torque, slides ? "N" : "N·m", options.velocity,
             unit, options.lower, options.upper, unit,
             input.terminal()
                 ? "Hold right or + to push forward, left or - to push back; q ends. Torque ends "
                   "0.2 s after\nthe last key: what comes before the keyboard repeats is one "
                   "short push."
                 : "Lines: + or - or a torque, at least every 0.2 s; q or the end of input ends.");
}

/// Ten times a second: a line that is written over on a terminal, else one each.
class Display {
 public:
  Display(bool json, const char* unit)
      : json_(json), terminal_(::isatty(STDOUT_FILENO) == 1), unit_(unit) {}

  void head() const {
    if (json_) return;
    fmt::print("{:<10}{:>12}{:>12}{:>12}{:>12}{:>8}  {}\n", "phase", fmt::format("at [{}]", unit_),
               fmt::format("[{}/s]", unit_), "asked", "measured", "C", "drive");
  }

  /// @return false: nobody reads it any more.
  bool show(const JogSession& session, double time_s, bool now) {
    if (!now && session.now_ns() < next_ns_) return true;
    next_ns_ = session.now_ns() + 100'000'000;
    const control::JointState& joint = session.joint();
    const bool enabled = joint.condition == control::DriveCondition::kEnabled;
    if (json_) {
      const nlohmann::ordered_json line{{"time_s", time_s},
                                        {"phase", to_string(session.law().phase())},
                                        {"position", joint.position},
                                        {"velocity", joint.velocity},
                                        {"torque", session.law().torque()},
                                        {"measured", joint.torque},
                                        {"temperature_c", joint.temperature_c},
                                        {"enabled", enabled}};
      fmt::print("{}\n", line.dump());
    } else {
      fmt::print("{}{:<10}{:>+12.4f}{:>+12.4f}{:>+12.3f}{:>+12.3f}{:>8.0f}  {:<10}{}",
                 terminal_ ? "\r" : "", to_string(session.law().phase()), joint.position,
                 joint.velocity, session.law().torque(), joint.torque, joint.temperature_c,
                 enabled ? "enabled" : "disabled", terminal_ ? "" : "\n");
    }
    return std::fflush(stdout) == 0;
  }

  void end() const {
    if (!json_ && terminal_) fmt::print("\n");
  }

 private:
  bool json_;
  bool terminal_;
  const char* unit_;
  std::int64_t next_ns_ = 0;
};

/// Where it is allowed; the drive's watchdog stands behind it where it is not.
void ask_for_real_time(int priority) {
  sched_param parameters{};
  parameters.sched_priority = priority;
  ::sched_setscheduler(0, SCHED_FIFO, &parameters);
}

int run_jog(const JogArguments& arguments) {
  const config::Robot robot = load(arguments.robot);
  const std::size_t index = choose_joint(robot, arguments.joint);
  JogOptions options = bounds_of(arguments, robot, index);
  // A terminal or a reader that goes away must not end this program before the drive is disabled.
  std::signal(SIGHUP, SIG_IGN);
  std::signal(SIGPIPE, SIG_IGN);
  const StopSignals signals;
  JogSession session(robot, index);
  const std::string trouble = session.connect(signals.requested(), signals.waiting_mask());
  if (!trouble.empty()) {
    throw BadInput(fmt::format("joint {}: {}", arguments.joint, trouble));
  }
  const double start = session.joint().position;
  place(options, start, robot.controller.joints[index]);
  options.period_ns = session.period_ns();
  JogInput input(STDIN_FILENO, options.torque);
  explain(arguments.json ? stderr : stdout, robot, index, options, input);
  ask_for_real_time(robot.realtime.priority);
  session.begin(options);
  Display display(arguments.json, unit_of(robot, index));
  display.head();
  const std::int64_t begin_ns = session.now_ns();
  const auto time_s = [&] { return static_cast<double>(session.now_ns() - begin_ns) * 1e-9; };
  bool read = true;
  while (!signals.requested().load() && !input.ended() && read &&
         session.law().phase() != JogPhase::kFault) {
    input.poll(rt::now_ns());
    if (const std::string complaint = input.take_complaint(); !complaint.empty()) {
      fmt::print(stderr, "geodesic: {}\n", complaint);
    }
    session.cycle(input.request(), signals.waiting_mask());
    read = display.show(session, time_s(), false);
  }
  const bool disabled = session.let_go();
  display.show(session, time_s(), true);
  display.end();
  const bool fault = session.law().phase() == JogPhase::kFault;
  if (arguments.json) {
    const nlohmann::ordered_json last{{"end", fault ? "fault" : "stopped"},
                                      {"reason", session.law().reason()},
                                      {"disabled", disabled},
                                      {"peak_torque", session.peak_torque()},
                                      {"moved", session.joint().position - start},
                                      {"seconds", time_s()}};
    fmt::print("{}\n", last.dump());
  } else {
    fmt::print("{}; moved {:+.4f} {}, at most {:.3f} asked\n",
               disabled ? "disabled" : "NOT known to be disabled", session.joint().position - start,
               unit_of(robot, index), session.peak_torque());
  }
  if (!disabled) {
    fmt::print(stderr,
               "geodesic: error: the drive does not say that it is disabled: its own "
               "watchdog has to stop it; keep away, and switch it off\n");
  }
  if (fault) fmt::print(stderr, "geodesic: error: {}\n", session.law().reason());
  return fault || !disabled ? kExitFault : kExitOk;
}

}  // namespace

void add_jog(CLI::App& app, Run& run) {
  auto arguments = std::make_shared<JogArguments>();
  CLI::App* command =
      app.add_subcommand("jog", "Push one joint with a little torque, only while a key is held");
  add_robot(*command, arguments->robot);
  command->add_option("JOINT", arguments->joint, "the joint's name in the robot file")->required();
  command->add_option("--torque", arguments->torque,
                      "bound [N·m or N] (default 5 % of the joint's torque limit; at most 25 %)");
  command->add_option("--velocity", arguments->velocity,
                      "bound [rad/s or m/s] (default 0.5 rad/s, at most 2; 0.03 m/s, at most 0.1)");
  command->add_option("--travel", arguments->travel,
                      "how far to either side of where it stands [rad or m], and never beyond the "
                      "joint's limits (default 0.25 rad, at most 3.2; 0.02 m, at most 0.5)");
  command->add_flag("--json", arguments->json, "one JSON object a line, ten a second, and an end");
  command->footer(
      "\nTorque is made only while a key is held, or lines keep coming, within 0.2 s; else it is "
      "zero and\nthe drive disabled. It fades in over 0.2 s, fades out towards the velocity bound "
      "and the end of\ntravel, and brakes beyond. Twice the velocity, travel overrun, a silent "
      "drive, a drive's error,\nanother drive enabled, a lost bus or a busy machine end it: "
      "disabled, exit status 3. If this\nprogram is killed, the drive's own watchdog (watchdog_ms) "
      "stops it. All other drives on the bus\nare kept disabled. There is no gravity compensation. "
      "Refused while a daemon commands the bus." +
      footer(kExamples));
  command->callback([arguments, &run] { run = [arguments] { return run_jog(*arguments); }; });
}

}  // namespace geodesic::tools
