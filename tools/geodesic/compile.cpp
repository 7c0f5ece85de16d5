// `geodesic compile`: a robot's dynamics as straight-line code, built, and proven against the model
// that needs no compiler.
#include <fmt/format.h>
#include <unistd.h>

#include <CLI/CLI.hpp>
#include <chrono>
#include <cstdio>
#include <filesystem>
#include <memory>
#include <nlohmann/json.hpp>

#include "config/setup.hpp"
#include "tools/compile/agreement.hpp"
#include "tools/compile/builder.hpp"
#include "tools/compile/compose.hpp"
#include "tools/compile/fingerprint.hpp"
#include "tools/geodesic/command.hpp"
#include "tools/geodesic/compile_speed.hpp"
#include "tools/geodesic/subject.hpp"

namespace geodesic::tools {
namespace {

using nlohmann::ordered_json;

struct CompileArguments {
  std::string file;
  std::string output;
  std::string source;
  std::string compiler;
  bool floating = false;
  bool json = false;
};

constexpr const char* kExamples =
    "  geodesic compile robot.toml                       writes robot.compiled.so beside it\n"
    "  geodesicd robot.toml --compiled robot.compiled.so   or [control] compiled in the file\n"
    "  geodesic compile robot.toml --source robot.cpp    the code too, to read or to build "
    "elsewhere\n"
    "  geodesic compile dog.urdf --floating --output dog.so --json";

constexpr const char* kNotes =
    "The file is for this mechanism and this kind of processor only. geodesicd refuses it when "
    "another user could have written it, when it is damaged, when anything the dynamics depend on "
    "has changed since (fingerprint), and when it differs from the model read from the robot's "
    "file "
    "by more than 1e-12 in one of a thousand states. It equals that model to rounding, not to the "
    "bit: a recording says which of the two it was made with. A payload, another gravity or other "
    "rotor inertias tuned while the daemon runs are another mechanism: the model that needs no "
    "compiler takes over until they are taken back.";

/// One line that is written over, where somebody watches.
class ProgressLine {
 public:
  void operator()(const std::string& what, double part) {
    if (::isatty(STDERR_FILENO) == 0) return;
    fmt::print(stderr, "\r\033[K{} {:3.0f} %", what, 100.0 * part);
    std::fflush(stderr);
    shown_ = true;
  }
  ~ProgressLine() {
    if (shown_) fmt::print(stderr, "\r\033[K");
  }

 private:
  bool shown_ = false;
};

struct Outcome {
  compile::Emission emission;
  compile::Agreement agreement;
  CompiledSpeed speed;
  double snap = 0.0;
  double compose_s = 0.0;
  double build_s = 0.0;
};

double seconds_since(std::chrono::steady_clock::time_point start) {
  return std::chrono::duration<double>(std::chrono::steady_clock::now() - start).count();
}

/// A robot's as the daemon starts with it, payload included.
control::Mechanism read_mechanism(const CompileArguments& arguments) {
  if (std::filesystem::path(arguments.file).extension() == ".toml" && !arguments.floating) {
    const config::Robot robot = load({arguments.file, {}, false});
    return config::make_mechanism(robot, robot.payload);
  }
  const Subject subject = read_subject(arguments.file);
  control::MechanismOptions options;
  options.rotor_inertia = subject.rotor_inertia;
  if (arguments.floating) options.base = control::Base::kFloating;
  return {subject.tree, subject.gravity, options};
}

/// A file beside the output that goes away if it does not become the output.
class Trial {
 public:
  explicit Trial(const std::filesystem::path& output)
      : path_(fmt::format("{}.new{}", output.string(), ::getpid())) {}
  ~Trial() {
    std::error_code ignored;
    std::filesystem::remove(path_, ignored);
  }
  Trial(const Trial&) = delete;
  Trial& operator=(const Trial&) = delete;
  const std::filesystem::path& path() const { return path_; }

