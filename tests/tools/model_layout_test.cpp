// `geodesic model`: files of states in other layouts than the mechanism's, and quantities by name.
#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <cstdio>
#include <filesystem>
#include <fstream>
#include <nlohmann/json.hpp>
#include <set>

#include "config/urdf.hpp"
#include "tools/geodesic/command.hpp"
#include "tools/geodesic/evaluation.hpp"
#include "tools/geodesic/quantities.hpp"
#include "tools/geodesic/states_file.hpp"

namespace geodesic::tools {
namespace {

using Eigen::MatrixXd;
using Eigen::VectorXd;
using nlohmann::json;

const std::filesystem::path kData = GEODESIC_TEST_DATA;

VectorXd vector(const json& list) {
  const auto numbers = list.get<std::vector<double>>();
  return Eigen::Map<const VectorXd>(numbers.data(), static_cast<Eigen::Index>(numbers.size()));
}

MatrixXd matrix(const json& rows) {
  MatrixXd result(rows.size(), rows[0].size());
  for (std::size_t i = 0; i < rows.size(); ++i) {
    result.row(static_cast<Eigen::Index>(i)) = vector(rows[i]);
  }
  return result;
}

void expect_near(const MatrixXd& found, const MatrixXd& expected, const char* what) {
  ASSERT_EQ(found.size(), expected.size()) << what;
  const double scale = std::max(1e-3, expected.cwiseAbs().maxCoeff());
  EXPECT_LE((found - expected).cwiseAbs().maxCoeff(), 1e-10 * scale) << what;
}

class ModelLayout : public testing::Test {
 protected:
  /// What `geodesic model` answers for the file.
  json answer(const json& file, const std::string& robot, EvaluationRequest request = {}) {
    std::ofstream(path_) << file;
    StatesFile states = read_states(path_);
    control::TreeDescription tree = config::load_urdf(kData / "robots" / robot, false).tree;
    freed_ = free_listed_mimics(states, tree);
    const bool floating = states.floating.value_or(lists_base(states, tree));
    const control::Mechanism mechanism(
        tree, {0.0, 0.0, -9.81}, {floating ? control::Base::kFloating : control::Base::kFixed, {}});
    control::Workspace workspace(mechanism);
    fit_states(states, mechanism, path_);
    plain_ = states.layout->plain();
    if (states.frame) request.frame = mechanism.find_link(*states.frame).value();
    if (request.what.empty()) request.what = reference_quantities(floating);
    json all = json::array();
    for (std::size_t i = 0; i < states.states.size(); ++i) {
      all.push_back(json::parse(evaluate(mechanism, workspace, states.states[i],
                                         states.as_written[i], *states.layout, request)
                                    .dump()));
    }
    return all;
  }
  std::string refusal(const json& file, const std::string& robot) {
    try {
      answer(file, robot);
    } catch (const BadInput& bad) {
      return bad.what();
    }
    return "";
  }
  static json oracle(const char* name) {
    return json::parse(std::ifstream(kData / "oracles" / name));
  }
  void TearDown() override { std::remove(path_.c_str()); }

