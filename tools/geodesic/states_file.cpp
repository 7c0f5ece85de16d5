// The file of states that `geodesic model --states` reads; see the header.
#include "tools/geodesic/states_file.hpp"

#include <fmt/format.h>
#include <fmt/ranges.h>

#include <algorithm>
#include <cerrno>
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

/// A name, or an object with "name" and perhaps idx_q, nq, idx_v, nv; nothing for one without any
/// degree of freedom (some engines list the world).
std::optional<FileJoint> file_joint(const json& joint, const std::string& where) {
  if (joint.is_string()) return FileJoint{joint.get<std::string>(), -1, -1, -1, -1};
  if (!joint.is_object()) throw BadInput(where + ": expected a name, or an object with a name");
  FileJoint result;
  const auto whole_number = [&](const char* key, int& to) {
    const auto found = joint.find(key);
    if (found == joint.end() || found->is_null()) return;
    if (!found->is_number_integer() || *found < 0 || *found > 100000) {
      throw BadInput(fmt::format("{}.{}: expected a whole number from 0 on", where, key));
    }
    to = found->get<int>();
  };
  whole_number("idx_q", result.idx_q);
  whole_number("nq", result.nq);
  whole_number("idx_v", result.idx_v);
  whole_number("nv", result.nv);
  if (result.nv == 0) return std::nullopt;
  const auto name = joint.find("name");
  if (name == joint.end() || !name->is_string()) throw BadInput(where + ".name: expected text");
  result.name = name->get<std::string>();
  return result;
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
    // Six are a motion: linear, then angular.
    const bool motion = gravity.size() == 6 && gravity.tail<3>().isZero(0.0);
    if (gravity.size() != 3 && !motion) {
      throw BadInput(file + ": gravity: expected 3 numbers [m/s²]");
    }
    result.gravity = Eigen::Vector3d(gravity.head<3>());
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
      if (auto joint = file_joint(root["joints"][i], fmt::format("{}: joints[{}]", file, i))) {
        result.joints.push_back(std::move(*joint));
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

std::vector<std::string> free_listed_mimics(const StatesFile& file,
                                            control::TreeDescription& tree) {
  std::vector<std::string> freed;
  for (control::JointDescription& joint : tree.joints) {
    const bool listed = std::any_of(file.joints.begin(), file.joints.end(),
                                    [&](const FileJoint& each) { return each.name == joint.name; });
    if (joint.mimic && listed) {
      joint.mimic.reset();
      freed.push_back(joint.name);
    }
  }
  return freed;
}

bool lists_base(const StatesFile& file, const control::TreeDescription& tree) {
  return std::any_of(file.joints.begin(), file.joints.end(), [&](const FileJoint& each) {
    return each.nv == 6 && std::none_of(tree.joints.begin(), tree.joints.end(),
                                        [&](const auto& own) { return own.name == each.name; });
  });
}

void fit_states(StatesFile& file, const control::Mechanism& mechanism, const std::string& name) {
  const int q_size = file.states.empty() ? -1 : static_cast<int>(file.states.front().q.size());
  file.layout.emplace(mechanism, file.joints, q_size, name);
  const StatesLayout& layout = *file.layout;
  file.as_written = file.states;
  for (std::size_t i = 0; i < file.states.size(); ++i) {
    EvaluationState& written = file.as_written[i];
    EvaluationState& state = file.states[i];
    const std::string where = fmt::format("{}: states[{}]", name, i);
    fit(written.q, layout.nq(), "q", false, where);
    fit(written.v, layout.nv(), "v", true, where);
    fit(written.a, layout.nv(), "a", true, where);
    state = written;
    state.q = layout.own_q(written.q, where);
    if (layout.plain()) continue;
    const Eigen::MatrixXd own_from_file = layout.own_from_file(state.q);
    state.v = own_from_file * written.v;
    state.a = own_from_file * written.a + layout.own_from_file_rate(state.q, state.v) * written.v;
  }
}

}  // namespace geodesic::tools
