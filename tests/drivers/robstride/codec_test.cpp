// RobStride frames <-> numbers beyond the golden vectors: limits, refusals, what looks alike.
#include "drivers/robstride/codec.hpp"

#include <gtest/gtest.h>

#include <cmath>
#include <limits>

#include "drivers/robstride/mit.hpp"
#include "tests/drivers/robstride/bench.hpp"

namespace geodesic::drivers::robstride::test {
namespace {

TEST(RobstrideCodec, NumbersThatAreNotFiniteAreRefused) {
  for (const double bad : {std::nan(""), std::numeric_limits<double>::infinity(),
                           -std::numeric_limits<double>::infinity()}) {
    for (double ControlCommand::*member :
         {&ControlCommand::position_rad, &ControlCommand::velocity_rad_s,
          &ControlCommand::stiffness_nm_rad, &ControlCommand::damping_nm_s_rad,
          &ControlCommand::torque_nm}) {
      ControlCommand command;
      command.*member = bad;
      EXPECT_FALSE(encode_control(5, command, kRanges));
      EXPECT_FALSE(encode_mit(5, command, kRanges));
    }
  }
}

TEST(RobstrideCodec, ClampsToTheRanges) {
  const ControlCommand beyond{100.0, 100.0, 1000.0, 100.0, 100.0};
  const ControlCommand below{-100.0, -100.0, -1.0, -1.0, -100.0};
  const auto high = decode_control(*encode_control(5, beyond, kRanges), kRanges);
  const auto low = decode_control(*encode_control(5, below, kRanges), kRanges);
  EXPECT_DOUBLE_EQ(high->position_rad, kRanges.position_rad);
  EXPECT_DOUBLE_EQ(high->velocity_rad_s, kRanges.velocity_rad_s);
  EXPECT_DOUBLE_EQ(high->stiffness_nm_rad, kRanges.stiffness_nm_rad);
  EXPECT_DOUBLE_EQ(high->damping_nm_s_rad, kRanges.damping_nm_s_rad);
  EXPECT_DOUBLE_EQ(high->torque_nm, kRanges.torque_nm);
  EXPECT_DOUBLE_EQ(low->position_rad, -kRanges.position_rad);
  EXPECT_DOUBLE_EQ(low->velocity_rad_s, -kRanges.velocity_rad_s);
  EXPECT_DOUBLE_EQ(low->stiffness_nm_rad, 0.0);
  EXPECT_DOUBLE_EQ(low->damping_nm_s_rad, 0.0);
  EXPECT_DOUBLE_EQ(low->torque_nm, -kRanges.torque_nm);
}

TEST(RobstrideCodec, TheTorqueNeverLeavesItsPlaceInTheIdentifier) {
  for (double torque = -20.0; torque <= 20.0; torque += 0.01) {
    const auto frame = encode_control(5, {.torque_nm = torque}, kRanges);
    ASSERT_TRUE(frame);
    EXPECT_EQ(type_of(frame->id), Type::kControl);
    EXPECT_EQ(frame->id & kDestinationMask, 5U);
  }
}

TEST(RobstrideCodec, EveryCodeComesBack) {
  for (std::uint32_t code = 0; code <= 0xFFFF; code += 17) {
    EXPECT_EQ(to_code(from_code(code, -17.0, 17.0), -17.0, 17.0), code);
  }
}

TEST(RobstrideCodec, OnlyFramesOfTheProtocolAreDecoded) {
  Frame good = encode_stop(kLink, false);
  good.id = identifier(Type::kFeedback, 0x8005, 0xFD);
  ASSERT_TRUE(decode_feedback(good, kRanges));
  for (bool Frame::*flag : {&Frame::fd, &Frame::remote, &Frame::error}) {
    Frame bad = good;
    bad.*flag = true;
    EXPECT_FALSE(decode_feedback(bad, kRanges));
  }
  Frame bad = good;
  bad.extended = false;
  EXPECT_FALSE(decode_feedback(bad, kRanges));
  bad = good;
  bad.length = 7;
  EXPECT_FALSE(decode_feedback(bad, kRanges));
  EXPECT_FALSE(decode_parameter(good));
  EXPECT_FALSE(decode_fault_report(good));
  EXPECT_FALSE(decode_identity(good));
}

TEST(RobstrideCodec, ModeFaultsAndEndsOfTheRangeAreRead) {
  Frame frame = encode_stop(kLink, false);
  frame.id = 0x02BF05FD;
  frame.data = {0xFF, 0xFF, 0, 0, 0xFF, 0xFF, 0x01, 0x02};
  const auto feedback = decode_feedback(frame, kRanges);
  ASSERT_TRUE(feedback);
  EXPECT_EQ(feedback->mode, 2);
  EXPECT_EQ(feedback->faults, 0x3F);
  EXPECT_TRUE(feedback->at_end);
  EXPECT_DOUBLE_EQ(feedback->torque_nm, 17.0);
  EXPECT_DOUBLE_EQ(feedback->temperature_c, 25.8);
}

TEST(RobstrideCodec, TheVersionIsReadFromItsAnswerOnly) {
  Frame frame = encode_version_query(kLink);
  EXPECT_EQ(frame.data[1], 0xC4);
  EXPECT_FALSE(decode_version(frame));
  frame.id = identifier(Type::kFeedback, 5, 0xFD);
  EXPECT_FALSE(decode_version(frame));
  frame.data = {0x00, 0xC4, 0x56, 0, 1, 2, 33, 0};
  EXPECT_EQ(decode_version(frame), 10233U);
}

TEST(RobstrideCodec, AnMitCommandNeverLooksLikeASpecialFrame) {
  for (unsigned code = 0; code <= 0xFFF; ++code) {
    const double torque = -17.0 + 34.0 * code / 4095.0;
    for (const double damping : {5.0, 5.0 * 4094.0 / 4095.0, 5.0 * 4081.0 / 4095.0}) {
      const auto frame = encode_mit(5, {12.57, 44.0, 500.0, damping, torque}, kRanges);
      ASSERT_TRUE(frame);
      EXPECT_TRUE(decode_mit(*frame, kRanges)) << code;
    }
  }
  Frame enable;
  enable.length = 8;
  enable.data.fill(0xFF);
  enable.data[7] = 0xFC;
  EXPECT_FALSE(decode_mit(enable, kRanges));
}

}  // namespace
}  // namespace geodesic::drivers::robstride::test