  std::vector<std::string> freed_;
  bool plain_ = false;
  std::string path_ = testing::TempDir() + "layout_" +
                      testing::UnitTest::GetInstance()->current_test_info()->name() + ".json";
};

/// offaxis with its continuous joints 2 and 6 written as (cos, sin).
json on_the_circle(json file) {
  for (json& state : file["states"]) {
    json q = json::array();
    for (std::size_t i = 0; i < state["q"].size(); ++i) {
      const double angle = state["q"][i];
      if (i == 1 || i == 5) {
        q.push_back(std::cos(angle));
        q.push_back(std::sin(angle));
      } else {
        q.push_back(angle);
      }
    }
    state["q"] = q;
  }
  int at = 0;
  for (std::size_t i = 0; i < file["joints"].size(); ++i) {
    file["joints"][i]["idx_q"] = at;
    file["joints"][i]["nq"] = i == 1 || i == 5 ? 2 : 1;
    at += file["joints"][i]["nq"].get<int>();
  }
  file["nq"] = at;
  return file;
}

TEST_F(ModelLayout, AnAngleMayBeACosineAndASine) {
  const json plain = oracle("offaxis_hp.json");
  json file = on_the_circle(plain);
  json without_joints = file;
  without_joints.erase("joints");
  json names_only = file;
  for (json& joint : names_only["joints"]) joint = joint["name"];
  for (const json& each : {file, without_joints, names_only}) {
    const json found = answer(each, "offaxis.urdf");
    EXPECT_FALSE(plain_);
    for (std::size_t i = 0; i < found.size(); ++i) {
      EXPECT_EQ(found[i]["q"], file["states"][i]["q"]);
      for (const char* name : {"tau", "g", "Cv"}) {
        expect_near(vector(found[i][name]), vector(plain["states"][i][name]), name);
      }
      for (const char* name : {"M", "C", "Mdot", "Minv", "J_ee"}) {
        expect_near(matrix(found[i][name]), matrix(plain["states"][i][name]), name);
      }
    }
  }
  file["states"][0]["q"][1] = 3.0;
  EXPECT_NE(refusal(file, "offaxis.urdf").find("joint2"), std::string::npos);
}

TEST_F(ModelLayout, JointsMayStandInAnotherOrder) {
  const json plain = oracle("offaxis_hp.json");
  const std::size_t n = plain["joints"].size();
  json file = plain;
  for (std::size_t i = 0; i < n; ++i) {
    file["joints"][i]["idx_q"] = n - 1 - i;
    file["joints"][i]["idx_v"] = n - 1 - i;
  }
  for (json& state : file["states"]) {
    for (const char* name : {"q", "v", "a"}) {
      std::reverse(state[name].begin(), state[name].end());
    }
  }
  EvaluationRequest request;
  request.what = {"tau", "g", "Cv", "M", "C", "Mdot", "J_ee", "christoffel_first_kind"};
  const json found = answer(file, "offaxis.urdf", request);
  for (std::size_t i = 0; i < found.size(); ++i) {
    const json& expected = plain["states"][i];
    for (const char* name : {"tau", "g", "Cv"}) {
      expect_near(vector(found[i][name]).reverse(), vector(expected[name]), name);
    }
    for (const char* name : {"M", "C", "Mdot"}) {
      expect_near(matrix(found[i][name]).reverse(), matrix(expected[name]), name);
    }
    expect_near(matrix(found[i]["J_ee"]).rowwise().reverse(), matrix(expected["J_ee"]), "J_ee");
    for (std::size_t k = 0; k < n; ++k) {
      expect_near(matrix(found[i]["christoffel_first_kind"][n - 1 - k]).reverse(),
                  matrix(expected["christoffel_first_kind"][k]), "Christoffel symbols");
    }
  }
}

TEST_F(ModelLayout, TheBaseMayHaveAnyNameAndNeedNotBeListed) {
  const json plain = oracle("humanoid_hp.json");
  json renamed = plain;
  renamed["joints"][0]["name"] = "floating_base_joint";
  renamed.erase("floating_base");
  json unlisted = plain;
  unlisted["joints"].erase(0);
  json names_only = unlisted;
  for (json& joint : names_only["joints"]) joint = joint["name"];
  json with_world = plain;
  with_world["joints"].insert(with_world["joints"].begin(),
                              json{{"name", "universe"}, {"nq", 0}, {"nv", 0}});
  for (const json& each : {renamed, unlisted, names_only, with_world}) {
    const json found = answer(each, "humanoid.urdf");
    expect_near(vector(found[0]["tau"]), vector(plain["states"][0]["tau"]), "tau");
    expect_near(vector(found[0]["hg_angular"]), vector(plain["states"][0]["hg_angular"]), "hg");
  }
}

/// A planar joint, and below it a turning one: the file writes (x, y, cos, sin) and the velocity
/// along the moving body's axes. The answer must obey what holds in any frame of SE(2).
TEST_F(ModelLayout, APlanarJointMayMoveAlongItsOwnAxes) {
  const json file = json::parse(R"({"joints": [{"name": "plane", "nq": 4, "nv": 3},
      {"name": "turn", "nq": 1, "nv": 1}], "ee_frame": "tool", "states": [
      {"q": [0.3, -0.2, 0.6, 0.8, 0.5], "v": [0.4, 0.7, -1.1, 0.9], "a": [1, 2, 3, 4]},
      {"q": [5.3, 1.2, 0.6, 0.8, 0.5], "v": [0.4, 0.7, -1.1, 0.9], "a": [1, 2, 3, 4]},
      {"q": [0.3, -0.2, 0.8, -0.6, 0.5], "v": [0.4, 0.7, -1.1, 0.9], "a": [1, 2, 3, 4]}]})");
  const json found = answer(file, "planar.urdf");
  for (const json& state : found) {
    const VectorXd v = vector(state["v"]);
    const MatrixXd c = matrix(state["C"]);
    expect_near(matrix(state["Mdot"]), c + c.transpose(), "dM/dt = C + C'");
    expect_near(vector(state["Cv"]), c * v, "C v");
    expect_near(vector(state["tau"]),
                matrix(state["M"]) * vector(state["a"]) + c * v + vector(state["g"]), "tau");
    EXPECT_NEAR(0.5 * v.dot(matrix(state["M"]) * v), state["kinetic_energy"], 1e-12);
    // Left-invariant: without weight along the plane nothing depends on where the body is, or
    // where it looks.
    for (const char* name : {"M", "C", "Mdot"}) {
      expect_near(matrix(state[name]), matrix(found[0][name]), name);
    }
    expect_near(vector(state["tau"]), vector(found[0]["tau"]), "tau");
  }
  // Along the body's own axes the translations meet the whole mass, and nothing but it.
  const MatrixXd m = matrix(found[0]["M"]);
  EXPECT_NEAR(m(0, 0), 8.5 + 2.4, 1e-12);
  EXPECT_NEAR(m(1, 1), 8.5 + 2.4, 1e-12);
  EXPECT_NEAR(m(0, 1), 0.0, 1e-12);
  EvaluationRequest tables;
  tables.what = {"dMdq"};
  EXPECT_THROW(answer(file, "planar.urdf", tables), BadInput);
}

