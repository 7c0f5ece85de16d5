// What an arm refuses to be built from, and the filters that its buses get.
#include <gtest/gtest.h>

#include <cmath>
#include <set>
#include <stdexcept>

#include "drivers/arm.hpp"

namespace geodesic::drivers::test {
namespace {

JointOptions joint(const char* name, std::size_t bus, std::uint32_t id) {
  JointOptions options;
  options.name = name;
  options.bus = bus;
  options.drive.family = "damiao";
  options.drive.id = id;
  options.drive.reply_id = id + 0x10;
  options.drive.position_range_rad = 12.5;
  options.drive.velocity_range_rad_s = 30.0;
  options.drive.torque_range_nm = 10.0;
  return options;
}

ArmOptions arm() {
  ArmOptions options;
  options.buses.resize(2);
  options.buses[0].name = "left";
  options.buses[1].name = "right";
  options.joints = {joint("a", 0, 1), joint("b", 0, 2), joint("c", 1, 1)};
  return options;
}

template <class Change>
std::string refusal(Change change) {
  ArmOptions options = arm();
  change(options);
  try {
    filtered_buses(options);
  } catch (const std::invalid_argument& error) {
    return error.what();
  }
  return {};
}

TEST(ArmOptions, BusesLetInRepliesAndGuardCommands) {
  const std::vector<BusOptions> buses = filtered_buses(arm());
  ASSERT_EQ(buses.size(), 2U);
  const auto ids = [](const std::vector<IdFilter>& filters) {
    std::multiset<std::uint32_t> set;
    for (const IdFilter& filter : filters) {
      EXPECT_FALSE(filter.extended);
      set.insert(filter.id);
    }
    return set;
  };
  using Ids = std::multiset<std::uint32_t>;
  EXPECT_EQ(ids(buses[0].receive), (Ids{0x11, 0x12}));
  EXPECT_EQ(ids(buses[0].transmit),
            (Ids{0x001, 0x002, 0x101, 0x102, 0x201, 0x202, 0x301, 0x302, 0x7FF}));
  EXPECT_EQ(ids(buses[1].receive), (Ids{0x11}));
  EXPECT_EQ(buses[1].name, "right");
}

TEST(ArmOptions, RefusesWhatCannotBe) {
  const auto expect = [](const std::string& found, const std::string& words) {
    EXPECT_NE(found.find(words), std::string::npos) << found;
  };
  EXPECT_EQ(refusal([](ArmOptions&) {}), "");
  expect(refusal([](ArmOptions& o) { o.joints.clear(); }), "0 joints");
  expect(refusal([](ArmOptions& o) { o.joints.resize(33); }), "33 joints");
  expect(refusal([](ArmOptions& o) { o.buses.clear(); }), "0 buses");
  expect(refusal([](ArmOptions& o) { o.joints[1].bus = 2; }), "joint 'b': its bus has index 2");
  expect(refusal([](ArmOptions& o) { o.joints[1].direction = 0.5; }), "direction is 0.5");
  expect(refusal([](ArmOptions& o) { o.joints[1].ratio = -1.0; }), "ratio is -1");
  expect(refusal([](ArmOptions& o) { o.joints[1].offset = HUGE_VAL; }), "offset is inf");
  expect(refusal([](ArmOptions& o) { o.joints[1].drive.family = "damio"; }), "known: damiao");
  expect(refusal([](ArmOptions& o) { o.joints[1].drive.reply_id = 0; }), "MST_ID");
  expect(refusal([](ArmOptions& o) { o.joints[1].drive.fd = true; }), "'left' is classic CAN");
  expect(refusal([](ArmOptions& o) { o.joints[1].drive.id = 1; }), "also that of joint 'a'");
  expect(refusal([](ArmOptions& o) { o.joints[1].drive.reply_id = 0x11; }), "answers on 0x11");
  expect(refusal([](ArmOptions& o) { o.joints[1].drive.reply_id = 0x201; }), "which commands");
  EXPECT_THROW(Arm(arm(), {}), std::invalid_argument);
}

}  // namespace
}  // namespace geodesic::drivers::test
