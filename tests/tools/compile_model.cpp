// A compiled model on disk: it agrees, hides nothing that is no number, and whatever is wrong with
// the file is refused by name. Runs the system's compiler three times.
#include <gtest/gtest.h>
#include <sys/stat.h>
#include <unistd.h>

#include <cmath>
#include <cstdlib>
#include <limits>

#include "config/urdf.hpp"
#include "control/mechanism/dynamics.hpp"
#include "tests/tools/compile_fixture.hpp"
#include "tests/tools/geodesicd_fixture.hpp"
#include "tools/compile/agreement.hpp"
#include "tools/compile/builder.hpp"
#include "tools/compile/compose.hpp"

namespace geodesic::tools::compile {
namespace {

using Eigen::VectorXd;

control::Mechanism ur5(double gravity = -9.81) {
  config::UrdfResult urdf = config::load_urdf(GEODESIC_TEST_DATA "/oracles/ur5.urdf", false);
  return {urdf.tree, Eigen::Vector3d(0.0, 0.0, gravity)};
}

/// Two arms on one root that do not carry each other, a slider among their joints.
control::Mechanism two_arms() {
  control::TreeDescription tree;
  tree.name = "two arms";
  tree.root_link = "root";
  tree.links.push_back({"root", {}});
  for (int i = 0; i < 4; ++i) {
    const std::string name = (i < 2 ? "a" : "b") + std::to_string(i % 2);
    control::LinkDescription link{name, {}};
    link.inertia.mass_kg = 1.0;
    link.inertia.com_m = Eigen::Vector3d(0.2, 0.1, 0.05);
    link.inertia.inertia_kg_m2 = 0.01 * Eigen::Matrix3d::Identity();
    tree.links.push_back(link);
    control::JointDescription joint;
    joint.name = name + "_joint";
    joint.kind = i == 1 ? control::JointKind::kPrismatic : control::JointKind::kRevolute;
    joint.parent_link = i % 2 == 0 ? "root" : (i < 2 ? "a0" : "b0");
    joint.child_link = name;
    joint.axis = Eigen::Vector3d::UnitY();
    joint.parent_from_joint.translation() = Eigen::Vector3d(0.3, 0.0, 0.0);
    tree.joints.push_back(joint);
  }
  return {tree, Eigen::Vector3d(0.0, 0.0, -9.81)};
}

std::string built(const control::Mechanism& mechanism) {
  return sealed(build(find_compiler(""), emit(compose(mechanism, kSnaps[0]))));
}

class CompiledModelFile : public ::testing::Test {
 protected:
  /// One build serves all tests.
  static void SetUpTestSuite() {
    folder_ = new TemporaryFolder;
    good_ = new std::string(built(ur5()));
  }
  static void TearDownTestSuite() {
    delete folder_;
    delete good_;
  }

  static std::filesystem::path write(const std::string& name, const std::string& bytes) {
    const std::filesystem::path file = *folder_ / name;
    std::ofstream(file, std::ios::binary) << bytes;
    return file;
  }
  static const std::string& good() { return *good_; }

  /// What is said when the file is to be loaded for the mechanism; empty: nothing, it is taken.
  static std::string refusal(const std::filesystem::path& file,
                             const control::Mechanism& mechanism) {
    try {
      const VerifiedModel model(file, mechanism, "robot.toml");
    } catch (const CompiledModelError& error) {
      return error.what();
    }
    return {};
  }
  static void expect_refused(const std::filesystem::path& file, const control::Mechanism& mechanism,
                             const std::string& reason) {
    const std::string said = refusal(file, mechanism);
    EXPECT_NE(said.find(reason), std::string::npos) << said;
    EXPECT_NE(said.find(file.string()), std::string::npos) << said;
    EXPECT_NE(said.find("geodesic compile robot.toml"), std::string::npos) << said;
  }

