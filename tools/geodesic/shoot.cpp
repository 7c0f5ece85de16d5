// `geodesic shoot`: geodesics of a robot's kinetic-energy metric, from a state or between two
// configurations.
#include <fmt/format.h>
#include <fmt/ranges.h>
#include <unistd.h>

#include <CLI/CLI.hpp>
#include <algorithm>
#include <cmath>
#include <cstdio>
#include <memory>
#include <nlohmann/json.hpp>

#include "control/mechanism/configuration.hpp"
#include "control/mechanism/kinematics.hpp"
#include "tools/geodesic/command.hpp"
#include "tools/geodesic/shoot_output.hpp"
#include "tools/geodesic/subject.hpp"
#include "tools/sim/script.hpp"

namespace geodesic::tools {
namespace {

struct ShootArguments {
  std::string file;
  std::string q;
  std::string v;
  std::string to;
  std::string gravity;
  std::string frame;
  std::string integrator = "variational";
  std::string csv;
  std::string plot;
  double duration = 1.0;
  int steps = 1000;
  int samples = 1000;
  bool floating = false;
  bool rotors = false;
  bool json = false;
};

constexpr const char* kExamples =
    "  geodesic shoot arm.urdf --q 0,0.5 --v 1,-1 --plot way.png     free motion from a state\n"
    "  geodesic shoot robot.toml --from 0,0 --to 1.2,-0.8            the motion of least action\n"
    "  geodesic shoot arm.urdf --floating --v 0,0,0,0,0,1,2,-1 --duration 1000 --steps 1000000";

/// A bar on the terminal, redrawn in place; nothing where stderr is no terminal.
class ProgressBar {
 public:
  explicit ProgressBar(std::string what)
      : what_(std::move(what)), on_(::isatty(STDERR_FILENO) == 1) {}
  ~ProgressBar() {
    if (drawn_ >= 0) fmt::print(stderr, "\r\033[K");
  }
  ProgressBar(const ProgressBar&) = delete;
  ProgressBar& operator=(const ProgressBar&) = delete;
  void operator()(double share) {
    constexpr int kWidth = 40;
    const int percent = static_cast<int>(100.0 * share);
    if (!on_ || percent == drawn_) return;
    drawn_ = percent;
    const auto full = static_cast<std::size_t>(kWidth * percent / 100);
    fmt::print(stderr, "\r{} [{:<{}}] {:>3} %", what_, std::string(full, '#'), kWidth, percent);
    std::fflush(stderr);
  }

