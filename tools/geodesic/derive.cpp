// `geodesic derive`: metric, Christoffel symbols, gravity and equations of motion as formulas.
#include <fmt/format.h>
#include <fmt/ranges.h>
#include <unistd.h>

#include <CLI/CLI.hpp>
#include <algorithm>
#include <chrono>
#include <cstdio>
#include <filesystem>
#include <memory>
#include <nlohmann/json.hpp>

#include "tools/derive/closed_form.hpp"
#include "tools/derive/code.hpp"
#include "tools/derive/exact.hpp"
#include "tools/derive/sheet.hpp"
#include "tools/geodesic/command.hpp"
#include "tools/geodesic/subject.hpp"
#include "tools/sim/script.hpp"
#include "tools/sim/stop_signals.hpp"

namespace geodesic::tools {
namespace {

namespace fs = std::filesystem;

// Of a processor like those arms are controlled by, deriving and writing together.
constexpr double kSecondsPerTerm = 10e-6;
constexpr std::size_t kDefaultLimit = 200'000;

struct DeriveArguments {
  std::string file;
  std::vector<std::string> what;
  std::string format = "text";
  std::string output;
  std::string gravity;
  std::size_t limit = kDefaultLimit;
  int digits = 12;
  bool symbols = false;
  bool rotors = false;
  bool as_written = false;
  bool force = false;
  bool yes = false;
  bool json = false;

  bool is_code() const { return format == "c" || format == "matlab"; }
};

constexpr const char* kHelp =
    "\nEvery entry is brought to its normal form, a sum of sines and cosines of whole "
    "combinations\n"
    "of joint angles, which is unique; it is printed in products or in sums of angles, whichever\n"
    "is shorter. GiNaC takes the derivatives. Limits and times on an ordinary processor:\n"
    "  2 or 3 joints      at once, with letters (--symbols) as well\n"
    "  6 (UR5)            1200 terms, at once; with letters 3000\n"
    "  7 (iiwa)           40 000 terms, a second; M and g alone 4500\n"
    "  7 (OpenArm)        365 000 terms, 3 s, after --yes; M and g alone 33 000\n"
    "Beyond --limit it stops as soon as it foresees that, and says what is in reach.\n"
    "Joints that turn freely in space (spherical, floating) have no chart and are refused.\n";

constexpr const char* kExamples =
    "  geodesic derive robot.toml --symbols                 the textbook's formulas, in letters\n"
    "  geodesic derive arm.urdf --what M,g                  metric and gravity, in numbers\n"
    "  geodesic derive arm.urdf --format latex --output arm.tex\n"
    "  geodesic derive robot.toml --format c --output arm.c M_metric(), Cgrav_forces() in C\n"
    "  geodesic derive robot.toml --format matlab --output functions\n"
    "                                                       M_metric.m, Cgrav_forces.m there\n"
    "  geodesic derive robot.toml --what second_kind --symbols";

// One line on a terminal, rewritten; nothing elsewhere.
class ProgressLine {
 public:
  void show(const derive::Progress& progress) {
    const auto now = std::chrono::steady_clock::now();
    if (!on_ || now - last_ < std::chrono::milliseconds(100)) return;
    last_ = now;
    const auto filled = static_cast<int>(30.0 * progress.part);
    std::string left;
    if (progress.expected > 0) {
      const double seconds = static_cast<double>(progress.expected) * kSecondsPerTerm;
      left = fmt::format(", about {} terms, {:.0f} s in all", progress.expected, seconds);
    }
    say(fmt::format("[{:<30}] {}: {:.0f} %{}", std::string(static_cast<std::size_t>(filled), '#'),
                    progress.stage, 100.0 * progress.part, left));
  }
  void say(const std::string& text) {
    if (!on_) return;
    fmt::print(stderr, "\r\x1b[K{}", text);
    std::fflush(stderr);
    shown_ = true;
  }
  void clear() {
    if (shown_) say("");
  }

