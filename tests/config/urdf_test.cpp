// What is read is what is written: numbers to the last bit, rotations as rpy says, whatever the
// locale.
#include "config/urdf.hpp"

#include <clocale>
#include <cmath>
#include <fstream>
#include <nlohmann/json.hpp>

#include "control/mechanism/mechanism.hpp"
#include "tests/config/bench.hpp"

namespace geodesic::config {
namespace {

const std::filesystem::path kOracles = std::filesystem::path(GEODESIC_TEST_DATA) / "oracles";

const control::JointDescription* joint_named(const UrdfResult& urdf, const std::string& name) {
  for (const auto& joint : urdf.tree.joints) {
    if (joint.name == name) return &joint;
  }
  return nullptr;
}

TEST(Urdf, OraclesLoadInTheOraclesOrder) {
  for (const char* name : {"planar2r", "ur5", "iiwa14", "openarm", "solo12"}) {
    const UrdfResult urdf = load_urdf(kOracles / (std::string(name) + ".urdf"), false);
    ASSERT_TRUE(urdf.ok) << all_of(urdf.messages);
    EXPECT_EQ(urdf.tree.name, name);
    std::ifstream file(kOracles / (std::string(name) + ".json"));
    const nlohmann::json oracle = nlohmann::json::parse(file);
    const control::Mechanism mechanism(urdf.tree, {0.0, 0.0, -9.81});
    std::vector<std::string> expected;
    for (const auto& joint : oracle["joints"]) {
      if (joint["nv"] == 1) expected.push_back(joint["name"]);
    }
    EXPECT_EQ(mechanism.joint_names(), expected) << name;
  }
}

TEST(Urdf, NumbersArriveToTheLastBit) {
  const UrdfResult urdf = load_urdf(kOracles / "openarm.urdf", false);
  ASSERT_TRUE(urdf.ok);
  for (const auto& link : urdf.tree.links) {
    if (link.name != "openarm_link1") continue;
    EXPECT_EQ(link.inertia.mass_kg, 1.1416684646202298);
    EXPECT_EQ(link.inertia.com_m,
              Eigen::Vector3d(0.0011467657911800769, -3.319987657026362e-05, 0.05395284380736254));
    EXPECT_EQ(link.inertia.inertia_kg_m2(0, 2), -2.9e-05);
    EXPECT_EQ(link.inertia.inertia_kg_m2(2, 0), -2.9e-05);
  }
  EXPECT_EQ(joint_named(urdf, "openarm_joint1")->lower, -1.396263);
  EXPECT_EQ(joint_named(urdf, "openarm_joint1")->parent_from_joint.linear(),
            Eigen::Matrix3d::Identity());
}

TEST(Urdf, FingersOfThePublishedOpenArmAreReported) {
  const UrdfResult urdf = load_urdf(kOracles / "openarm.urdf", false);
  EXPECT_TRUE(urdf.ok);
  ASSERT_EQ(urdf.messages.size(), 2U) << all_of(urdf.messages);
  EXPECT_NE(urdf.messages[0].text.find("openarm_left_finger"), std::string::npos);
  EXPECT_FALSE(load_urdf(kOracles / "openarm.urdf", true).ok);
}

using UrdfFiles = Bench;

TEST_F(UrdfFiles, RotationsAreAsRpySays) {
  const double angles[][3] = {
      {0, 0, 0},          {1.57079632679, 0, 0}, {0, 1.5707963267948966, 0},
      {0, 1.5707, -3},    {-1.5708, 0.3, 2},     {3.141592653589793, 0, 1e-9},
      {0.1, -1.57079, 3}, {2.5, -2.9, 1.1},      {1e-12, -1e-12, 1e-12}};
  for (const auto& [r, p, y] : angles) {
    char rpy[128];
    std::snprintf(rpy, sizeof rpy, "<origin xyz=\"0.5 0 0\" rpy=\"%.17g %.17g %.17g\"/>", r, p, y);
    const auto file =
        write("two.urdf", replaced(kTwoUrdf, "<origin xyz=\"0.5 0 0\" rpy=\"0 0 0\"/>", rpy));
    const UrdfResult urdf = load_urdf(file, false);
    ASSERT_TRUE(urdf.ok) << all_of(urdf.messages);
    // Fixed axes x, y, z in turn, written out.
    const double cr = std::cos(r), sr = std::sin(r), cp = std::cos(p), sp = std::sin(p);
    const double cy = std::cos(y), sy = std::sin(y);
    Eigen::Matrix3d expected;
    expected << cy * cp, cy * sp * sr - sy * cr, cy * sp * cr + sy * sr,  //
        sy * cp, sy * sp * sr + cy * cr, sy * sp * cr - cy * sr,          //
        -sp, cp * sr, cp * cr;
    const Eigen::Matrix3d found = joint_named(urdf, "elbow")->parent_from_joint.linear();
    EXPECT_LT((found - expected).cwiseAbs().maxCoeff(), 2e-15) << rpy;
  }
}

TEST_F(UrdfFiles, InertiaIsTurnedIntoLinkAxes) {
  const auto file = write("two.urdf", replaced(kTwoUrdf, "<origin xyz=\"0.2 0 0\" rpy=\"0 0 0\"/>",
                                               "<origin xyz=\"0.2 0 0\" rpy=\"0 0 0.3\"/>"));
  const UrdfResult urdf = load_urdf(file, false);
  ASSERT_TRUE(urdf.ok);
  const Eigen::Matrix3d turn = Eigen::AngleAxisd(0.3, Eigen::Vector3d::UnitZ()).toRotationMatrix();
  const Eigen::Matrix3d inertia = Eigen::Vector3d(0.001, 0.012, 0.012).asDiagonal();
  for (const auto& link : urdf.tree.links) {
    if (link.name != "lower") continue;
    EXPECT_LT((link.inertia.inertia_kg_m2 - turn * inertia * turn.transpose()).norm(), 1e-17);
  }
}

TEST_F(UrdfFiles, AnySpaceSeparatesNumbersAndAxesAreMadeUnit) {
  std::string text =
      replaced(kTwoUrdf, "<origin xyz=\"0.5 0 0\"", "<origin xyz=\"\t 0.5\n+0 \t0 \"");
  text = replaced(text, "<axis xyz=\"0 0 1\"/>", "<axis xyz=\"0 3 4\"/>");
  text = replaced(text, "value=\"0.9\"", "value=\" 0.9 \"");
  const UrdfResult urdf = load_urdf(write("two.urdf", text), false);
  ASSERT_TRUE(urdf.ok) << all_of(urdf.messages);
  EXPECT_EQ(joint_named(urdf, "elbow")->parent_from_joint.translation().x(), 0.5);
  EXPECT_LT((joint_named(urdf, "shoulder")->axis - Eigen::Vector3d(0, 0.6, 0.8)).norm(), 1e-15);
}

TEST_F(UrdfFiles, MimicArrivesWithItsFactors) {
  const auto file =
      write("two.urdf", replaced(kTwoUrdf, "effort=\"20\" velocity=\"10\"/>",
                                 "effort=\"20\" velocity=\"10\"/><mimic "
                                 "joint=\"shoulder\" multiplier=\"-2\" offset=\"0.1\"/>"));
  const UrdfResult urdf = load_urdf(file, false);
  ASSERT_TRUE(urdf.ok) << all_of(urdf.messages);
  const auto& mimic = joint_named(urdf, "elbow")->mimic;
  ASSERT_TRUE(mimic.has_value());
  EXPECT_EQ(mimic->joint, "shoulder");
  EXPECT_EQ(mimic->multiplier, -2.0);
  EXPECT_EQ(mimic->offset, 0.1);
}

TEST_F(UrdfFiles, PlanarAndFloatingJointsArrive) {
  std::string text = replaced(kTwoUrdf, "<joint name=\"shoulder\" type=\"revolute\">",
                              "<joint name=\"shoulder\" type=\"floating\">");
  text = replaced(text, "<joint name=\"elbow\" type=\"revolute\">",
                  "<joint name=\"elbow\" type=\"planar\">");
  const UrdfResult urdf = load_urdf(write("two.urdf", text), true);
  ASSERT_TRUE(urdf.ok) << all_of(urdf.messages);
  EXPECT_EQ(joint_named(urdf, "shoulder")->kind, control::JointKind::kFloating);
  const control::JointDescription& elbow = *joint_named(urdf, "elbow");
  EXPECT_EQ(elbow.kind, control::JointKind::kPlanar);
  EXPECT_EQ(elbow.axis, Eigen::Vector3d::UnitZ());
  EXPECT_TRUE(std::isinf(elbow.upper)) << "which of three a limit bounds is not said";
  const control::Mechanism mechanism(urdf.tree, Eigen::Vector3d::Zero());
  ASSERT_EQ(mechanism.factors().size(), 2U);
  EXPECT_EQ(mechanism.nq(), 10);
  EXPECT_EQ(mechanism.dof(), 9);
  EXPECT_EQ(mechanism.factors()[1].q, 7);
  EXPECT_EQ(mechanism.factors()[1].v, 6);
}

TEST_F(UrdfFiles, TheLocaleDoesNotMatter) {
  const std::string before = std::setlocale(LC_ALL, nullptr);
  for (const char* locale : {"de_DE.UTF-8", "de_DE.utf8", "fr_FR.UTF-8", "C.UTF-8"}) {
    if (std::setlocale(LC_ALL, locale) == nullptr) continue;
    const LoadResult result = load();
    EXPECT_TRUE(result.ok) << locale << all_of(result.messages);
    EXPECT_EQ(result.robot.simulation.pose[1], -0.5);
    break;
  }
  std::setlocale(LC_ALL, before.c_str());
}

}  // namespace
}  // namespace geodesic::config
