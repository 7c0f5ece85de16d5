// Ranges of the controller's options, and the names of the laws.
#include "control/options.hpp"

#include <gtest/gtest.h>

#include <functional>
#include <limits>

#include "tests/control/planar_arm.hpp"

namespace geodesic::control {
namespace {

TEST(Options, LawNamesGoBothWays) {
  for (const LawKind law : {LawKind::kFloat, LawKind::kHold, LawKind::kDamp, LawKind::kZero}) {
    EXPECT_EQ(law_from_string(to_string(law)), law);
  }
  EXPECT_EQ(law_from_string("flaot"), std::nullopt);
  EXPECT_STREQ(to_string(static_cast<LawKind>(77)), "?");
}

TEST(Options, CarefulOnesHaveNoComplaint) {
  EXPECT_TRUE(check(testing::planar_options()).empty());
}

TEST(Options, EachOutOfRangeIsNamed) {
  constexpr double kNan = std::numeric_limits<double>::quiet_NaN();
  using Break = std::function<void(ControllerOptions&)>;
  const std::vector<std::pair<const char*, Break>> cases{
      {"joint 'joint2': damping", [](auto& o) { o.joints[1].damping = -1.0; }},
      {"hold_stiffness", [](auto& o) { o.joints[0].hold_stiffness = kNan; }},
      {"stop_damping", [](auto& o) { o.joints[0].stop_damping = -1.0; }},
      {"drive_damping", [](auto& o) { o.joints[0].drive_damping = kNan; }},
      {"friction_velocity", [](auto& o) { o.joints[0].friction_velocity = 0.0; }},
      {"position_lower", [](auto& o) { o.joints[0].position_lower = 3.0; }},
      {"position_lower", [](auto& o) { o.joints[0].position_upper = kNan; }},
      {"velocity_limit", [](auto& o) { o.joints[0].velocity_limit = kNan; }},
      {"torque_limit", [](auto& o) { o.joints[0].torque_limit = 0.0; }},
      {"torque_rate_limit", [](auto& o) { o.joints[0].torque_rate_limit = -3.0; }},
      {"temperature_warn_c", [](auto& o) { o.joints[0].temperature_warn_c = 99.0; }},
      {"silent_cycles", [](auto& o) { o.safety.silent_cycles = 0; }},
      {"start_ramp_s", [](auto& o) { o.safety.start_ramp_s = kNan; }},
      {"connect_timeout_s", [](auto& o) { o.safety.connect_timeout_s = 0.0; }},
      {"encoder_jump", [](auto& o) { o.safety.encoder_jump = 0.0; }},
      {"velocity_filter_hz", [](auto& o) { o.velocity_filter_hz = -1.0; }},
      {"coriolis", [](auto& o) { o.coriolis = 1.1; }},
      {"coriolis", [](auto& o) { o.coriolis = kNan; }},
      {"allow_zero_law", [](auto& o) { o.law = LawKind::kZero; }},
      {"law is none", [](auto& o) { o.law = static_cast<LawKind>(9); }},
      {"0 joints", [](auto& o) { o.joints.clear(); }},
      {"33 joints", [](auto& o) { o.joints.resize(33); }},
  };
  for (const auto& [expected, break_it] : cases) {
    ControllerOptions options = testing::planar_options();
    break_it(options);
    const std::vector<std::string> complaints = check(options);
    ASSERT_EQ(complaints.size(), 1u) << expected;
    EXPECT_NE(complaints[0].find(expected), std::string::npos) << complaints[0];
  }
}

}  // namespace
}  // namespace geodesic::control
