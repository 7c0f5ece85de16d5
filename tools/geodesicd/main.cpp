// geodesicd: puts the parts together, waits for the run to end, and leaves nothing half-running.
#include <fmt/format.h>
#include <poll.h>
#include <sys/signalfd.h>
#include <unistd.h>

#include <algorithm>
#include <cmath>
#include <csignal>
#include <cstdlib>
#include <iostream>
#include <memory>
#include <optional>
#include <stdexcept>
#include <string>
#include <vector>

#include "config/setup.hpp"
#include "control/controller.hpp"
#include "drivers/arm.hpp"
#include "rt/capabilities.hpp"
#include "rt/clock.hpp"
#include "rt/cyclic_thread.hpp"
#include "tools/compile/agreement.hpp"
#include "tools/geodesicd/bus_keeper.hpp"
#include "tools/geodesicd/control_socket.hpp"
#include "tools/geodesicd/daemon.hpp"
#include "tools/geodesicd/options.hpp"
#include "tools/geodesicd/output_file.hpp"
#include "tools/geodesicd/report.hpp"
#include "tools/geodesicd/service.hpp"

namespace geodesic::tools {
namespace {

/// Blocks the signals that end the daemon or have it read its file, in this thread and all it
/// starts.
/// @return a descriptor that reads them.
int signal_descriptor() {
  sigset_t set;
  sigemptyset(&set);
  sigaddset(&set, SIGINT);
  sigaddset(&set, SIGTERM);
  sigaddset(&set, SIGHUP);
  pthread_sigmask(SIG_BLOCK, &set, nullptr);
  std::signal(SIGPIPE, SIG_IGN);  // NOLINT(cert-err33-c): cannot fail for this signal
  return signalfd(-1, &set, SFD_CLOEXEC | SFD_NONBLOCK);
}

ExitCode refuse(const CommandLine& line, const config::Robot& robot, const std::string& error) {
  std::cerr << "geodesicd: error: " << error << '\n';
  if (!line.summary.empty()) {
    const std::string name = robot.name.empty() ? line.robot.string() : robot.name;
    if (const auto problem = write_output(
            line.summary, refused_summary_json(name, robot.period_ns, error).dump(2) + '\n')) {
      std::cerr << "geodesicd: error: " << *problem << '\n';
    }
  }
  return ExitCode::kRefused;
}

DaemonOptions daemon_options(const CommandLine& line, const config::Robot& robot) {
  DaemonOptions options;
  options.period_ns = robot.period_ns;
  options.receive_budget_ns = static_cast<std::int64_t>(static_cast<double>(robot.period_ns) *
                                                        robot.realtime.receive_deadline);
  options.lifetime.run_ns = static_cast<std::int64_t>(line.seconds * 1e9);
  options.lifetime.exit_on_fault = line.exit_on_fault;
  options.lifetime.safety = robot.controller.safety;
  options.measure_phases = !line.simulated_time;
  return options;
}

rt::ThreadOptions thread_options(const CommandLine& line, const config::Robot& robot,
                                 const drivers::Arm& arm) {
  rt::ThreadOptions options;
  options.name = "geodesic-rt";
  options.period_ns = robot.period_ns;
  options.priority = robot.realtime.priority;
  options.cpus = robot.realtime.cpus;
  options.best_effort = line.best_effort;
  options.simulated_time = line.simulated_time;
  options.drop_capabilities = true;
  if (!line.no_seal) {
    options.seal = rt::SealOptions{arm.descriptors()};
  }
  return options;
}

/// Follows signals until the run has ended by itself, or stands still. Must not log: it would wait
/// where the log's reader does not read.
/// @return whether the real-time thread has ended.
bool wait_for_end(int signals, const rt::CyclicThread& loop, Service& service, Tuning& tuning,
                  Lifetime& lifetime) {
  constexpr std::int64_t kStuckGraceNs = 1'000'000'000;
  int received = 0;
  std::int64_t stuck_since_ns = 0;
  while (loop.running()) {
    pollfd waiting{signals, POLLIN, 0};
    poll(&waiting, 1, 20);
    signalfd_siginfo signal{};
    const bool got = read(signals, &signal, sizeof(signal)) == sizeof(signal);
    if (got && signal.ssi_signo == SIGHUP) {
      tuning.ask_reload();
    } else if (got) {
      service.asked_to_end(++received);
      if (received < 3) {
        lifetime.ask_exit();
      } else {
        lifetime.ask_torque_off();
      }
    }
    if (!service.stuck()) {
      stuck_since_ns = 0;
    } else if (stuck_since_ns == 0) {
      stuck_since_ns = rt::now_ns();
    } else if (rt::now_ns() - stuck_since_ns > kStuckGraceNs) {
      return false;
    }
  }
  return true;
}

/// The service thread hangs: end without it, with the summary if that can be had without it.
[[noreturn]] void leave_hanging(const CommandLine& line, const Service& service) {
  constexpr int kCode = static_cast<int>(ExitCode::kFault);
  struct sigaction give_up {};
  give_up.sa_handler = [](int) { ::_exit(kCode); };
  sigaction(SIGALRM, &give_up, nullptr);
  ::alarm(2);  // what the thread held when it stopped, we may wait for in vain
  if (!line.summary.empty()) {
    nlohmann::ordered_json summary = summary_json(service.view(), false);
    summary["service_hung"] = true;
    summary["final_state"] = "unknown";  // nobody listened to the end
    write_output(line.summary, summary.dump(2) + '\n');
  }
  std::_Exit(kCode);
}

ExitCode finish(const CommandLine& line, const RunView& run, bool forced, Log& log) {
  const bool faulted = run.last.state == control::SupervisorState::kFault;
  std::uint64_t lost = 0;
  for (std::size_t i = 0; i < run.words.robot->arm.joints.size(); ++i) {
    lost += run.counters.joint[i].frames.lost;
  }
  log.write(
      faulted || forced ? Severity::kError : Severity::kInfo,
      fmt::format("ended: {}{}; {} cycles, {} missed, {} replies lost, {} faults and warnings",
                  control::to_string(run.last.state), forced ? ", torque forced off" : "",
                  run.loop.cycles.load(), run.loop.missed.load(), lost, run.faults.count));
  ExitCode code = faulted || forced ? ExitCode::kFault : ExitCode::kClean;
  if (line.summary.empty()) {
    return code;
  }
  if (const auto problem = write_output(line.summary, summary_json(run, forced).dump(2) + '\n')) {
    log.error(*problem);
    std::cerr << "geodesicd: error: " << *problem << '\n';
    code = code == ExitCode::kClean ? ExitCode::kRefused : code;
  }
  return code;
}

void greet(const config::Robot& robot, const rt::CyclicThread& loop, const ControlServer& socket,
           const BusKeeper& keeper, Log& log) {
  std::string buses;
  for (const drivers::BusOptions& bus : robot.arm.buses) {
    buses += " " + bus.interface;
  }
  log.info("geodesicd " GEODESIC_VERSION ": " + robot.name + ", " +
           std::to_string(robot.arm.joints.size()) + " joints on" + buses + ", period " +
           std::to_string(robot.period_ns / 1000) + " us, control socket " +
           socket.path().string());
  if (!loop.not_realtime_reason().empty()) {
    const Severity severity = robot.arm.simulated_time ? Severity::kInfo : Severity::kWarning;
    log.write(severity, "not real-time: " + loop.not_realtime_reason());
  }
  for (const std::string& warning : loop.warnings()) {
    log.warning(warning);
  }
  if (loop.statistics().sealed.load()) {
    log.info(
        "the real-time thread is sealed: it can sleep, send, receive, read the clock, no more");
  } else {
    log.warning("the real-time thread is not sealed: " + loop.not_sealed_reason());
  }
  if (::geteuid() == 0) {
    log.info(
        "started as root: every capability has been given up, but root's files are still its own; "
        "a user of its own is safer (tools/geodesicd/UNIT.md)");
  }
  const int administers = keeper.privileged_thread();
  if (administers != 0) {
    log.info("the thread that looks after the buses keeps CAP_NET_ADMIN, and no other does");
  }
  if (const std::string left = rt::capabilities_left(administers); !left.empty()) {
    log.warning("capabilities are left in thread " + left);
  }
}

/// From a checked robot to the end of its run. @throws what stands in the way of a start.
ExitCode run(const CommandLine& line, const config::LoadResult& loaded, Log& log, int signals) {
  const config::Robot& robot = loaded.robot;
  control::Mechanism mechanism = config::make_mechanism(robot, robot.payload);
  std::optional<compile::VerifiedModel> compiled;
  if (!robot.compiled.empty()) {
    compiled.emplace(robot.compiled, mechanism, line.robot);
    log.info(fmt::format(
        "compiled model {}, fingerprint {}: agrees with the robot's file to {:.2g} in {} states",
        robot.compiled.string(), compiled->fingerprint(), compiled->agreement().worst,
        compiled->agreement().states));
  }
  const control::CompiledModel* functions = compiled ? compiled->functions_for(mechanism) : nullptr;
  drivers::Arm arm(robot.arm);
  BusKeeper keeper(arm, robot.arm.buses);
  control::Controller controller(std::move(mechanism), robot.controller, functions);
  ControlServer socket(line.socket.empty() ? control_path(robot.name, PathEnvironment::current())
                                           : line.socket);
  const Vocabulary words(robot);
  std::unique_ptr<Trace> trace;
  if (!line.trace.empty()) {
    std::vector<std::string> joints;
    for (const drivers::JointOptions& joint : robot.arm.joints) {
      joints.push_back(joint.name);
    }
    const double cycles = 1e9 / (static_cast<double>(robot.period_ns) * line.trace_hz);
    trace = std::make_unique<Trace>(line.trace, joints, robot.arm.buses.size(),
                                    std::max<std::int64_t>(1, std::llround(cycles)));
  }
  // On the heap: the rings are megabytes.
  const auto daemon = std::make_unique<Daemon>(arm, controller, daemon_options(line, robot));
  rt::CyclicThread loop(thread_options(line, robot, arm));
  Tuning tuning(line, loaded, daemon->setups(), log, compiled ? &*compiled : nullptr);
  Service service({line.allow_zero_law, line.simulated_time}, words, *daemon, loop, socket, log,
                  tuning, keeper, trace.get());
  if (const auto refusal = loop.start(*daemon)) {
    throw std::runtime_error("the real-time thread was refused\n" + rt::to_string(*refusal));
  }
  rt::drop_thread_capabilities();  // the loop's thread has done so, the service thread inherits it
  service.start([&] { greet(robot, loop, socket, keeper, log); });
  const bool ended = wait_for_end(signals, loop, service, tuning, daemon->lifetime());
  if (!service.stop()) {
    leave_hanging(line, service);
  }
  if (!ended) {
    // The real-time thread neither ends nor can be made to: leave without waiting for it.
    finish(line, service.view(), true, log);
    std::_Exit(static_cast<int>(ExitCode::kFault));
  }
  loop.join();
  daemon->telemetry().finish();
  return finish(line, service.view(), daemon->lifetime().forced(), log);
}

ExitCode main_program(const CommandLine& line) {
  rt::keep_realtime_capabilities(true);
  const int signals = signal_descriptor();
  config::LoadResult loaded = config::load_robot(line.robot, {line.strict, line.buses, {}, {}});
  for (const config::Message& message : loaded.messages) {
    std::cerr << config::to_string(message) << '\n';
  }
  if (!line.summary.empty()) {
    if (const auto problem = prepare_output(line.summary)) {
      std::cerr << "geodesicd: error: summary: " << *problem << '\n';
      return ExitCode::kRefused;
    }
  }
  config::Robot& robot = loaded.robot;
  if (!loaded.ok) {
    return refuse(line, robot, "bad configuration, not started: " + line.robot.string());
  }
  if (const auto problem = apply(line, robot)) {
    return refuse(line, robot, *problem);
  }
  LogOptions log_options = LogOptions::for_stdout();
  log_options.level = line.log_level;
  log_options.json = line.json;
  Log log(log_options);
  try {
    return run(line, loaded, log, signals);
  } catch (const std::exception& problem) {
    return refuse(line, robot, problem.what());
  }
}

}  // namespace
}  // namespace geodesic::tools

int main(int argc, char** argv) {
  using namespace geodesic::tools;
  const ParseResult parsed = parse_command_line(argc, argv);
  return static_cast<int>(parsed.options ? main_program(*parsed.options) : parsed.code);
}
