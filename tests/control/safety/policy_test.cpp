// The policy table: complete, in order, and the same in the documentation.
#include <gtest/gtest.h>

#include <fstream>
#include <set>
#include <sstream>

#include "control/safety/supervisor.hpp"

namespace geodesic::control {
namespace {

TEST(Policy, HasOneLineForEveryFaultInOrder) {
  std::set<std::string> names;
  for (std::size_t i = 0; i < kFaults; ++i) {
    const FaultPolicy& line = policy(static_cast<Fault>(i));
    EXPECT_EQ(line.fault, static_cast<Fault>(i));
    EXPECT_TRUE(names.insert(line.name).second) << line.name;
    EXPECT_NE(std::string(line.meaning), "");
    EXPECT_NE(std::string(line.detection), "");
    EXPECT_STRNE(to_string(line.within), "?") << line.name;
    EXPECT_NE(states_in_words(line.states), "");
    EXPECT_NE(line.action, Action::kNone) << line.name;
    EXPECT_NE(line.states, 0u) << line.name;
    EXPECT_FALSE(has(line.states, static_cast<std::size_t>(SupervisorState::kOff))) << line.name;
    EXPECT_FALSE(has(line.states, static_cast<std::size_t>(SupervisorState::kFault))) << line.name;
  }
}

TEST(Policy, ActionsRiseInSeverity) {
  EXPECT_LT(Action::kWarn, Action::kRefuse);
  EXPECT_LT(Action::kRefuse, Action::kDamp);
  EXPECT_LT(Action::kDamp, Action::kControlledStop);
  EXPECT_LT(Action::kControlledStop, Action::kDriveDamping);
  EXPECT_LT(Action::kDriveDamping, Action::kTorqueOff);
}

TEST(Policy, NeverDropsAnArmWhoseEncodersAreTrusted) {
  for (std::size_t i = 0; i < kFaults; ++i) {
    const FaultPolicy& line = policy(static_cast<Fault>(i));
    const bool while_torque_flows =
        has(line.states, static_cast<std::size_t>(SupervisorState::kActive));
    if (while_torque_flows) {
      EXPECT_NE(line.action, Action::kTorqueOff) << line.name;
    }
    if (line.action == Action::kDriveDamping) {
      EXPECT_TRUE(line.fault == Fault::kEncoderJump || line.fault == Fault::kEncoderStuck ||
                  line.fault == Fault::kNotFinite);
    }
  }
}

TEST(Policy, IsTheTableOfTheReadme) {
  std::ifstream file(GEODESIC_SOURCE_DIR "/control/safety/README.md");
  std::stringstream text;
  text << file.rdbuf();
  EXPECT_NE(text.str().find(policy_table_markdown()), std::string::npos)
      << "control/safety/README.md must contain exactly:\n"
      << policy_table_markdown();
}

TEST(Policy, NamesAreTotal) {
  EXPECT_STREQ(to_string(SupervisorState::kOff), "off");
  EXPECT_STREQ(to_string(SupervisorState::kFault), "fault");
  EXPECT_STREQ(to_string(Action::kTorqueOff), "torque_off");
  EXPECT_STREQ(to_string(static_cast<SupervisorState>(99)), "?");
  EXPECT_STREQ(to_string(static_cast<Action>(99)), "?");
}

}  // namespace
}  // namespace geodesic::control
