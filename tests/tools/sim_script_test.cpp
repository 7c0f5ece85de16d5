// Pushes, forces and faults as the command line spells them: what they mean, and how they are
// refused.
#include "tools/sim/script.hpp"

#include <gtest/gtest.h>

#include "tests/tools/sim_robot.hpp"

namespace geodesic::tools {
namespace {

const config::Robot& robot() {
  static const config::Robot it = test::chain(3);
  return it;
}

TEST(SimScript, PushByNameAndByNumber) {
  const Push by_name = parse_push("joint2:-3.5@1+0.25", robot());
  EXPECT_EQ(by_name.joint, 1U);
  EXPECT_DOUBLE_EQ(by_name.torque, -3.5);
  EXPECT_DOUBLE_EQ(by_name.start_s, 1.0);
  EXPECT_DOUBLE_EQ(by_name.duration_s, 0.25);
  EXPECT_EQ(parse_push("3:1@0+1", robot()).joint, 2U);
  EXPECT_DOUBLE_EQ(parse_push("3:+1e-1@0.5+1e-2", robot()).torque, 0.1);
}

TEST(SimScript, ForceOnALink) {
  const LinkForce force = parse_force("link3:1,-2,0.5@2+0.1", robot());
  EXPECT_EQ(force.link, "link3");
  EXPECT_EQ(force.force_n, Eigen::Vector3d(1.0, -2.0, 0.5));
  EXPECT_THROW(parse_force("link3:1,2@0+1", robot()), std::invalid_argument);
  EXPECT_THROW(parse_force("hand:1,2,3@0+1", robot()), std::invalid_argument);
}

TEST(SimScript, Faults) {
  EXPECT_EQ(parse_fault("joint1:silent@2", robot()).kind, FaultKind::kSilent);
  const ScriptedFault error = parse_fault("joint1:error=0xB@start+0.5", robot());
  EXPECT_EQ(error.kind, FaultKind::kError);
  EXPECT_EQ(error.code, 0xB);
  EXPECT_EQ(error.base, FaultBase::kStart);
  EXPECT_DOUBLE_EQ(error.at_s, 0.5);
  EXPECT_EQ(parse_fault("joint1:silent@start", robot()).base, FaultBase::kStart);
  EXPECT_EQ(parse_fault("joint1:silent@enabled+0.1", robot()).base, FaultBase::kEnabled);
  EXPECT_EQ(parse_fault("joint1:silent@1", robot()).base, FaultBase::kRelease);
  EXPECT_EQ(parse_fault("joint2:power-cycle@0", robot()).kind, FaultKind::kPowerCycle);
  EXPECT_DOUBLE_EQ(parse_fault("joint2:temperature=90@1", robot()).value, 90.0);
  EXPECT_DOUBLE_EQ(parse_fault("joint2:encoder-jump=-0.5@1", robot()).value, -0.5);
  EXPECT_EQ(parse_fault("joint2:encoder-jump@1", robot()).kind, FaultKind::kEncoderJump);
  EXPECT_EQ(parse_fault("joint2:encoder-stuck@1", robot()).kind, FaultKind::kEncoderStuck);
  EXPECT_DOUBLE_EQ(parse_fault("joint2:silent=0.003@1", robot()).value, 0.003);
  EXPECT_DOUBLE_EQ(parse_fault("joint2:double=0.1@1", robot()).value, 0.1);
  EXPECT_EQ(parse_fault("joint2:babble@1", robot()).kind, FaultKind::kBabble);
  EXPECT_DOUBLE_EQ(parse_fault("joint2:hold-bus=1@1", robot()).value, 1.0);
}

TEST(SimScript, FaultsAreNamedAsTheyAreSpelled) {
  for (const char* text : {"silent", "error=1", "power-cycle", "temperature=50", "encoder-jump",
                           "encoder-stuck", "double", "babble", "hold-bus=1"}) {
    const std::string spelled = text;
    const ScriptedFault fault = parse_fault("joint1:" + spelled + "@1", robot());
    EXPECT_EQ(to_string(fault.kind), spelled.substr(0, spelled.find('=')));
  }
}

TEST(SimScript, RefusesWithTheReason) {
  for (const char* text : {"", "joint1", "joint1:3", "joint1:3@1", "joint1@1+1", "joint1:x@1+1",
                           "joint1:3@-1+1", "joint1:3@1+0", "joint1:nan@1+1", "joint1:3@1+1s",
                           "joint9:3@1+1", "0:3@1+1", "4:3@1+1", "1.5:3@1+1"}) {
    try {
      parse_push(text, robot());
      ADD_FAILURE() << "took '" << text << "'";
    } catch (const std::invalid_argument& refusal) {
      EXPECT_NE(std::string(refusal.what()).find("expected"), std::string::npos) << refusal.what();
    }
  }
  for (const char* text :
       {"joint1:broken@1", "joint1:error@1", "joint1:error=256@1", "joint1:silent=0@1",
        "joint1:silent@", "joint1:silent@-1", "joint1:temperature@1", "joint1:hold-bus@1",
        "joint1:hold-bus=-1@1", "joint1:encoder-stuck=1@1", "joint1:power-cycle=2@1",
        "joint1:encoder-jump=far@1", "joint1:babble=x@1"}) {
    EXPECT_THROW(parse_fault(text, robot()), std::invalid_argument) << text;
  }
  try {
    parse_push("joint9:3@1+1", robot());
  } catch (const std::invalid_argument& refusal) {
    EXPECT_NE(std::string(refusal.what()).find("joint1, joint2, joint3"), std::string::npos);
  }
}

}  // namespace
}  // namespace geodesic::tools