 private:
  std::filesystem::path path_;
};

/// Frames that are a hair's breadth off a right angle are taken for exact where that changes
/// nothing beyond rounding; else they are compiled as they are.
Outcome make(const CompileArguments& arguments, const control::Mechanism& mechanism,
             const std::string& output) {
  const std::string compiler = compile::find_compiler(arguments.compiler);
  const Trial trial(output);
  ProgressLine progress;
  Outcome outcome;
  for (const double snap : compile::kSnaps) {
    const auto start = std::chrono::steady_clock::now();
    outcome.snap = snap;
    outcome.emission = compile::compose(mechanism, snap, std::ref(progress));
    const std::string text = compile::emit(outcome.emission);
    outcome.compose_s = seconds_since(start);
    progress(fmt::format("{} at work", compiler), 0.0);
    const auto built = std::chrono::steady_clock::now();
    write_file(trial.path(), compile::sealed(compile::build(compiler, text)));
    std::filesystem::permissions(trial.path(), std::filesystem::perms(0644));  // or it is refused
    outcome.build_s = seconds_since(built);
    progress("comparing", 0.0);
    const compile::Library library(trial.path(), "try again");
    outcome.agreement = compile::compare(library.model(), mechanism);
    if (!outcome.agreement.holds()) continue;
    if (!arguments.source.empty()) write_file(arguments.source, text);
    outcome.speed = measure(library.model(), mechanism);
    // Renamed, never written over: a daemon may run the old one.
    std::filesystem::rename(trial.path(), output);
    return outcome;
  }
  throw BadInput(
      fmt::format("the compiled model does not agree with the mechanism, and is not kept: "
                  "{}; allowed are {:g}",
                  compile::to_string(outcome.agreement), compile::kAgreement));
}

ordered_json to_json(const Outcome& outcome, const std::string& output) {
  ordered_json functions = ordered_json::object();
  for (const compile::Program& program : outcome.emission.programs) {
    const compile::Cost cost = program.cost();
    functions[program.name] = {{"multiplications", cost.multiplications},
                               {"additions", cost.additions},
                               {"divisions", cost.divisions},
                               {"angles", cost.angles}};
  }
  const auto pair = [](const CompiledSpeed::Pair& speed) {
    return ordered_json{{"compiled_ns", speed.compiled_ns}, {"interpreted_ns", speed.plain_ns}};
  };
  functions["bias"].update(pair(outcome.speed.bias));
  functions["bias"]["latency_ns"] = outcome.speed.bias_latency_ns;
  functions["gravity"].update(pair(outcome.speed.gravity));
  functions["metric"].update(pair(outcome.speed.metric));
  return {{"robot", outcome.emission.robot},
          {"file", output},
          {"fingerprint", outcome.emission.fingerprint},
          {"functions", std::move(functions)},
          {"agreement",
           {{"worst", outcome.agreement.worst},
            {"function", outcome.agreement.function},
            {"states", outcome.agreement.states},
            {"allowed", compile::kAgreement}}},
          {"snap", outcome.snap},
          {"compose_s", outcome.compose_s},
          {"build_s", outcome.build_s}};
}

void print(const Outcome& outcome, const std::string& output) {
  const CompiledSpeed& speed = outcome.speed;
  fmt::print("{}: {}, fingerprint {}\n\n", output, outcome.emission.robot,
             outcome.emission.fingerprint);
  fmt::print("{:<18}{:>16}{:>11}{:>8}{:>16}{:>18}\n", "function", "multiplications", "additions",
             "angles", "compiled [ns]", "interpreted [ns]");
  const CompiledSpeed::Pair* const speeds[] = {&speed.bias, &speed.gravity, &speed.metric, nullptr};
  for (std::size_t i = 0; i < outcome.emission.programs.size(); ++i) {
    const compile::Program& program = outcome.emission.programs[i];
    const compile::Cost cost = program.cost();
    fmt::print("{:<18}{:>16}{:>11}{:>8}", program.name, cost.multiplications, cost.additions,
               cost.angles);
    if (i < std::size(speeds) && speeds[i] != nullptr) {
      fmt::print("{:>16.1f}{:>18.1f}", speeds[i]->compiled_ns, speeds[i]->plain_ns);
    }
    fmt::print("\n");
  }
  fmt::print("\nbias as latency (each call waits for the last): {:.1f} ns\n",
             speed.bias_latency_ns);
  fmt::print("agrees with the interpreted model to {:.2g} ({}) in {} states; allowed are {:g}\n",
             outcome.agreement.worst, outcome.agreement.function, outcome.agreement.states,
             compile::kAgreement);
  fmt::print("{:.1f} s to find the expressions, {:.1f} s to build them\n", outcome.compose_s,
             outcome.build_s);
}

int run_compile(const CompileArguments& arguments) {
  const control::Mechanism mechanism = read_mechanism(arguments);
  if (const std::string reason = compile::uncompilable(mechanism); !reason.empty()) {
    throw BadInput(reason);
  }
  std::string output = arguments.output;
  if (output.empty()) {
    output = std::filesystem::path(arguments.file).replace_extension("compiled.so").string();
  }
  const Outcome outcome = make(arguments, mechanism, output);
  if (arguments.json) {
    fmt::print("{}\n", to_json(outcome, output).dump(2));
  } else {
    print(outcome, output);
  }
  return kExitOk;
}

}  // namespace

void add_compile(CLI::App& app, Run& run) {
  CLI::App* command = app.add_subcommand(
      "compile", "build a robot's gravity, bias and metric as code of their own, for geodesicd");
  const auto arguments = std::make_shared<CompileArguments>();
  command->add_option("ROBOT", arguments->file, "the robot's file (.toml), or a URDF")
      ->required()
      ->check(CLI::ExistingFile);
  command
      ->add_option("--output", arguments->output,
                   "the shared object (default: ROBOT.compiled.so beside the robot's file)")
      ->type_name("FILE");
  command->add_option("--source", arguments->source, "keep the C++ too")->type_name("FILE");
  command
      ->add_option("--compiler", arguments->compiler,
                   "a GCC or clang (default: g++, c++ or clang++, the first in PATH)")
      ->type_name("PROGRAM");
  command->add_flag("--floating", arguments->floating,
                    "the root link moves freely (not for geodesicd, whose robots are fixed)");
  command->add_flag("--json", arguments->json, "print the figures as JSON");
  command->footer(std::string("\n") + kNotes + "\n" + footer(kExamples));
  command->callback([&run, arguments] { run = [arguments] { return run_compile(*arguments); }; });
}

}  // namespace geodesic::tools
