// `geodesic model`: the geometry and dynamics of a URDF or robot at given states.
#include <fmt/format.h>
#include <fmt/ranges.h>

#include <CLI/CLI.hpp>
#include <cstdio>
#include <memory>
#include <nlohmann/json.hpp>
#include <numbers>

#include "control/mechanism/configuration.hpp"
#include "tools/geodesic/command.hpp"
#include "tools/geodesic/evaluation.hpp"
#include "tools/geodesic/model_print.hpp"
#include "tools/geodesic/quantities.hpp"
#include "tools/geodesic/states_file.hpp"
#include "tools/geodesic/subject.hpp"
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
  std::vector<std::string> what;
  std::vector<std::string> wrenches;
  std::string x;
  std::string y;
  std::string p;
  std::string motion;
  bool floating = false;
  bool rotors = false;
  bool christoffel = false;
  bool json = false;
};

constexpr const char* kExamples =
    "  geodesic model arm.urdf                            masses, pose, M and g with all joints at "
    "0\n"
    "  geodesic model robot.toml --q=0.1,-0.5             at a pose\n"
    "  geodesic model robot.toml --q=0.1,-0.5 --what christoffel_second_kind,curvature\n"
    "  geodesic model arm.urdf --what tau_ext --wrench tool:0,0,-5,0,0,0\n"
    "  geodesic model arm.urdf --states states.json --json\n"
    "  geodesic model dog.urdf --floating --states states.json --json";

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

/// A link, or a joint: its child link, whose frame is the joint's.
int find_frame(const control::Mechanism& mechanism, const control::TreeDescription& tree,
               const std::string& name) {
  if (name.empty()) return static_cast<int>(mechanism.links().size()) - 1;
  if (const auto found = mechanism.find_link(name)) return *found;
  for (const control::JointDescription& joint : tree.joints) {
    if (joint.name == name) return mechanism.find_link(joint.child_link).value();
  }
  std::vector<std::string> names;
  for (const control::LinkFrame& link : mechanism.links()) names.push_back(link.name);
  throw BadInput(fmt::format("there is no link '{}'; links: {}", name, fmt::join(names, ", ")));
}

/// What a person wants to see who asked for nothing in particular.
std::vector<std::string> usual_quantities(bool floating) {
  std::vector<std::string> names{"g",    "Cv",   "tau", "M", "kinetic_energy", "potential_energy",
                                 "ee_p", "ee_R", "J_ee"};
  if (floating) {
    for (const char* name : {"com", "vcom", "hg_linear", "hg_angular"}) names.emplace_back(name);
  }
  return names;
}

std::vector<std::string> names_in(const std::vector<std::string>& lists) {
  std::vector<std::string> names;
  for (const std::string& list : lists) {
    std::size_t begin = 0;
    while (begin <= list.size()) {
      const std::size_t end = std::min(list.find_first_of(", ", begin), list.size());
      if (end > begin) names.push_back(list.substr(begin, end - begin));
      begin = end + 1;
    }
  }
  for (const std::string& name : names) find_quantity(name);
  return names;
}

/// LINK:fx,fy,fz,mx,my,mz
control::ExternalWrench read_wrench(const control::Mechanism& mechanism,
                                    const control::TreeDescription& tree, const std::string& text) {
  constexpr const char* kForm =
      "--wrench LINK:fx,fy,fz,mx,my,mz [N, N·m], world axes, moment about the link's origin";
  const std::size_t colon = text.rfind(':');
  if (colon == std::string::npos)
    throw BadInput(fmt::format("found '{}', expected {}", text, kForm));
  const Eigen::VectorXd six = numbers(text.substr(colon + 1), kForm);
  if (six.size() != 6)
    throw BadInput(fmt::format("found {} numbers, expected {}", six.size(), kForm));
  return {find_frame(mechanism, tree, text.substr(0, colon)),
          control::Frame::kLinkOrigin,
          {six.head<3>(), six.tail<3>()}};
}