 private:
  static TemporaryFolder* folder_;
  static std::string* good_;
};

TemporaryFolder* CompiledModelFile::folder_ = nullptr;
std::string* CompiledModelFile::good_ = nullptr;

TEST_F(CompiledModelFile, AgreesInAThousandStates) {
  const control::Mechanism mechanism = ur5();
  const VerifiedModel model(write("good.so", good()), mechanism, "robot.toml");
  EXPECT_EQ(model.agreement().states, 1000);
  EXPECT_LE(model.agreement().worst, kAgreement);
  EXPECT_NE(model.functions_for(mechanism), nullptr);
  EXPECT_EQ(model.functions_for(ur5(-9.80)), nullptr) << "that is another mechanism";
}

TEST_F(CompiledModelFile, FarAnglesAreNoWorseThanAsTheMechanismTakesThem) {
  const control::Mechanism mechanism = ur5();
  const VerifiedModel model(write("far.so", good()), mechanism, "robot.toml");
  const control::CompiledModel& functions = *model.functions_for(mechanism);
  control::Workspace workspace(mechanism);
  VectorXd q(6);
  VectorXd found(6);
  for (const double far : {1e3, 9.9e5, 1.1e6, 1e9, 1e15}) {
    q << 1.0, far, -0.3 * far, 0.5, far, -far;
    functions.gravity(q.data(), found.data());
    const VectorXd expected = control::gravity(mechanism, workspace, q);
    // Sums of angles are rounded once more: by a unit in the last place of the angle.
    const double allowed = far <= 1e6 ? 1e-12 + 4e-16 * far : 1e-12 + 1e-9;
    EXPECT_LE((found - expected).norm(), allowed * expected.norm()) << far;
  }
}

TEST_F(CompiledModelFile, NoNumberIsHiddenNorCarriedToTheOtherArm) {
  const control::Mechanism mechanism = two_arms();
  const VerifiedModel model(write("arms.so", built(mechanism)), mechanism, "robot.toml");
  const control::CompiledModel& functions = *model.functions_for(mechanism);
  for (const double bad :
       {std::numeric_limits<double>::quiet_NaN(), std::numeric_limits<double>::infinity()}) {
    for (int i = 0; i < 8; ++i) {
      VectorXd q = VectorXd::Constant(4, 0.3);
      VectorXd v = VectorXd::Constant(4, 0.2);
      (i < 4 ? q : v)[i % 4] = bad;
      VectorXd out(4);
      functions.bias(q.data(), v.data(), out.data());
      const Eigen::Index arm = (i % 4) / 2;
      EXPECT_TRUE(out.segment(2 * arm, 2).array().isNaN().all()) << i << ": " << out.transpose();
      EXPECT_TRUE(out.segment(2 - 2 * arm, 2).allFinite()) << i << ": " << out.transpose();
    }
  }
}

TEST_F(CompiledModelFile, AnotherMechanismIsRefused) {
  expect_refused(write("other.so", good()), ur5(-1.62), "another mechanism");
  expect_refused(write("arms_other.so", good()), two_arms(), "another mechanism");
}

TEST_F(CompiledModelFile, DamageIsRefused) {
  const control::Mechanism mechanism = ur5();
  expect_refused(write("short.so", good().substr(0, good().size() / 2)), mechanism,
                 "its end is missing");
  expect_refused(write("cut.so", good().substr(0, good().size() - 1)), mechanism,
                 "its end is missing");
  std::string flipped = good();
  flipped[flipped.size() / 2] ^= 1;
  expect_refused(write("flipped.so", flipped), mechanism, "changed or damaged");
  expect_refused(write("empty.so", ""), mechanism, "its end is missing");
  expect_refused(write("text.so", sealed("no code at all")), mechanism, "cannot be loaded");
  expect_refused("/nowhere/model.so", mechanism, "No such file");
}

TEST_F(CompiledModelFile, WhatOthersCouldHaveWrittenIsRefused) {
  const std::filesystem::path file = write("open.so", good());
  for (const mode_t mode : {0666U, 0664U, 0602U}) {
    ::chmod(file.c_str(), mode);
    expect_refused(file, ur5(), "others may write it");
  }
  ::chmod(file.c_str(), 0644);
  EXPECT_EQ(refusal(file, ur5()), "");
  if (::geteuid() == 0 && ::chown(file.c_str(), 65534, 65534) == 0) {
    expect_refused(file, ur5(), "belongs to user 65534");
  }
}

TEST_F(CompiledModelFile, OneThatComputesWrongIsRefusedWithFigureAndState) {
  // The right fingerprint, and one inertia that is a millionth off.
  const control::Mechanism mechanism = ur5();
  std::string source = emit(compose(mechanism, kSnaps[0]));
  const std::size_t at = source.find("0.17446825");
  ASSERT_NE(at, std::string::npos);
  for (std::size_t found = at; found != std::string::npos;
       found = source.find("0.17446825", found)) {
    source.replace(found, 10, "0.17446842");
  }
  const std::filesystem::path file = write("wrong.so", sealed(build(find_compiler(""), source)));
  expect_refused(file, mechanism, "disagrees");
  EXPECT_NE(refusal(file, mechanism).find("at q = ["), std::string::npos);
}

TEST(CompilerSearch, NamesThePackageWhereThereIsNone) {
  const std::string path = std::getenv("PATH");
  ::setenv("PATH", "/nowhere", 1);
  std::string said;
  try {
    find_compiler("");
  } catch (const BuildError& error) {
    said = error.what();
  }
  ::setenv("PATH", path.c_str(), 1);
  EXPECT_NE(said.find("apt install g++"), std::string::npos) << said;
  EXPECT_THROW(find_compiler("no-such-compiler"), BuildError);
}

TEST(CompilerSearch, SaysWhatTheCompilerSaid) {
  try {
    build(find_compiler(""), "int no_semicolon");
    FAIL();
  } catch (const BuildError& error) {
    EXPECT_NE(std::string(error.what()).find("error"), std::string::npos) << error.what();
  }
}

}  // namespace
}  // namespace geodesic::tools::compile
