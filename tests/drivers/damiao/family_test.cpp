// The Damiao family for people: words for frames, checks of options; and the table it stands in.
#include "drivers/damiao/family.hpp"

#include <gtest/gtest.h>

#include <set>

#include "tests/drivers/damiao/bench.hpp"

namespace geodesic::drivers::damiao::test {
namespace {

std::string words(const Frame& frame) {
  const auto decoded = decode(frame, bench_options());
  if (!decoded) {
    return "nothing";
  }
  std::string text = decoded->kind;
  for (const DecodedField& field : decoded->fields) {
    text += ", " + field.name + " " + field.value + (field.unit.empty() ? "" : " " + field.unit);
  }
  return text;
}

TEST(DamiaoFamily, TellsFramesInWords) {
  EXPECT_EQ(words(encode_special(5, false, Special::kEnable)), "enable");
  EXPECT_EQ(words(encode_special(5, false, Special::kSetZero)), "set zero");
  EXPECT_EQ(words(encode_state_request(5, false)), "state request");
  EXPECT_EQ(words(encode_save(5, false)), "save registers");
  EXPECT_EQ(words(encode_read(5, false, 21)), "register read request, register 21, name PMAX");
  EXPECT_EQ(words(encode_write(5, false, 9, 1000)),
            "register write request, register 9, name TIMEOUT, value 1000 50 µs");
  EXPECT_EQ(words(encode_read(6, false, 21)), "nothing");
  EXPECT_EQ(words(*encode_mit(5, false, {.torque_nm = 10.0}, {12.5, 30.0, 10.0})),
            "MIT command, position 0.000190738 rad, velocity 0.00732601 rad/s, stiffness 0 "
            "N·m/rad, damping 0 N·m·s/rad, torque 10 N·m");
  EXPECT_EQ(words(*encode_velocity(5, false, -1.5)), "velocity command, velocity -1.5 rad/s");
  EXPECT_EQ(words(*encode_position_velocity(5, false, {1.0, 2.0})),
            "position-velocity command, position 1 rad, velocity limit 2 rad/s");
  EXPECT_EQ(words(*encode_position_force(5, false, {1.0, 2.0, 0.5})),
            "position-force command, position 1 rad, velocity limit 2 rad/s, current limit 0.5 of "
            "maximum");
  Frame reply;
  reply.id = 0x15;
  reply.length = 8;
  reply.data = {0x05, 0x00, 0x33, 0x15, 0x00, 0x00, 0x48, 0x41};
  EXPECT_EQ(words(reply), "register read reply, register 21, name PMAX, value 12.5 rad");
  reply.data = {0xD5, 0xFF, 0xFF, 0xFF, 0xFF, 0xFF, 0x1C, 0x36};
  EXPECT_EQ(words(reply),
            "state, status communication lost (the drive's watchdog expired), position 12.5 rad, "
            "velocity 30 rad/s, torque 10 N·m, MOSFET temperature 28 °C, rotor temperature 54 °C");
  reply.id = 0x16;
  EXPECT_EQ(words(reply), "nothing");
}

TEST(DamiaoFamily, ChecksOptions) {
  const auto wrong = [](auto change) {
    DriveOptions options = bench_options();
    change(options);
    return check(options).size();
  };
  EXPECT_EQ(wrong([](DriveOptions&) {}), 0U);
  EXPECT_EQ(wrong([](DriveOptions& o) { o.id = 0; }), 1U);
  EXPECT_EQ(wrong([](DriveOptions& o) { o.id = 0x100; }), 1U);
  EXPECT_EQ(wrong([](DriveOptions& o) { o.reply_id = 0; }), 1U);
  EXPECT_EQ(wrong([](DriveOptions& o) { o.reply_id = 0x7FF; }), 1U);
  EXPECT_EQ(wrong([](DriveOptions& o) { o.reply_id = o.id; }), 1U);
  EXPECT_EQ(wrong([](DriveOptions& o) { o.reply_id = o.id + 0x200; }), 1U);
  EXPECT_EQ(wrong([](DriveOptions& o) { o.position_range_rad = 0.0; }), 1U);
  EXPECT_EQ(wrong([](DriveOptions& o) { o.velocity_range_rad_s = -1.0; }), 1U);
  EXPECT_EQ(wrong([](DriveOptions& o) { o.torque_range_nm = 0.0 / 0.0; }), 1U);
  EXPECT_EQ(wrong([](DriveOptions& o) { o.watchdog_ns = 0; }), 1U);
  EXPECT_EQ(wrong([](DriveOptions& o) { o.watchdog_ns = 11'000'000'000; }), 1U);
}

TEST(DamiaoFamily, NamesItsErrors) {
  std::set<std::string> names;
  for (std::uint8_t code = 8; code <= 14; ++code) {
    names.insert(error_name(code));
  }
  EXPECT_EQ(names.size(), 7U);
  EXPECT_STREQ(error_name(5), "unknown error");
}

TEST(Families, AreFoundByName) {
  ASSERT_NE(find_family("damiao"), nullptr);
  EXPECT_EQ(find_family("damiano"), nullptr);
  for (const Family& family : families()) {
    EXPECT_EQ(find_family(family.name), &family);
    EXPECT_FALSE(family.summary.empty());
    EXPECT_NE(family.make_drive(bench_options()), nullptr);
    EXPECT_NE(family.make_simulated(bench_options()), nullptr);
  }
}

}  // namespace
}  // namespace geodesic::drivers::damiao::test
