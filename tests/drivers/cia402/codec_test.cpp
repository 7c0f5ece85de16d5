// The CANopen codec by itself: signs, sizes, rounding, refusals; and that a wrong vector is
// noticed.
#include "drivers/cia402/codec.hpp"

#include <gtest/gtest.h>

#include <cmath>
#include <fstream>
#include <sstream>

#include "drivers/cia402/errors.hpp"
#include "tests/drivers/cia402/vectors.hpp"

namespace geodesic::drivers::cia402 {
namespace {

TEST(Cia402Codec, EveryPerMilleSurvivesDecodingAndEncoding) {
  for (const double rated : {0.05, 1.27, 28.0, 330.0}) {
    for (int permille = -32767; permille <= 32767; ++permille) {
      const double torque = from_permille(permille, rated);
      ASSERT_EQ(to_permille(torque, rated, 32767), permille) << rated;
    }
  }
}

TEST(Cia402Codec, EveryTorqueFrameSurvives) {
  for (int torque = -32768; torque <= 32767; ++torque) {
    const TorqueCommand command{0x0F, static_cast<std::int16_t>(torque)};
    ASSERT_EQ(decode_torque(encode_torque(127, command)), command);
  }
  for (const std::int32_t position : {0, -1, 2147483647, -2147483647 - 1}) {
    const Report report{0x1637, position, -5};
    EXPECT_EQ(decode_report(encode_report(1, report)), report);
    EXPECT_EQ(decode_velocity(encode_velocity(1, position)), position);
  }
}

TEST(Cia402Codec, SdoSizesAreThoseOfTheObject) {
  for (std::uint8_t bytes = 1; bytes <= 4; ++bytes) {
    const Object object{0x6040, 2, bytes};
    const std::uint32_t value = 0xFFFFFFFFU >> (32U - 8U * bytes);
    const Sdo write{Sdo::Kind::kWrite, 0x6040, 2, bytes, value};
    const Sdo read{Sdo::Kind::kReadReply, 0x6040, 2, bytes, value};
    EXPECT_EQ(decode_sdo_request(encode_write(5, object, 0xFFFFFFFF)), write);
    EXPECT_EQ(decode_sdo_reply(encode_read_reply(5, object, 0xFFFFFFFF)), read);
  }
}

TEST(Cia402Codec, OtherTransfersAreNotTakenForExpeditedOnes) {
  Frame frame = encode_read_reply(5, object::kRatedTorque, 1);
  for (const int first : {0x41, 0x00, 0x20, 0xA0, 0xC0, 0x61}) {
    frame.data[0] = static_cast<std::uint8_t>(first);
    EXPECT_FALSE(decode_sdo_reply(frame)) << first;
  }
  frame = encode_write(5, object::kRatedTorque, 1);
  for (const int first : {0x21, 0x00, 0x60, 0xA0}) {
    frame.data[0] = static_cast<std::uint8_t>(first);
    EXPECT_FALSE(decode_sdo_request(frame)) << first;
  }
}

TEST(Cia402Codec, FramesOfOtherFormsAreNotDecoded) {
  const auto spoiled = [](Frame frame, auto decode) {
    const auto refuses = [&](auto change) {
      Frame other = frame;
      change(other);
      return !decode(other);
    };
    return decode(frame) && refuses([](Frame& f) { f.extended = true; }) &&
           refuses([](Frame& f) { f.fd = true; }) && refuses([](Frame& f) { f.remote = true; }) &&
           refuses([](Frame& f) { f.error = true; }) &&
           refuses([](Frame& f) { f.length = static_cast<std::uint8_t>(f.length + 3); });
  };
  EXPECT_TRUE(spoiled(encode_sync(), [](const Frame& f) { return decode_sync(f); }));
  EXPECT_TRUE(spoiled(encode_nmt({}), [](const Frame& f) { return decode_nmt(f).has_value(); }));
  EXPECT_TRUE(spoiled(encode_heartbeat(1, NmtState::kOperational),
                      [](const Frame& f) { return decode_heartbeat(f).has_value(); }));
  EXPECT_TRUE(
      spoiled(encode_torque(1, {}), [](const Frame& f) { return decode_torque(f).has_value(); }));
  EXPECT_TRUE(
      spoiled(encode_report(1, {}), [](const Frame& f) { return decode_report(f).has_value(); }));
  EXPECT_TRUE(spoiled(encode_velocity(1, 0),
                      [](const Frame& f) { return decode_velocity(f).has_value(); }));
  EXPECT_TRUE(spoiled(encode_emergency(1, {}),
                      [](const Frame& f) { return decode_emergency(f).has_value(); }));
  EXPECT_TRUE(spoiled(encode_read(1, object::kMode),
                      [](const Frame& f) { return decode_sdo_request(f).has_value(); }));
  EXPECT_TRUE(spoiled(encode_write_reply(1, object::kMode),
                      [](const Frame& f) { return decode_sdo_reply(f).has_value(); }));
}

TEST(Cia402Codec, EveryStatuswordNamesAtMostOneState) {
  for (std::uint32_t word = 0; word <= 0xFFFF; ++word) {
    int named = 0;
    for (const PowerStateBits& one : kPowerStates) {
      named += (word & one.mask) == one.bits ? 1 : 0;
    }
    ASSERT_LE(named, 1) << word;
  }
  for (std::size_t i = 0; i < kPowerStates.size(); ++i) {
    EXPECT_EQ(static_cast<std::size_t>(kPowerStates[i].state), i);
  }
}

TEST(Cia402Codec, EmergencyCodesHaveNumbersAndNames) {
  EXPECT_EQ(error_of(0), 0);
  for (int code = 1; code <= 0xFFFF; ++code) {
    const std::uint8_t error = error_of(static_cast<std::uint16_t>(code));
    ASSERT_NE(error, 0) << code;
    ASSERT_STRNE(error_name(error), "unknown error");
  }
  EXPECT_STREQ(error_name(error_of(0x2310)), "over-current (0x2310)");
  EXPECT_STREQ(error_name(error_of(0x2311)), "current (class 0x2xxx)");
  EXPECT_STREQ(error_name(error_of(0xFF07)), "vendor-specific (0xFFxx): see the drive's manual");
  EXPECT_STREQ(error_name(200), "unknown error");
  EXPECT_NE(std::string(abort_meaning(0x06040042)).find("PDO too long"), std::string::npos);
  EXPECT_NE(std::string(abort_meaning(1)).find("does not name"), std::string::npos);
}

TEST(Cia402Vectors, AWrongVectorIsNoticed) {
  const auto problems = [](const std::string& row) {
    std::istringstream stream("direction,description,can_id,is_extended,is_fd,data,values\n" + row +
                              "\n");
    return drivers::test::check_cia402_row(drivers::test::read_rows(stream, "brought.csv").front())
        .size();
  };
  const std::string torque =
      ",node=3;controlword=15;target_torque=-1000;torque_nm=-28.0;"
      "rated_torque_mnm=28000";
  EXPECT_EQ(problems("command,right,203,0,0,0F0018FC" + torque), 0U);
  for (const char* bytes : {"0F0019FC", "0E0018FC", "0F00FC18", "0F0018"}) {
    EXPECT_NE(problems(std::string("command,wrong,203,0,0,").append(bytes).append(torque)), 0U);
  }
  EXPECT_NE(problems("command,wrong,204,0,0,0F0018FC" + torque), 0U);
  EXPECT_NE(problems("feedback,wrong,183,0,0,371640E201000002,node=3;statusword=5687;"
                     "state=SWITCHED ON;position=123456;torque_actual=512"),
            0U);
  EXPECT_NE(problems("feedback,SDO upload,583,0,0,43766000606D0000,node=3;index=24694;sub=0;"
                     "value=28001"),
            0U);
  EXPECT_NE(problems("command,SDO download,603,0,0,4076600000000000,node=3;index=24694;sub=0"), 0U);
  EXPECT_NE(problems("command,what,103,0,0,00,node=3"), 0U);
}

TEST(Cia402Vectors, EveryRowOfTheFileAgrees) {
  const std::string file = GEODESIC_TEST_DATA "/vectors/cia402.csv";
  std::ifstream stream(file);
  const auto rows = drivers::test::read_rows(stream, file);
  EXPECT_EQ(rows.size(), 71U);
  for (const auto& row : rows) {
    for (const std::string& problem : drivers::test::check_cia402_row(row)) {
      ADD_FAILURE_AT(file.c_str(), row.line) << row.description << ": " << problem;
    }
  }
}

}  // namespace
}  // namespace geodesic::drivers::cia402