TEST_F(ModelLayout, SaysWhatDoesNotFit) {
  const json plain = oracle("offaxis_hp.json");
  json file = plain;
  file["joints"].erase(2);
  EXPECT_NE(refusal(file, "offaxis.urdf").find("not listed: joint3"), std::string::npos);
  file = plain;
  file["joints"][2]["name"] = "elbow";
  EXPECT_NE(refusal(file, "offaxis.urdf").find("unknown: elbow"), std::string::npos);
  file = plain;
  file["joints"][2]["idx_v"] = 1;
  EXPECT_NE(refusal(file, "offaxis.urdf").find("overlap"), std::string::npos);
  file = plain;
  file["joints"][2]["nv"] = 3;
  EXPECT_NE(refusal(file, "offaxis.urdf").find("joint3 has nv 3"), std::string::npos);
  file = plain;
  file["joints"][2]["idx_q"] = -1;
  EXPECT_NE(refusal(file, "offaxis.urdf").find("joints[2].idx_q"), std::string::npos);
  file = plain;
  file.erase("joints");
  file["states"][0]["q"].push_back(0.0);
  EXPECT_NE(refusal(file, "offaxis.urdf").find("expected 7 or 9"), std::string::npos);
}

TEST_F(ModelLayout, EveryQuantityIsNumbersAndUnknownOnesAreRefusedWithTheList) {
  json file = oracle("offaxis_hp.json");
  file["states"].erase(file["states"].begin() + 1, file["states"].end());
  EvaluationRequest request;
  std::set<std::string> names;
  for (const Quantity& quantity : quantities()) {
    request.what.emplace_back(quantity.name);
    EXPECT_TRUE(names.insert(quantity.name).second) << quantity.name;
  }
  const VectorXd y = VectorXd::LinSpaced(7, -1.0, 2.0);
  request.y = y;
  request.wrenches.push_back({3, control::Frame::kLinkOrigin, {{1, 2, 3}, {4, 5, 6}}});
  const json found = answer(file, "offaxis.urdf", request)[0];
  for (const std::string& name : names) {
    EXPECT_TRUE(found.contains(name) && !found[name].is_null()) << name;
  }
  const VectorXd tau = vector(found["tau"]);
  const MatrixXd m = matrix(found["M"]);
  const VectorXd v = vector(found["v"]);
  const VectorXd a = vector(found["a"]);
  expect_near(vector(found["bias"]), vector(found["Cv"]) + vector(found["g"]), "bias");
  expect_near(vector(found["flat"]), m * v, "flat");
  expect_near(m * vector(found["sharp"]), tau, "sharp");
  expect_near(vector(found["acceleration"]), a, "acceleration");
  expect_near(m * vector(found["geodesic_acceleration"]), -vector(found["Cv"]), "geodesic");
  expect_near(m * vector(found["gradV"]), vector(found["g"]), "gradient");
  expect_near(m * vector(found["covariant_acceleration"]), tau - vector(found["g"]), "Dv/dt");
  expect_near(vector(found["tau_motors"]), tau - vector(found["tau_ext"]), "wrenches");
  expect_near(matrix(found["regressor"]) * vector(found["pi"]), tau, "regressor");
  const VectorXd momentum = matrix(found["cmm"]) * v;
  expect_near(momentum.head(3), vector(found["hg_linear"]), "cmm");
  try {
    find_quantity("Mass");
    ADD_FAILURE() << "an unknown name was taken";
  } catch (const BadInput& bad) {
    EXPECT_NE(std::string(bad.what()).find("christoffel_second_kind"), std::string::npos);
  }
}

}  // namespace
}  // namespace geodesic::tools
