// Frames in candump's words.
#include "drivers/bus/frame_text.hpp"

#include <linux/can/error.h>

#include "tests/drivers/bus/bus_testing.hpp"

namespace geodesic::drivers {
namespace {

using testing::make_fd_frame;
using testing::make_frame;

TEST(FrameText, AsCandumpWritesIt) {
  EXPECT_EQ(candump_text(make_frame(0x12, {1, 0xAB})), "012#01AB");
  Frame extended = make_frame(0x1ABCDEF0, {255});
  extended.extended = true;
  EXPECT_EQ(candump_text(extended), "1ABCDEF0#FF");
  Frame fd = make_fd_frame(0x7, 12);
  EXPECT_EQ(candump_text(fd), "007##10708090A0B0C0D0E0F101112");
  fd.bit_rate_switch = false;
  EXPECT_TRUE(candump_text(fd).starts_with("007##0"));
  Frame remote = make_frame(0x123);
  remote.remote = true;
  EXPECT_EQ(candump_text(remote), "123#R");
  remote.length = 8;
  EXPECT_EQ(candump_text(remote), "123#R8");
  Frame bus_off = make_frame(CAN_ERR_BUSOFF, {0, 0, 0, 0, 0, 0, 0, 0});
  bus_off.error = true;
  EXPECT_EQ(candump_text(bus_off), "20000040#0000000000000000");
}

}  // namespace
}  // namespace geodesic::drivers
