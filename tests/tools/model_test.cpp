// `geodesic model`: its file of states, and its answer against the reference files it shares the
// format with.
#include <gtest/gtest.h>

#include <algorithm>
#include <cctype>
#include <cmath>
#include <cstdio>
#include <cstdlib>
#include <filesystem>
#include <fstream>
#include <nlohmann/json.hpp>

#include "config/urdf.hpp"
#include "tools/geodesic/command.hpp"
#include "tools/geodesic/evaluation.hpp"
#include "tools/geodesic/states_file.hpp"

namespace geodesic::tools {
namespace {

using nlohmann::json;

const std::filesystem::path kOracles = GEODESIC_TEST_DATA "/oracles";

// Largest difference of two nests of numbers, against the largest number among them.
void compare(const json& found, const json& expected, double& difference, double& scale) {
  if (expected.is_array()) {
    ASSERT_EQ(found.size(), expected.size());
    for (std::size_t i = 0; i < expected.size(); ++i) {
      compare(found[i], expected[i], difference, scale);
    }
    return;
  }
  ASSERT_TRUE(found.is_number());
  difference = std::max(difference, std::abs(found.get<double>() - expected.get<double>()));
  scale = std::max(scale, std::abs(expected.get<double>()));
}

class ModelAgainstOracle : public testing::TestWithParam<std::filesystem::path> {};

TEST_P(ModelAgainstOracle, EveryQuantityOfEveryState) {
  const std::filesystem::path file = GetParam();
  const json oracle = json::parse(std::ifstream(file));
  const std::string robot = oracle["robot"].get<std::string>();
  const std::filesystem::path description =
      file.parent_path() / oracle.value("urdf", robot + ".urdf");
  config::UrdfResult urdf = config::load_urdf(description, false);
  ASSERT_TRUE(urdf.ok) << description;

  StatesFile states = read_states(file);
  free_listed_mimics(states, urdf.tree);
  control::MechanismOptions options;
  if (states.floating.value_or(lists_base(states, urdf.tree))) {
    options.base = control::Base::kFloating;
  }
  const control::Mechanism mechanism(urdf.tree, states.gravity.value(), options);
  control::Workspace workspace(mechanism);
  fit_states(states, mechanism, file);
  const auto frame = mechanism.find_link(states.frame.value());
  ASSERT_TRUE(frame.has_value());
  EvaluationRequest request;
  request.frame = *frame;
  request.what = reference_quantities(mechanism.floating());
  if (states.christoffel) request.what.emplace_back("christoffel_first_kind");
  ASSERT_EQ(states.states.size(), oracle["states"].size());
  for (std::size_t i = 0; i < states.states.size(); ++i) {
    const json found = json::parse(evaluate(mechanism, workspace, states.states[i],
                                            states.as_written[i], *states.layout, request)
                                       .dump());
    json expected = oracle["states"][i];
    if (expected.contains("hp")) expected.update(expected["hp"]);
    expected.erase("hp");
    for (const auto& [key, value] : expected.items()) {
      ASSERT_TRUE(found.contains(key)) << key;
      double difference = 0.0;
      double scale = 1e-3;
      compare(found[key], value, difference, scale);
      EXPECT_LT(difference, 1e-10 * scale) << key << ", state " << i;
    }
  }
}

/// All in the folder that GEODESIC_ORACLES names, else ours.
std::vector<std::filesystem::path> oracles() {
  const char* named = std::getenv("GEODESIC_ORACLES");
  std::vector<std::filesystem::path> files;
  for (const auto& entry : std::filesystem::directory_iterator(
           named != nullptr && *named != '\0' ? std::filesystem::path(named) : kOracles)) {
    if (entry.path().extension() == ".json") files.push_back(entry.path());
  }
  std::sort(files.begin(), files.end());
  return files;
}

INSTANTIATE_TEST_SUITE_P(Robots, ModelAgainstOracle, testing::ValuesIn(oracles()),
                         [](const auto& each) {
                           std::string name = each.param.stem().string();
                           for (char& letter : name) {
                             if (std::isalnum(static_cast<unsigned char>(letter)) == 0) {
                               letter = '_';
                             }
                           }
                           return name;
                         });

class StatesFileTest : public testing::Test {
 protected:
  std::string write(const std::string& text) {
    std::ofstream(path_) << text;
    return path_;
  }
  std::string refusal(const std::string& text) {
    try {
      read_states(write(text));
    } catch (const BadInput& bad) {
      return bad.what();
    }
    return "";
  }
  void TearDown() override { std::remove(path_.c_str()); }
  std::string path_ = testing::TempDir() + "states_" +
                      testing::UnitTest::GetInstance()->current_test_info()->name() + ".json";
};

TEST_F(StatesFileTest, RefusesWithPlaceAndExpectation) {
  EXPECT_NE(refusal("nonsense").find("no JSON"), std::string::npos);
  EXPECT_NE(refusal("{}").find("states"), std::string::npos);
  EXPECT_NE(refusal(R"({"states":[{"q":[0,"x"]}]})").find("states[0].q[1]"), std::string::npos);
  EXPECT_NE(refusal(R"({"states":[{}]})").find("q is missing"), std::string::npos);
  EXPECT_NE(refusal(R"({"gravity":[0,0],"states":[]})").find("gravity"), std::string::npos);
  EXPECT_THROW(read_states("/nonexistent/file.json"), BadInput);
}

TEST_F(StatesFileTest, SizesAndJointsMustFit) {
  const config::UrdfResult urdf = config::load_urdf(kOracles / "planar2r.urdf", false);
  ASSERT_TRUE(urdf.ok);
  const control::Mechanism mechanism(urdf.tree, {0.0, -9.81, 0.0});
  StatesFile good = read_states(write(R"({"states":[{"q":[0.1,0.2]}]})"));
  fit_states(good, mechanism, "file");
  EXPECT_EQ(good.states[0].v, Eigen::VectorXd::Zero(2));
  StatesFile longer = read_states(write(R"({"states":[{"q":[0.1,0.2,0.3]}]})"));
  EXPECT_THROW(fit_states(longer, mechanism, "file"), BadInput);
  StatesFile strange = read_states(write(R"({"joints":["joint3","joint1"],"states":[]})"));
  EXPECT_THROW(fit_states(strange, mechanism, "file"), BadInput);
}

}  // namespace
}  // namespace geodesic::tools
