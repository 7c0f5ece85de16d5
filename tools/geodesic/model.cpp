// `geodesic model`: the geometry and dynamics of a URDF or robot at given states.
#include <fmt/format.h>
#include <fmt/ranges.h>

#include <CLI/CLI.hpp>
#include <Eigen/Geometry>
#include <cstdio>
#include <filesystem>
#include <memory>
#include <nlohmann/json.hpp>
#include <numbers>

#include "config/urdf.hpp"
#include "tools/geodesic/command.hpp"
#include "tools/geodesic/evaluation.hpp"
#include "tools/geodesic/states_file.hpp"
#include "tools/sim/script.hpp"

namespace geodesic::tools {
namespace {

struct ModelArguments {
  std::string file;
  std::string states;
  std::string q;
  std::string v;
  std::string a;
  std::string gravity;
  std::string frame;
  bool floating = false;
  bool rotors = false;
  bool christoffel = false;
  bool json = false;
};

constexpr const char* kExamples =
    "  geodesic model arm.urdf                            masses, pose, M and g with all joints at "
    "0\n"
    "  geodesic model robot.toml --q=0.1,-0.5             at a pose\n"
    "  geodesic model arm.urdf --states states.json --json\n"
    "  geodesic model dog.urdf --floating --states states.json --json";

// What is evaluated, from a URDF or from a robot's file.
struct Subject {
  control::TreeDescription tree;
  Eigen::Vector3d gravity{0.0, 0.0, -9.81};
  std::string frame;
  Eigen::VectorXd rotor_inertia;
};

Subject read_subject(const ModelArguments& arguments) {
  Subject subject;
  if (std::filesystem::path(arguments.file).extension() == ".toml") {
    const config::Robot robot = load({arguments.file, {}, false});
    subject.tree = robot.tree;
    subject.gravity = robot.gravity;
    subject.frame = robot.tool_link;
    subject.rotor_inertia.resize(static_cast<Eigen::Index>(robot.controller.joints.size()));
    for (std::size_t i = 0; i < robot.controller.joints.size(); ++i) {
      subject.rotor_inertia[static_cast<Eigen::Index>(i)] =
          robot.controller.joints[i].rotor_inertia;
    }
    return subject;
  }
  config::UrdfResult urdf = config::load_urdf(arguments.file, false);
  for (const config::Message& message : urdf.messages) {
    fmt::print(stderr, "{}\n", config::to_string(message));
  }
  if (!urdf.ok) throw BadInput("");
  subject.tree = std::move(urdf.tree);
  return subject;
}

Eigen::VectorXd numbers(const std::string& text, const char* what) {
  const std::vector<double> list = parse_numbers(text, what);
  return Eigen::Map<const Eigen::VectorXd>(list.data(), static_cast<Eigen::Index>(list.size()));
}

StatesFile states_of(const ModelArguments& arguments, const control::Mechanism& mechanism,
                     StatesFile file) {
  if (!arguments.states.empty()) {
    fit_states(file, mechanism, arguments.states);
    return file;
  }
  EvaluationState state{control::neutral(mechanism), {}, {}};
  if (!arguments.q.empty()) state.q = numbers(arguments.q, "--q a,b,c");
  if (!arguments.v.empty()) state.v = numbers(arguments.v, "--v a,b,c");
  if (!arguments.a.empty()) state.a = numbers(arguments.a, "--a a,b,c");
  file.states.push_back(state);
  fit_states(file, mechanism, "command line");
  return file;
}

int find_frame(const control::Mechanism& mechanism, const std::string& name) {
  if (name.empty()) return static_cast<int>(mechanism.links().size()) - 1;
  if (const auto found = mechanism.find_link(name)) return *found;
  std::vector<std::string> names;
  for (const control::LinkFrame& link : mechanism.links()) names.push_back(link.name);
  throw BadInput(fmt::format("there is no link '{}'; links: {}", name, fmt::join(names, ", ")));
}

void print_vector(const char* name, const nlohmann::ordered_json& values, const char* unit) {
  fmt::print("{:<4}", name);
  for (const auto& value : values) fmt::print(" {:>12.6g}", value.get<double>());
  fmt::print("  {}\n", unit);
}

void print_matrix(const char* name, const nlohmann::ordered_json& rows) {
  if (rows.is_null()) {
    fmt::print("{}: singular\n", name);
    return;
  }
  fmt::print("{}\n", name);
  for (const auto& row : rows) print_vector("", row, "");
}

void print_masses(const control::TreeDescription& tree, const control::Mechanism& mechanism) {
  fmt::print("robot {}: {} joint{}, {:.6g} kg that move\n\n", tree.name,
             mechanism.joint_names().size(), mechanism.joint_names().size() == 1 ? "" : "s",
             mechanism.moving_mass());
  fmt::print("{:<32}{:>10}   {:<32}\n", "link", "mass [kg]", "centre of mass [m]");
  for (const control::LinkDescription& link : tree.links) {
    if (link.inertia.mass_kg <= 0.0) continue;
    const Eigen::Vector3d& com = link.inertia.com_m;
    fmt::print("{:<32}{:>10.4f}   {:>9.4f} {:>9.4f} {:>9.4f}\n", link.name, link.inertia.mass_kg,
               com.x(), com.y(), com.z());
  }
}

void print_state(const nlohmann::ordered_json& state, const control::Mechanism& mechanism,
                 const std::string& frame) {
  fmt::print("\njoints: {}\n", fmt::join(mechanism.joint_names(), ", "));
  print_vector("q", state["q"], "rad, m");
  print_vector("v", state["v"], "rad/s, m/s");
  print_vector("a", state["a"], "rad/s², m/s²");
  print_vector("g", state["g"], "N·m, N: holds the arm");
  print_vector("Cv", state["Cv"], "N·m, N");
  print_vector("tau", state["tau"], "N·m, N: M a + C v + g");
  print_matrix("M [kg·m², kg·m, kg]", state["M"]);
  print_matrix("Minv", state["Minv"]);
  print_matrix("C", state["C"]);
  fmt::print("kinetic energy {:.6g} J, potential energy {:.6g} J\n",
             state["kinetic_energy"].get<double>(), state["potential_energy"].get<double>());
  fmt::print("{} in the world:\n", frame);
  print_vector("p", state["ee_p"], "m");
  print_matrix("R", state["ee_R"]);
  print_matrix("J (linear, then angular velocity; world axes)", state["J_ee"]);
  if (!mechanism.floating()) return;
  print_vector("com", state["com"], "m");
  print_vector("vcom", state["vcom"], "m/s");
  print_vector("h", state["hg_linear"], "kg·m/s");
  print_vector("L", state["hg_angular"], "kg·m²/s about the centre of mass");
}

int run_model(const ModelArguments& arguments) {
  const bool with_states = !arguments.states.empty();
  if (with_states && !(arguments.q.empty() && arguments.v.empty() && arguments.a.empty())) {
    throw BadInput("--states and --q, --v, --a exclude one another");
  }
  Subject subject = read_subject(arguments);
  StatesFile file = with_states ? read_states(arguments.states) : StatesFile();
  if (file.gravity) subject.gravity = *file.gravity;
  if (!arguments.gravity.empty()) {
    const Eigen::VectorXd gravity = numbers(arguments.gravity, "--gravity x,y,z [m/s²]");
    if (gravity.size() != 3) throw BadInput("--gravity: expected x,y,z [m/s²]");
    subject.gravity = Eigen::Vector3d(gravity);
  }
  if (file.frame) subject.frame = *file.frame;
  if (!arguments.frame.empty()) subject.frame = arguments.frame;

  control::MechanismOptions options;
  const bool floating = arguments.floating || file.floating.value_or(false);
  options.base = floating ? control::Base::kFloating : control::Base::kFixed;
  if (arguments.rotors) options.rotor_inertia = subject.rotor_inertia;
  const control::Mechanism mechanism(subject.tree, subject.gravity, options);
  control::Workspace workspace(mechanism);
  file = states_of(arguments, mechanism, std::move(file));
  const int frame = find_frame(mechanism, subject.frame);
  const std::string& frame_name = mechanism.links()[static_cast<std::size_t>(frame)].name;

  nlohmann::ordered_json answer{{"robot", subject.tree.name},
                                {"source", "geodesic " GEODESIC_VERSION},
                                {"floating_base", floating},
                                {"nq", mechanism.nq()},
                                {"nv", mechanism.dof()},
                                {"gravity", to_json(Eigen::VectorXd(subject.gravity))},
                                {"ee_frame", frame_name},
                                {"joints", joints_json(mechanism)},
                                {"moving_mass", mechanism.moving_mass()},
                                {"states", nlohmann::ordered_json::array()}};
  const bool christoffel = arguments.christoffel || file.christoffel;
  for (const EvaluationState& state : file.states) {
    answer["states"].push_back(evaluate(mechanism, workspace, state, frame, christoffel));
  }
  if (arguments.json) {
    fmt::print("{}\n", answer.dump());
    return kExitOk;
  }
  print_masses(subject.tree, mechanism);
  for (const auto& state : answer["states"]) print_state(state, mechanism, frame_name);
  return kExitOk;
}

}  // namespace

void add_model(CLI::App& app, Run& run) {
  auto arguments = std::make_shared<ModelArguments>();
  CLI::App* command = app.add_subcommand(
      "model", "Mass matrix, Coriolis, gravity, Jacobian, energies... of a URDF or a robot's file");
  ModelArguments& a = *arguments;
  command->add_option("FILE", a.file, "a URDF, or a robot's .toml file")->required();
  command->add_option("--states", a.states,
                      "a JSON file with states[].{q,v,a}; its gravity, ee_frame and floating_base "
                      "count too");
  command->add_option("--q", a.q, "configuration a,b,c... [rad or m] (default: all 0)");
  command->add_option("--v", a.v, "velocity a,b,c...");
  command->add_option("--a", a.a, "acceleration a,b,c...");
  command->add_option("--gravity", a.gravity, "x,y,z [m/s²], world (default 0,0,-9.81)");
  command->add_option("--frame", a.frame,
                      "link of pose and Jacobian (default: the file's tool, or the last link)");
  command->add_flag("--floating", a.floating, "the root link moves freely");
  command->add_flag("--rotors", a.rotors, "add the rotor inertia of the robot's file to M");
  command->add_flag("--christoffel", a.christoffel, "add the Christoffel symbols (first kind)");
  command->add_flag("--json", a.json, "one JSON object, 17 significant digits");
  command->footer(
      "\nJoints: depth first, siblings by name. tau = M a + C v + g, C of Christoffel symbols.\n"
      "Floating base: q = [position, quaternion x y z w, joints], v = [linear, angular, joints] "
      "with\n"
      "the base's velocities in its own axes." +
      footer(kExamples));
  command->callback([arguments, &run] { run = [arguments] { return run_model(*arguments); }; });
}

}  // namespace geodesic::tools
