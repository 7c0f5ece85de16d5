// The file of states that `geodesic model --states` reads; see the header.
#include "tools/geodesic/states_file.hpp"

#include <fmt/format.h>
#include <fmt/ranges.h>

#include <cerrno>
#include <cmath>
#include <cstring>
#include <fstream>
#include <nlohmann/json.hpp>

#include "tools/geodesic/command.hpp"

namespace geodesic::tools {
namespace {

using nlohmann::json;

Eigen::VectorXd vector_of(const json& value, const std::string& where) {
  if (!value.is_array()) throw BadInput(where + ": expected a list of numbers");
  Eigen::VectorXd result(static_cast<Eigen::Index>(value.size()));
  for (std::size_t i = 0; i < value.size(); ++i) {
    if (!value[i].is_number()) {
      throw BadInput(fmt::format("{}[{}]: expected a number, found {}", where, i, value[i].dump()));
    }
    result[static_cast<Eigen::Index>(i)] = value[i].get<double>();
  }
  return result;
}

Eigen::VectorXd member(const json& state, const char* key, const std::string& where) {
  const auto found = state.find(key);
  if (found == state.end()) return {};
  return vector_of(*found, fmt::format("{}.{}", where, key));
}

/// A name, or an object with "name" and "nv". References list the floating base among the joints:
/// it has another nv and is not one of ours.
std::optional<std::string> joint_name(const json& joint, const std::string& where) {
  if (joint.is_string()) return joint.get<std::string>();
  if (!joint.is_object()) throw BadInput(where + ": expected a name, or an object with a name");
  const auto nv = joint.find("nv");
  if (nv != joint.end() && !nv->is_number()) throw BadInput(where + ".nv: expected a number");
  if (nv != joint.end() && *nv != 1) return std::nullopt;
  const auto name = joint.find("name");
  if (name == joint.end() || !name->is_string()) throw BadInput(where + ".name: expected text");
  return name->get<std::string>();
}

void fit(Eigen::VectorXd& vector, int size, const char* what, bool may_be_missing,
         const std::string& where) {
  if (vector.size() == 0 && may_be_missing) vector = Eigen::VectorXd::Zero(size);
  if (vector.size() != size) {
    throw BadInput(
        fmt::format("{}.{}: expected {} numbers, found {}", where, what, size, vector.size()));
  }
  if (!vector.allFinite()) throw BadInput(fmt::format("{}.{}: not finite", where, what));
}

}  // namespace

StatesFile read_states(const std::string& file) {
  std::ifstream stream(file);
  if (!stream) throw BadInput("cannot read " + file + ": " + std::strerror(errno));
  json root;
  try {
    root = json::parse(stream);
  } catch (const json::exception& error) {  // not only parse errors: 1e999 is out of range
    throw BadInput(file + ": no JSON: " + error.what());
  }
  if (!root.is_object() || !root.contains("states") || !root["states"].is_array()) {
    throw BadInput(file + R"(: expected an object with "states": [{"q": [...], ...}, ...])");
  }
  StatesFile result;
  if (root.contains("gravity")) {
    const Eigen::VectorXd gravity = vector_of(root["gravity"], file + ": gravity");
    if (gravity.size() != 3) throw BadInput(file + ": gravity: expected 3 numbers [m/s²]");
    result.gravity = Eigen::Vector3d(gravity);
  }
  if (root.contains("ee_frame")) {
    if (!root["ee_frame"].is_string()) throw BadInput(file + ": ee_frame: expected a link's name");
    result.frame = root["ee_frame"].get<std::string>();
  }
  if (root.contains("floating_base")) {
    if (!root["floating_base"].is_boolean()) {
      throw BadInput(file + ": floating_base: expected true or false");
    }
    result.floating = root["floating_base"].get<bool>();
  }
  if (root.contains("joints") && root["joints"].is_array()) {
    for (std::size_t i = 0; i < root["joints"].size(); ++i) {
      if (auto name = joint_name(root["joints"][i], fmt::format("{}: joints[{}]", file, i))) {
        result.joints.push_back(std::move(*name));
      }
    }
  }
  for (std::size_t i = 0; i < root["states"].size(); ++i) {
    const json& state = root["states"][i];
    const std::string where = fmt::format("{}: states[{}]", file, i);
    if (!state.is_object()) throw BadInput(where + ": expected an object");
    if (!state.contains("q")) throw BadInput(where + ": q is missing");
    result.states.push_back(
        {member(state, "q", where), member(state, "v", where), member(state, "a", where)});
    result.christoffel = result.christoffel || state.contains("christoffel_first_kind");
  }
  return result;
}

void fit_states(StatesFile& file, const control::Mechanism& mechanism, const std::string& name) {
  if (!file.joints.empty() && file.joints != mechanism.joint_names()) {
    throw BadInput(fmt::format("{}: joints: the file's order is {}; this robot's is {}", name,
                               fmt::join(file.joints, ", "),
                               fmt::join(mechanism.joint_names(), ", ")));
  }
  for (std::size_t i = 0; i < file.states.size(); ++i) {
    EvaluationState& state = file.states[i];
    const std::string where = fmt::format("{}: states[{}]", name, i);
    fit(state.q, mechanism.nq(), "q", false, where);
    fit(state.v, mechanism.dof(), "v", true, where);
    fit(state.a, mechanism.dof(), "a", true, where);
    if (mechanism.floating() && std::abs(state.q.segment<4>(3).norm() - 1.0) > 1e-6) {
      throw BadInput(where + ".q: elements 3 to 6 must be a unit quaternion (x y z w)");
    }
  }
}

}  // namespace geodesic::tools
