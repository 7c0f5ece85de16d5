// Identifiers with data in them, and identifiers that drives share, find their joint.
#include "drivers/reply_routes.hpp"

#include <gtest/gtest.h>

#include <vector>

#include "drivers/bus/id_set.hpp"

namespace geodesic::drivers {
namespace {

std::vector<std::size_t> asked(const ReplyRoutes& routes, std::uint32_t id, bool extended,
                               std::size_t taker = 99) {
  Frame frame;
  frame.id = id;
  frame.extended = extended;
  std::vector<std::size_t> joints;
  routes.find(frame, [&](std::size_t joint) {
    joints.push_back(joint);
    return joint == taker;
  });
  return joints;
}

using Joints = std::vector<std::size_t>;

TEST(ReplyRoutes, ExactIdentifiersAreToldApartByTheirLength) {
  ReplyRoutes routes;
  routes.add({.id = 0x15}, 0);
  routes.add({.id = 0x15, .extended = true}, 1);
  EXPECT_EQ(asked(routes, 0x15, false), Joints{0});
  EXPECT_EQ(asked(routes, 0x15, true), Joints{1});
  EXPECT_EQ(asked(routes, 0x16, false), Joints{});
}

TEST(ReplyRoutes, AMaskLetsDataStandInTheIdentifier) {
  ReplyRoutes routes;
  routes.add({.id = 0x02007FFD, .extended = true, .mask = 0x1F00FFFF}, 3);
  EXPECT_EQ(asked(routes, 0x02A57FFD, true), Joints{3});
  EXPECT_EQ(asked(routes, 0x02A57EFD, true), Joints{});
}

TEST(ReplyRoutes, ASharedIdentifierIsOfferedUntilADriveTakesIt) {
  ReplyRoutes routes;
  for (std::size_t joint = 0; joint < 3; ++joint) {
    routes.add({.id = 0, .shared = true}, joint);
  }
  EXPECT_EQ(asked(routes, 0, false, 1), (Joints{0, 1}));
  EXPECT_EQ(asked(routes, 0, false), (Joints{0, 1, 2}));
}

TEST(IdFilter, OverlapsWhereBothMatch) {
  EXPECT_TRUE(overlap({.id = 0x60, .mask = 0x7E0}, {.id = 0x69}));
  EXPECT_FALSE(overlap({.id = 0x60, .mask = 0x7E0}, {.id = 0x80}));
  EXPECT_FALSE(overlap({.id = 0x60}, {.id = 0x60, .extended = true}));
  EXPECT_TRUE(overlap({.id = 0x60, .mask = 0x7E0}, {.id = 0x01, .mask = 0x01F}));
}

TEST(IdSet, HoldsWhatAMaskLetsIn) {
  const std::vector<IdFilter> ids = {{.id = 0x60, .mask = 0x7E0},
                                     {.id = 0x02007FFD, .extended = true, .mask = 0x1F00FFFF}};
  const IdSet set(ids);
  for (std::uint32_t id = 0; id < 0x800; ++id) {
    Frame frame;
    frame.id = id;
    EXPECT_EQ(set.contains(frame), id >> 5U == 3U) << id;
  }
  Frame frame;
  frame.extended = true;
  frame.id = 0x02FF7FFD;
  EXPECT_TRUE(set.contains(frame));
  frame.id = 0x03FF7FFD;
  EXPECT_FALSE(set.contains(frame));
}

}  // namespace
}  // namespace geodesic::drivers
