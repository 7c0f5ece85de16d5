// What a Mechanism refuses, and that its words name the culprit; order and lookup of what it takes.
#include <gtest/gtest.h>

#include <functional>
#include <limits>
#include <stdexcept>
#include <string>

#include "control/mechanism/configuration.hpp"
#include "control/mechanism/kinematics.hpp"
#include "control/mechanism/mechanism.hpp"

namespace geodesic::control {
namespace {

const Eigen::Vector3d kDown(0.0, 0.0, -9.81);
constexpr double kNan = std::numeric_limits<double>::quiet_NaN();

JointDescription joint(const std::string& name, const std::string& parent, const std::string& child,
                       JointKind kind = JointKind::kRevolute) {
  JointDescription result;
  result.name = name;
  result.kind = kind;
  result.parent_link = parent;
  result.child_link = child;
  return result;
}

/// base - j1 - a - j2 - b, and a finger on b.
TreeDescription arm() {
  TreeDescription tree;
  tree.root_link = "base";
  const LinkInertia stone{1.0, Eigen::Vector3d(0.1, 0.0, 0.0), Eigen::Matrix3d::Identity()};
  tree.links = {{"base", {}}, {"a", stone}, {"b", stone}, {"finger", stone}};
  tree.joints = {joint("j1", "base", "a"), joint("j2", "a", "b"),
                 joint("grip", "b", "finger", JointKind::kPrismatic)};
  return tree;
}

TreeDescription chain(int joints) {
  TreeDescription tree = arm();
  tree.joints.clear();
  tree.links.resize(1);
  for (int i = 0; i < joints; ++i) {
    const std::string link = "link" + std::to_string(i);
    tree.joints.push_back(joint("j" + std::to_string(i), tree.links.back().name, link));
    tree.links.push_back({link, {}});
  }
  return tree;
}

std::string refusal(const TreeDescription& tree) {
  try {
    const Mechanism mechanism(tree, kDown);
  } catch (const std::invalid_argument& error) {
    return error.what();
  }
  return "accepted";
}

struct Refusal {
  const char* what;
  std::function<void(TreeDescription&)> spoil;
  const char* culprit;
  const char* words;
};

const Refusal kRefusals[] = {
    {"NoRoot", [](auto& t) { t.root_link.clear(); }, "root", "no root"},
    {"RootUnknown", [](auto& t) { t.root_link = "nowhere"; }, "'nowhere'", "not among"},
    {"TwoRoots",
     [](auto& t) {
       t.links.push_back({"stray", {}});
     },
     "'stray'", "one root"},
    {"TwoParents", [](auto& t) { t.joints.push_back(joint("j3", "base", "b")); }, "'b'",
     "two parents"},
    {"Cycle", [](auto& t) { t.joints[0].parent_link = "finger"; }, "", "cycle"},
    {"CycleThroughRoot", [](auto& t) { t.joints.push_back(joint("j3", "b", "base")); }, "",
     "cycle"},
    {"UnknownParent", [](auto& t) { t.joints[1].parent_link = "c"; }, "'j2'", "'c'"},
    {"UnknownChild", [](auto& t) { t.joints[1].child_link = "c"; }, "'j2'", "'c'"},
    {"LinkTwice",
     [](auto& t) {
       t.links.push_back({"a", {}});
     },
     "'a'", "twice"},
    {"JointTwice", [](auto& t) { t.joints[1].name = "j1"; }, "'j1'", "twice"},
    {"MimicUnknown", [](auto& t) { t.joints[2].mimic = MimicDescription{"j9"}; }, "'grip'", "'j9'"},
    {"MimicItself", [](auto& t) { t.joints[2].mimic = MimicDescription{"grip"}; }, "'grip'",
     "itself"},
    {"MimicChain",
     [](auto& t) {
       t.joints[2].mimic = MimicDescription{"j2"};
       t.joints[1].mimic = MimicDescription{"j1"};
     },
     "'grip'", "'j2'"},
    {"MimicCycle",
     [](auto& t) {
       t.joints[1].mimic = MimicDescription{"grip"};
       t.joints[2].mimic = MimicDescription{"j2"};
     },
     "'j2'", "mimics"},
    {"MimicOfFixed",
     [](auto& t) {
       t.joints[1].kind = JointKind::kFixed;
       t.joints[2].mimic = MimicDescription{"j2"};
     },
     "'grip'", "fixed"},
    {"MimicOfSpherical",
     [](auto& t) {
       t.joints[1].kind = JointKind::kSpherical;
       t.joints[2].mimic = MimicDescription{"j2"};
     },
     "'grip'", "which is spherical"},
    {"MimicIsPlanar",
     [](auto& t) {
       t.joints[1].kind = JointKind::kPlanar;
       t.joints[1].mimic = MimicDescription{"j1"};
     },
     "'j2'", "is planar and mimics"},
    {"MimicNotFinite",
     [](auto& t) {
       t.joints[2].mimic = MimicDescription{"j2", kNan};
     },
     "'grip'", "finite"},
    {"AxisZero", [](auto& t) { t.joints[1].axis.setZero(); }, "'j2'", "zero"},
    {"AxisLong", [](auto& t) { t.joints[1].axis *= 2.0; }, "'j2'", "unit vector"},
    {"AxisNotFinite", [](auto& t) { t.joints[1].axis.x() = kNan; }, "'j2'", "finite"},
    {"OriginNotFinite", [](auto& t) { t.joints[1].parent_from_joint.translation().x() = kNan; },
     "'j2'", "finite"},
    {"OriginNoRotation", [](auto& t) { t.joints[1].parent_from_joint.linear() *= 1.1; }, "'j2'",
     "rotation"},
    {"OriginMirrored", [](auto& t) { t.joints[1].parent_from_joint.linear() *= -1.0; }, "'j2'",
     "rotation"},
    {"LimitNan", [](auto& t) { t.joints[1].upper = kNan; }, "'j2'", "limit"},
    {"LimitsCrossed",
     [](auto& t) {
       t.joints[1].lower = 1.0;
       t.joints[1].upper = -1.0;
     },
     "'j2'", "above"},
    {"MassNan", [](auto& t) { t.links[1].inertia.mass_kg = kNan; }, "'a'", "finite"},
    {"MassNegative", [](auto& t) { t.links[1].inertia.mass_kg = -1.0; }, "'a'", "negative"},
    {"InertiaNan", [](auto& t) { t.links[1].inertia.inertia_kg_m2(0, 1) = kNan; }, "'a'", "finite"},
    {"InertiaAsymmetric", [](auto& t) { t.links[1].inertia.inertia_kg_m2(0, 1) = 0.1; }, "'a'",
     "symmetric"},
    {"TooManyJoints", [](auto& t) { t = chain(65); }, "'j64'", "at most 64"},
    {"TooManyMimicJoints",
     [](auto& t) {
       t = chain(129);
       for (auto& j : t.joints) {
         if (j.name != "j0") j.mimic = MimicDescription{"j0"};
       }
     },
     "'j128'", "at most 128"},
};

TEST(MechanismRefusals, EveryOneNamesTheCulprit) {
  ASSERT_EQ(refusal(arm()), "accepted");
  for (const Refusal& expected : kRefusals) {
    TreeDescription tree = arm();
    expected.spoil(tree);
    const std::string text = refusal(tree);
    EXPECT_NE(text.find(expected.culprit), std::string::npos) << expected.what << ": " << text;
    EXPECT_NE(text.find(expected.words), std::string::npos) << expected.what << ": " << text;
  }
}

TEST(MechanismRefusals, Options) {
  EXPECT_THROW(Mechanism(arm(), Eigen::Vector3d(0.0, kNan, 0.0)), std::invalid_argument);
  MechanismOptions options;
  options.rotor_inertia = Eigen::VectorXd::Ones(2);
  EXPECT_THROW(Mechanism(arm(), kDown, options), std::invalid_argument);
  options.rotor_inertia = Eigen::Vector3d(0.1, -0.1, 0.1);
  EXPECT_THROW(Mechanism(arm(), kDown, options), std::invalid_argument);
}

TEST(MechanismStructure, CapacityIsReachable) {
  EXPECT_EQ(Mechanism(chain(64), kDown).dof(), 64);
  TreeDescription coupled = chain(128);
  for (std::size_t i = 64; i < 128; ++i) coupled.joints[i].mimic = MimicDescription{"j3"};
  EXPECT_EQ(Mechanism(coupled, kDown).bodies().size(), 128U);
  TreeDescription free = chain(64);
  for (auto& each : free.joints) each.kind = JointKind::kFloating;
  EXPECT_EQ(Mechanism(free, kDown, {Base::kFloating, {}}).dof(), 6 * 65);
}

TEST(MechanismStructure, DepthFirstSiblingsByName) {
  TreeDescription tree = arm();
  tree.links.push_back({"left", {}});
  tree.links.push_back({"left tip", {}});
  tree.joints.push_back(joint("a left", "base", "left", JointKind::kFixed));
  tree.joints.push_back(joint("z last", "left", "left tip"));
  tree.joints[1].mimic = MimicDescription{"grip", 0.5};
  const Mechanism mechanism(tree, kDown);
  EXPECT_EQ(mechanism.joint_names(), (std::vector<std::string>{"z last", "j1", "grip"}));
  EXPECT_EQ(mechanism.find_joint("grip"), 2);
  EXPECT_EQ(mechanism.find_joint("j2"), std::nullopt) << "a mimic joint is not independent";
  EXPECT_EQ(mechanism.find_link("base"), 0);
  EXPECT_EQ(mechanism.find_link("elsewhere"), std::nullopt);
  EXPECT_EQ(mechanism.joint_kinds()[2], JointKind::kPrismatic);
}

TEST(MechanismStructure, MergedLinksStayFrames) {
  TreeDescription tree = arm();
  tree.joints[1].kind = JointKind::kFixed;
  tree.joints[1].parent_from_joint.translation() = Eigen::Vector3d(0.0, 0.3, 0.0);
  const Mechanism mechanism(tree, kDown);
  ASSERT_EQ(mechanism.dof(), 2);
  EXPECT_NEAR(mechanism.moving_mass(), 3.0, 1e-15);
  const Pose b = link_pose(mechanism, neutral(mechanism), *mechanism.find_link("b"));
  EXPECT_LE((b.translation - Eigen::Vector3d(0.0, 0.3, 0.0)).norm(), 1e-15);
  EXPECT_TRUE(b.rotation.isIdentity(1e-15));
}

}  // namespace
}  // namespace geodesic::control