 private:
  std::string what_;
  bool on_;
  int drawn_ = -1;
};

/// Numbers of an option, as many as the mechanism has, quaternions of unit length.
Eigen::VectorXd vector_of(const std::string& text, const char* option, int size,
                          const std::string& of_what) {
  const std::vector<double> list =
      parse_numbers(text, fmt::format("{} with {} numbers a,b,c...", option, size));
  if (list.size() != static_cast<std::size_t>(size)) {
    throw BadInput(fmt::format("{}: found {} number{}, expected {}: {}", option, list.size(),
                               list.size() == 1 ? "" : "s", size, of_what));
  }
  return Eigen::Map<const Eigen::VectorXd>(list.data(), size);
}

Eigen::VectorXd configuration_of(const std::string& text, const char* option,
                                 const control::Mechanism& mechanism) {
  Eigen::VectorXd q = vector_of(text, option, mechanism.nq(),
                                fmt::format("{}", fmt::join(coordinate_names(mechanism), ", ")));
  for (const control::Factor& factor : mechanism.factors()) {
    if (factor.nq == factor.nv) continue;
    auto quaternion = q.segment<4>(factor.q + factor.nq - 4);
    const double length = quaternion.norm();
    if (!(std::abs(length - 1.0) <= 1e-3)) {
      throw BadInput(fmt::format(
          "{}: the quaternion x y z w of {} has length {:.6g}, expected 1; at rest it is 0,0,0,1",
          option, factor.name, length));
    }
    quaternion /= length;
  }
  return q;
}

int find_frame(const control::Mechanism& mechanism, const std::string& name) {
  if (name.empty()) return static_cast<int>(mechanism.links().size()) - 1;
  if (const auto found = mechanism.find_link(name)) return *found;
  std::vector<std::string> names;
  for (const control::LinkFrame& link : mechanism.links()) names.push_back(link.name);
  throw BadInput(fmt::format("there is no link '{}'; links: {}", name, fmt::join(names, ", ")));
}

void check(const ShootArguments& arguments) {
  if (!arguments.to.empty() && !arguments.v.empty()) {
    throw BadInput(
        "--to and --v exclude one another: the way to a configuration finds its own "
        "velocity");
  }
  if (!arguments.to.empty() && !arguments.gravity.empty()) {
    throw BadInput(
        "--to and --gravity exclude one another: the motion of least kinetic action "
        "knows no gravity");
  }
  if (!std::isfinite(arguments.duration) || !(arguments.duration > 0.0)) {
    throw BadInput(fmt::format("--duration {}: expected seconds above 0", arguments.duration));
  }
}

std::string advice(const control::GeodesicBetween& found) {
  using control::GeodesicOutcome;
  const std::string reached =
      fmt::format("solved for {:.1f} % of the way in {} rounds; the end is missed by {:.2g}",
                  100.0 * found.solved, found.shots, found.miss);
  switch (found.outcome) {
    case GeodesicOutcome::kConjugate:
      return fmt::format(
          "no geodesic found: {}. Newton's iteration met a conjugate point, where many geodesics "
          "meet and the end does not tell the start's velocity. Move --to a little, or go by a "
          "configuration between",
          reached);
    case GeodesicOutcome::kSingularMetric:
      return fmt::format(
          "no geodesic found: {}. The metric is singular there: a joint moves no mass (--rotors "
          "adds the motors' inertia of a robot's file)",
          reached);
    default:
      return fmt::format(
          "no geodesic found: {}. The ends may be too far apart for one shot; go by a "
          "configuration "
          "between, or take more --steps",
          reached);
  }
}

void solve_between(const control::Mechanism& mechanism, const Eigen::VectorXd& from,
                   const Eigen::VectorXd& to, Shot& shot) {
  control::GeodesicOptions options;
  options.duration_s = shot.options.duration_s;
  options.steps = shot.options.steps;
  ProgressBar bar("geodesic");
  options.on_progress = [&bar](double share) { bar(share); };
  Comparison comparison;
  comparison.found = control::geodesic_between(mechanism, from, to, options);
  if (comparison.found.outcome != control::GeodesicOutcome::kFound) {
    throw BadInput(advice(comparison.found));
  }
  const Eigen::VectorXd& v = comparison.found.start_velocity;
  comparison.geodesic =
      control::geodesic_action(mechanism, from, v, options.duration_s, options.steps);
  comparison.straight =
      control::straight_action(mechanism, from, to, options.duration_s, options.steps);
  shot.motion = shoot(mechanism, from, v, shot.options);
  comparison.line = straight_samples(mechanism, shot.motion, to, shot.options.frame);
  shot.between = std::move(comparison);
}

int run_shoot(const ShootArguments& arguments) {
  check(arguments);
  const Subject subject = read_subject(arguments.file);
  Eigen::Vector3d gravity = Eigen::Vector3d::Zero();
  if (!arguments.gravity.empty()) {
    gravity = vector_of(arguments.gravity, "--gravity", 3, "x,y,z [m/s²]");
  }
  control::MechanismOptions options;
  if (arguments.floating) options.base = control::Base::kFloating;
  if (arguments.rotors) options.rotor_inertia = subject.rotor_inertia;
  const control::Mechanism mechanism(subject.tree, gravity, options);
  Shot shot;
  shot.robot = subject.tree.name;
  shot.options = {arguments.duration,
                  arguments.steps,
                  arguments.samples,
                  Integrator::kVariational,
                  find_frame(mechanism, arguments.frame.empty() ? subject.frame : arguments.frame),
                  {}};
  shot.frame = mechanism.links()[static_cast<std::size_t>(shot.options.frame)].name;
  Eigen::VectorXd q = control::neutral(mechanism);
  if (!arguments.q.empty()) q = configuration_of(arguments.q, "--q (--from)", mechanism);
  if (!arguments.to.empty()) {
    shot.options.integrator = Integrator::kMuntheKaas;
    solve_between(mechanism, q, configuration_of(arguments.to, "--to", mechanism), shot);
  } else {
    Eigen::VectorXd v = Eigen::VectorXd::Zero(mechanism.dof());
    if (!arguments.v.empty()) {
      v = vector_of(arguments.v, "--v", mechanism.dof(),
                    mechanism.floating() ? "linear (3), angular (3), joints" : "one a joint");
    }
    if (arguments.integrator == "runge-kutta") shot.options.integrator = Integrator::kMuntheKaas;
    ProgressBar bar("motion");
    shot.options.on_progress = [&bar](double share) { bar(share); };
    shot.motion = shoot(mechanism, q, v, shot.options);
  }
  shot.conservation = judge(mechanism, shot.motion);
  if (!arguments.csv.empty()) write_file(arguments.csv, to_csv(mechanism, shot.motion));
  if (arguments.json || !arguments.plot.empty()) {
    const nlohmann::ordered_json answer = to_json(mechanism, shot);
    if (!arguments.plot.empty()) draw(mechanism, answer, arguments.plot);
    if (arguments.json) fmt::print("{}\n", answer.dump());
  }
  if (!arguments.json) print(mechanism, shot);
  return kExitOk;
}

}  // namespace

void add_shoot(CLI::App& app, Run& run) {
  auto arguments = std::make_shared<ShootArguments>();
  CLI::App* command = app.add_subcommand(
      "shoot", "Geodesics: free motion from a state, or the motion of least action between two");
  ShootArguments& a = *arguments;
  command->add_option("FILE", a.file, "a URDF, or a robot's .toml file")->required();
  command->add_option("--q,--from", a.q, "start configuration a,b,c... (default: all 0)");
  command->add_option("--v", a.v, "start velocity a,b,c... (default: at rest)");
  command->add_option("--to", a.to, "end configuration: find the geodesic from --from to there");
  command->add_option("--duration", a.duration, "seconds from end to end (default 1)");
  command->add_option("--steps", a.steps, "steps of the integrator (default 1000)")
      ->check(CLI::Range(1, 1000000000));
  command->add_option("--samples", a.samples, "instants that are kept and shown (default 1000)")
      ->check(CLI::Range(2, 1000000));
  command
      ->add_option("--integrator", a.integrator,
                   "variational (keeps momentum; default) or runge-kutta (Munthe-Kaas, order 4; "
                   "always with --to)")
      ->check(CLI::IsMember({"variational", "runge-kutta"}));
  command->add_option(
      "--gravity", a.gravity,
      "x,y,z [m/s²], world: let it fall (default: none, as when it is compensated)");
  command->add_option("--frame", a.frame,
                      "link whose way is shown (default: the file's tool, or the last link)");
  command->add_flag("--floating", a.floating, "the root link moves freely");
  command->add_flag("--rotors", a.rotors, "add the rotor inertia of the robot's file to M");
  command->add_option("--csv", a.csv, "write the motion's figures there, one line an instant");
  command->add_option("--plot", a.plot,
                      "draw it there (PNG, SVG or PDF); needs python3-matplotlib");
  command->add_flag("--json", a.json, "one JSON object, 17 significant digits");
  command->footer(
      "\nA geodesic of the kinetic-energy metric is what an arm does whose gravity is compensated\n"
      "and that is left alone. Units: rad, m, s. Negative numbers first: --v=-1,0.\n"
      "Floating base: q = [position, quaternion x y z w, joints], v = [linear, angular, joints] "
      "with\n"
      "the base's velocities in its own axes." +
      footer(kExamples));
  command->callback([arguments, &run] { run = [arguments] { return run_shoot(*arguments); }; });
}

}  // namespace geodesic::tools