EvaluationRequest request_of(const ModelArguments& arguments, const control::Mechanism& mechanism,
                             const control::TreeDescription& tree, const std::string& frame,
                             bool christoffel) {
  EvaluationRequest request;
  request.frame = find_frame(mechanism, tree, frame);
  request.what = names_in(arguments.what);
  if (request.what.empty()) {
    request.what = arguments.json ? reference_quantities(mechanism.floating())
                                  : usual_quantities(mechanism.floating());
    if (christoffel) request.what.emplace_back("christoffel_first_kind");
  }
  for (const std::string& wrench : arguments.wrenches) {
    request.wrenches.push_back(read_wrench(mechanism, tree, wrench));
  }
  if (!arguments.x.empty()) request.x = numbers(arguments.x, "--x a,b,c");
  if (!arguments.y.empty()) request.y = numbers(arguments.y, "--y a,b,c");
  if (!arguments.p.empty()) request.p = numbers(arguments.p, "--p a,b,c");
  if (!arguments.motion.empty()) {
    constexpr const char* kForm =
        "--motion vx,vy,vz,wx,wy,wz: velocity at the world's origin, turn";
    const Eigen::VectorXd six = numbers(arguments.motion, kForm);
    if (six.size() != 6) throw BadInput(fmt::format("expected six numbers: {}", kForm));
    request.motion = control::Twist{six.head<3>(), six.tail<3>()};
  }
  return request;
}

int run_model(const ModelArguments& arguments) {
  if (arguments.what == std::vector<std::string>{"list"}) {
    fmt::print("{}", list_quantities());
    return kExitOk;
  }
  const bool with_states = !arguments.states.empty();
  if (with_states && !(arguments.q.empty() && arguments.v.empty() && arguments.a.empty())) {
    throw BadInput("--states and --q, --v, --a exclude one another");
  }
  Subject subject = read_subject(arguments.file);
  StatesFile file = with_states ? read_states(arguments.states) : StatesFile();
  if (file.gravity) subject.gravity = *file.gravity;
  if (!arguments.gravity.empty()) {
    const Eigen::VectorXd gravity = numbers(arguments.gravity, "--gravity x,y,z [m/s²]");
    if (gravity.size() != 3) throw BadInput("--gravity: expected x,y,z [m/s²]");
    subject.gravity = Eigen::Vector3d(gravity);
  }
  if (file.frame) subject.frame = *file.frame;
  if (!arguments.frame.empty()) subject.frame = arguments.frame;

  for (const std::string& joint : free_listed_mimics(file, subject.tree)) {
    fmt::print(stderr, "{}: joints lists {}, a mimic joint: it is taken as independent\n",
               arguments.states, joint);
  }

  control::MechanismOptions options;
  const bool floating =
      arguments.floating || file.floating.value_or(lists_base(file, subject.tree));
  options.base = floating ? control::Base::kFloating : control::Base::kFixed;
  if (arguments.rotors) options.rotor_inertia = subject.rotor_inertia;
  const control::Mechanism mechanism(subject.tree, subject.gravity, options);
  control::Workspace workspace(mechanism);
  file = states_of(arguments, mechanism, std::move(file));
  const StatesLayout& layout = *file.layout;
  const EvaluationRequest request = request_of(arguments, mechanism, subject.tree, subject.frame,
                                               arguments.christoffel || file.christoffel);
  const std::string& frame_name = mechanism.links()[static_cast<std::size_t>(request.frame)].name;

  nlohmann::ordered_json answer{{"robot", subject.tree.name},
                                {"source", "geodesic " GEODESIC_VERSION},
                                {"floating_base", floating},
                                {"nq", layout.nq()},
                                {"nv", layout.nv()},
                                {"gravity", to_json(Eigen::VectorXd(subject.gravity))},
                                {"ee_frame", frame_name},
                                {"joints", joints_json(mechanism, layout)},
                                {"moving_mass", mechanism.moving_mass()},
                                {"states", nlohmann::ordered_json::array()}};
  for (std::size_t i = 0; i < file.states.size(); ++i) {
    answer["states"].push_back(
        evaluate(mechanism, workspace, file.states[i], file.as_written[i], layout, request));
  }
  if (arguments.json) {
    fmt::print("{}\n", answer.dump());
    return kExitOk;
  }
  print_robot(subject.tree, mechanism);
  for (const auto& state : answer["states"]) {
    fmt::print("\n");
    print_state(state, request.what, frame_name);
  }
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
  command->add_option("--what", a.what,
                      "names of quantities, e.g. M,g,curvature; --what list: all of them");
  command->add_option("--wrench", a.wrenches,
                      "LINK:fx,fy,fz,mx,my,mz on a link, world axes; tau_ext, tau_motors");
  command->add_option("--x", a.x, "a direction (default v): flat, curvature");
  command->add_option("--y", a.y, "another direction: sectional_curvature, curvature_covector");
  command->add_option("--p", a.p, "a covector (default tau): sharp, acceleration");
  command->add_option("--motion", a.motion,
                      "vx,vy,vz,wx,wy,wz: rigid motion of space whose momentum_map is asked for");
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
