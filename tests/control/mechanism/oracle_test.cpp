// Every quantity of every reference evaluation in the oracle folder, to 1e-10. The folder is the
// one that GEODESIC_ORACLES names, else tests/data/oracles; its README describes the format.
#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <cstdlib>
#include <filesystem>
#include <fstream>
#include <limits>
#include <map>
#include <nlohmann/json.hpp>
#include <string>
#include <vector>

#include "control/mechanism/dynamics.hpp"
#include "tests/control/mechanism/urdf_for_tests.hpp"

namespace geodesic::control {
namespace {

using nlohmann::json;

constexpr double kTolerance = 1e-10;

std::filesystem::path folder() {
  const char* named = std::getenv("GEODESIC_ORACLES");
  return named != nullptr && *named != '\0' ? std::filesystem::path(named)
                                            : std::filesystem::path(GEODESIC_TEST_DATA) / "oracles";
}

json read(const std::filesystem::path& file) {
  std::ifstream stream(file);
  return json::parse(stream);
}

/// Row-major numbers of any nesting, one after the other.
void flatten(const json& value, std::vector<double>& out) {
  if (value.is_array()) {
    for (const auto& element : value) {
      flatten(element, out);
    }
  } else {
    out.push_back(value.get<double>());
  }
}

std::vector<double> numbers(const json& value) {
  std::vector<double> out;
  flatten(value, out);
  return out;
}

std::vector<double> flat(const Eigen::Ref<const Eigen::MatrixXd>& matrix) {
  std::vector<double> out;
  for (Eigen::Index i = 0; i < matrix.rows(); ++i) {
    for (Eigen::Index j = 0; j < matrix.cols(); ++j) {
      out.push_back(matrix(i, j));
    }
  }
  return out;
}

Eigen::VectorXd vector(const json& value) {
  const std::vector<double> list = numbers(value);
  return Eigen::Map<const Eigen::VectorXd>(list.data(), static_cast<Eigen::Index>(list.size()));
}

/// q where a file writes the angle of a joint as (cos, sin): joints[] gives it nq 2 and nv 1.
Eigen::VectorXd configuration(const json& oracle, const json& state) {
  const Eigen::VectorXd written = vector(state.at("q"));
  std::vector<double> q(written.begin(), written.end());
  for (std::size_t i = oracle.at("joints").size(); i-- > 0;) {
    const json& joint = oracle["joints"][i];
    if (joint.is_object() && joint.value("nq", 1) == 2 && joint.value("nv", 1) == 1) {
      const auto at = joint.at("idx_q").get<std::ptrdiff_t>();
      q[static_cast<std::size_t>(at)] = std::atan2(written[at + 1], written[at]);
      q.erase(q.begin() + at + 1);
    }
  }
  return Eigen::Map<const Eigen::VectorXd>(q.data(), static_cast<Eigen::Index>(q.size()));
}

using Quantities = std::map<std::string, std::vector<double>>;

Quantities evaluate(const Mechanism& mechanism, int ee, const Eigen::VectorXd& q,
                    const json& state) {
  Workspace workspace(mechanism);
  const Eigen::VectorXd v = vector(state.at("v"));
  const Eigen::VectorXd a = vector(state.at("a"));
  const Eigen::VectorXd g = gravity(mechanism, workspace, q);
  const Eigen::VectorXd b = bias(mechanism, workspace, q, v);
  const Eigen::VectorXd tau = inverse_dynamics(mechanism, workspace, q, v, a);
  const Pose pose = link_pose(mechanism, q, ee);
  const CentroidalMomentum momentum = centroidal_momentum(mechanism, workspace, q, v);
  Quantities result;
  result["tau"] = flat(tau);
  result["g"] = flat(g);
  result["Cv"] = flat(Eigen::VectorXd(b - g));
  result["M"] = flat(metric(mechanism, workspace, q));
  result["Minv"] = flat(*metric_inverse(mechanism, workspace, q));
  result["C"] = flat(coriolis_matrix(mechanism, workspace, q, v));
  result["Mdot"] = flat(metric_rate(mechanism, workspace, q, v));
  result["kinetic_energy"] = {kinetic_energy(mechanism, workspace, q, v)};
  result["potential_energy"] = {potential_energy(mechanism, workspace, q)};
  result["J_ee"] = flat(jacobian(mechanism, workspace, q, ee));
  result["ee_R"] = flat(pose.rotation);
  result["ee_p"] = flat(pose.translation);
  result["com"] = flat(momentum.centre_of_mass);
  result["vcom"] = flat(momentum.velocity);
  result["hg_linear"] = flat(momentum.linear);
  result["hg_angular"] = flat(momentum.angular);
  result["a"] = flat(*forward_dynamics(mechanism, workspace, q, v, tau));
  Christoffel symbols(mechanism);
  christoffel_symbols(mechanism, workspace, q, symbols);
  auto& flat_symbols = result["christoffel_first_kind"];
  for (int i = 0; i < mechanism.dof(); ++i) {
    for (int j = 0; j < mechanism.dof(); ++j) {
      for (int k = 0; k < mechanism.dof(); ++k) {
        flat_symbols.push_back(symbols(i, j, k));
      }
    }
  }
  return result;
}

/// Compares whatever quantities `reference` holds; returns how many.
int compare(const Quantities& ours, const json& reference, const std::string& where) {
  int compared = 0;
  for (const auto& [name, value] : reference.items()) {
    const auto found = ours.find(name);
    if (found == ours.end()) {
      EXPECT_TRUE(name == "q" || name == "v" || name == "hp")
          << where << ": the oracle holds " << name << ", which nothing here computes";
      continue;
    }
    const std::vector<double> expected = numbers(value);
    EXPECT_EQ(found->second.size(), expected.size()) << where << " " << name;
    if (found->second.size() != expected.size()) {
      continue;
    }
    double scale = 1.0;
    double error = 0.0;
    for (std::size_t i = 0; i < expected.size(); ++i) {
      scale = std::max(scale, std::abs(expected[i]));
      const double difference = std::abs(expected[i] - found->second[i]);
      error = std::isfinite(difference) ? std::max(error, difference)
                                        : std::numeric_limits<double>::infinity();
    }
    EXPECT_LE(error, kTolerance * scale) << where << " " << name;
    ++compared;
  }
  return compared;
}

std::vector<std::string> joint_names(const json& oracle) {
  std::vector<std::string> names;
  for (const auto& joint : oracle.at("joints")) {
    const auto name = (joint.is_string() ? joint : joint.at("name")).get<std::string>();
    if (name != "root_joint") {
      names.push_back(name);
    }
  }
  return names;
}

void check(const std::filesystem::path& file) {
  SCOPED_TRACE(file.filename().string());
  const json oracle = read(file);
  const std::string urdf =
      oracle.value("urdf", oracle.at("robot").get<std::string>() + std::string(".urdf"));
  MechanismOptions options;
  options.base = oracle.value("floating_base", false) ? Base::kFloating : Base::kFixed;
  const Mechanism mechanism(testing::read_urdf(file.parent_path() / urdf),
                            vector(oracle.at("gravity")), options);
  EXPECT_EQ(mechanism.joint_names(), joint_names(oracle));
  if (oracle.contains("nv")) {
    ASSERT_EQ(mechanism.dof(), oracle.at("nv").get<int>());
  }
  if (oracle.contains("moving_mass")) {
    EXPECT_NEAR(mechanism.moving_mass(), oracle.at("moving_mass").get<double>(), 1e-12);
  }
  const auto ee = mechanism.find_link(oracle.at("ee_frame").get<std::string>());
  ASSERT_TRUE(ee.has_value());
  const json& states = oracle.at("states");
  ASSERT_FALSE(states.empty());
  for (std::size_t i = 0; i < states.size(); ++i) {
    const Eigen::VectorXd q = configuration(oracle, states[i]);
    ASSERT_EQ(q.size(), mechanism.nq());
    const Quantities ours = evaluate(mechanism, *ee, q, states[i]);
    const std::string where = "state " + std::to_string(i);
    int compared = compare(ours, states[i], where);
    if (states[i].contains("hp")) {
      compared += compare(ours, states[i].at("hp"), where + " (50 digits)");
    }
    EXPECT_GE(compared, 12) << where;
  }
}

TEST(MechanismOracles, EveryQuantityOfEveryFile) {
  int files = 0;
  ASSERT_TRUE(std::filesystem::is_directory(folder())) << folder() << " is no folder";
  for (const auto& entry : std::filesystem::directory_iterator(folder())) {
    if (entry.path().extension() == ".json") {
      check(entry.path());
      ++files;
    }
  }
  EXPECT_GT(files, 0) << "no oracle in " << folder();
}

}  // namespace
}  // namespace geodesic::control