 private:
  bool on_ = ::isatty(STDERR_FILENO) == 1;
  bool shown_ = false;
  std::chrono::steady_clock::time_point last_{};
};

derive::Content content_of(const DeriveArguments& arguments) {
  if (arguments.what.empty()) return {};
  if (arguments.is_code()) {
    throw BadInput(
        fmt::format("--what does not go with --format {}: its functions M_metric and "
                    "Cgrav_forces hold everything",
                    arguments.format));
  }
  derive::Content content{false, false, false, false, false};
  for (const std::string& name : arguments.what) {
    if (name == "M") {
      content.metric = true;
    } else if (name == "christoffel") {
      content.christoffel = true;
    } else if (name == "second_kind") {
      content.second_kind = true;
    } else if (name == "g") {
      content.gravity = true;
    } else if (name == "equations") {
      content.metric = content.christoffel = content.gravity = content.equations = true;
    } else {
      throw BadInput(
          fmt::format("--what {}: there is no such thing; expected some of M, "
                      "christoffel, second_kind, g, equations, with commas",
                      name));
    }
  }
  return content;
}

Eigen::Vector3d gravity_of(const DeriveArguments& arguments, const Eigen::Vector3d& of_robot) {
  if (arguments.gravity.empty()) return of_robot;
  const std::vector<double> list = parse_numbers(arguments.gravity, "--gravity x,y,z [m/s²]");
  if (list.size() != 3) throw BadInput("--gravity: expected x,y,z [m/s²]");
  return {list[0], list[1], list[2]};
}

// Where a document goes; nothing: to stdout.
std::vector<fs::path> places(const DeriveArguments& arguments,
                             const std::vector<derive::CodeFile>& files) {
  const bool matlab = arguments.format == "matlab";
  if (arguments.output.empty() && (!matlab || arguments.json)) return {};
  const fs::path output = arguments.output.empty() ? fs::path(".") : fs::path(arguments.output);
  std::vector<fs::path> list;
  for (const derive::CodeFile& file : files) {
    const bool folder = matlab || fs::is_directory(output);
    list.push_back(folder ? output / file.name : output);
  }
  for (const fs::path& path : list) {
    const bool is_file = fs::exists(path) && !fs::is_character_file(path) && !fs::is_fifo(path);
    if (!is_file || arguments.force) continue;
    throw BadInput(
        fmt::format("{} is there already; --force replaces it, --output names another "
                    "place. Nothing was written",
                    path.string()));
  }
  if (!matlab) return list;
  std::error_code error;
  fs::create_directories(output, error);
  if (error) throw BadInput(fmt::format("{}: {}", output.string(), error.message()));
  return list;
}

void write(const DeriveArguments& arguments, const std::vector<derive::CodeFile>& files,
           nlohmann::ordered_json answer) {
  const std::vector<fs::path> paths = places(arguments, files);
  answer["files"] = nlohmann::ordered_json::array();
  {
    const StopSignals both_files_or_none;  // a Ctrl-C waits until all are whole
    for (std::size_t i = 0; i < paths.size(); ++i) write_file(paths[i].string(), files[i].text);
  }
  for (std::size_t i = 0; i < files.size(); ++i) {
    if (paths.empty() && !arguments.json) {
      fmt::print("{}", files[i].text);
    } else if (paths.empty()) {
      answer["files"].push_back({{"name", files[i].name}, {"text", files[i].text}});
    } else if (arguments.json) {
      answer["files"].push_back({{"name", files[i].name}, {"path", paths[i].string()}});
    } else {
      fmt::print("written: {}\n", paths[i].string());
    }
  }
  if (arguments.json) fmt::print("{}\n", answer.dump(2));
}

[[noreturn]] void refuse(const std::string& reason, const DeriveArguments& arguments) {
  throw BadInput(fmt::format(
      "{}. --limit is {} (about {:.0f} s); --limit N sets another one, --yes derives without any",
      reason, arguments.limit, static_cast<double>(arguments.limit) * kSecondsPerTerm));
}

derive::ClosedForm derive_form(const DeriveArguments& arguments, const control::Mechanism& robot,
                               const derive::Content& content, ProgressLine& line) {
  derive::Wanted wanted;
  wanted.christoffel = content.christoffel || content.equations || arguments.is_code();
  wanted.second_kind = content.second_kind;
  wanted.limit = arguments.yes ? 0 : arguments.limit;
  try {
    derive::ClosedForm form =
        derive::derive(derive::symbolic_tree(robot, arguments.symbols), wanted,
                       [&](const derive::Progress& progress) { line.show(progress); });
    derive::use_textbook_letters(form);
    return form;
  } catch (const derive::TooLong& too_long) {
    line.clear();
    refuse(too_long.what(), arguments);
  }
}

int run_derive(const DeriveArguments& arguments) {
  const derive::Content content = content_of(arguments);
  const Subject subject = read_subject(arguments.file);
  derive::ExactTree tree{subject.tree, {}};
  if (!arguments.as_written) tree = derive::exact_tree(subject.tree);
  control::MechanismOptions options;
  if (arguments.rotors) options.rotor_inertia = subject.rotor_inertia;
  const control::Mechanism robot(tree.tree, gravity_of(arguments, subject.gravity), options);
  if (robot.dof() == 0) {
    throw BadInput(fmt::format("{}: no joint of this robot moves", arguments.file));
  }
  const derive::Origin origin{robot.name(), robot.gravity(), arguments.rotors, tree.notes};

  ProgressLine line;
  derive::ClosedForm form = derive_form(arguments, robot, content, line);
  line.say(fmt::format("writing {} terms down", derive::count_terms(form)));
  std::vector<derive::CodeFile> files;
  nlohmann::ordered_json answer{{"robot", origin.robot}, {"terms", derive::count_terms(form)}};
  if (arguments.format == "c") {
    files = {derive::c_code(form, origin)};
  } else if (arguments.format == "matlab") {
    files = derive::matlab_code(form, origin);
  } else if (arguments.format == "latex") {
    files = {{"closed_form.tex", latex_document(form, origin, content, arguments.digits)}};
  } else if (arguments.json && arguments.output.empty()) {
    answer = json_document(form, origin, content);
  } else {
    files = {{"closed_form.txt", text_document(form, origin, content, arguments.digits)}};
  }
  line.clear();
  write(arguments, files, std::move(answer));
  return kExitOk;
}

}  // namespace

void add_derive(CLI::App& app, Run& run) {
  auto arguments = std::make_shared<DeriveArguments>();
  CLI::App* command = app.add_subcommand(
      "derive",
      "Formulas: M(q), Christoffel symbols, g(q), equations of motion; as text, LaTeX, C, MATLAB");
  DeriveArguments& a = *arguments;
  command->add_option("FILE", a.file, "a robot's .toml file, or a URDF")->required();
  command
      ->add_option("--what", a.what,
                   "some of M, christoffel (first kind), second_kind, g, equations (with M, "
                   "christoffel and g) (default: all but second_kind)")
      ->delimiter(',')
      ->type_size(1)
      ->allow_extra_args(false);
  command->add_flag("--symbols", a.symbols,
                    "masses, lengths and inertias as letters (m1, l1, lc1, I1), with their values");
  command->add_option("--format", a.format, "text, latex, c, matlab (for Octave as well)")
      ->check(CLI::IsMember({"text", "latex", "c", "matlab"}))
      ->capture_default_str();
  command->add_option(
      "--output", a.output,
      "file, or folder (matlab: a folder, default the current one; others: stdout)");
  command->add_flag("--force", a.force, "replace files that are there already");
  command->add_option("--gravity", a.gravity,
                      "x,y,z [m/s²], world (default: the file's, 0,0,-9.81 for a URDF)");
  command->add_flag("--rotors", a.rotors, "add the rotor inertia of the robot's file to M");
  command->add_flag("--as-written", a.as_written,
                    "take no figure for an exact one (1.57079632679 for a quarter turn)");
  command->add_option("--digits", a.digits, "significant digits of numbers in text and LaTeX")
      ->check(CLI::Range(1, 17))
      ->capture_default_str();
  command->add_option("--limit", a.limit, "most terms of sines and cosines; beyond, it refuses")
      ->check(CLI::PositiveNumber)
      ->capture_default_str();
  command->add_flag("--yes", a.yes, "no limit: as long as it takes");
  command->add_flag("--json", a.json, "one JSON object; formulas and code as strings in it");
  command->footer(kHelp + footer(kExamples));
  command->callback([arguments, &run] { run = [arguments] { return run_derive(*arguments); }; });
}

}  // namespace geodesic::tools
