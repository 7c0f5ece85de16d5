// The CiA 402 family for people: words for frames, checks of options, frames of a cycle, and the
// dialogues of the bench.
#include "drivers/cia402/family.hpp"

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <limits>
#include <numbers>

#include "drivers/cia402/scanner.hpp"
#include "drivers/cia402/zeroing.hpp"
#include "tests/drivers/cia402/bench.hpp"

namespace geodesic::drivers::cia402::test {
namespace {

std::string words(const Frame& frame) {
  const auto decoded = decode(frame, bench_options());
  if (!decoded) {
    return "nothing";
  }
  std::string text = decoded->kind;
  for (const DecodedField& field : decoded->fields) {
    text.append(", ").append(field.name).append(" ").append(field.value);
    text.append(field.unit.empty() ? "" : " ").append(field.unit);
  }
  return text;
}

TEST(Cia402Family, TellsFramesInWords) {
  EXPECT_EQ(words(encode_sync()), "SYNC");
  EXPECT_EQ(words(encode_nmt({NmtCommand::kStart, 3})), "NMT start");
  EXPECT_EQ(words(encode_nmt({NmtCommand::kStop, 0})), "NMT stop");
  EXPECT_EQ(words(encode_nmt({NmtCommand::kStop, 4})), "nothing");
  EXPECT_EQ(words(encode_heartbeat(3, NmtState::kBootUp)), "boot-up");
  EXPECT_EQ(words(encode_heartbeat(3, NmtState::kStopped)), "heartbeat, state stopped");
  EXPECT_EQ(words(encode_heartbeat(127, NmtState::kOperational)),
            "host's heartbeat, state operational");
  EXPECT_EQ(words(encode_torque(3, {0x0F, 250})),
            "torque command, controlword 0x000F, torque 7 N·m");
  EXPECT_EQ(words(encode_report(3, {0x1637, 819200, -500})),
            "state, state operation enabled, position 3.14159 rad, torque -14 N·m");
  EXPECT_EQ(words(encode_velocity(3, 1638400)), "velocity, velocity 6.28319 rad/s");
  EXPECT_EQ(words(encode_read(3, object::kRatedTorque)), "SDO read, object 0x6076:0");
  EXPECT_EQ(words(encode_write(3, object::kMode, 10)),
            "SDO write, object 0x6060:0, value 10, bytes 1");
  EXPECT_EQ(words(encode_read_reply(3, object::kRatedTorque, 280)),
            "SDO read reply, object 0x6076:0, value 280, bytes 4");
  EXPECT_EQ(words(encode_write_reply(3, object::kMode)), "SDO write reply, object 0x6060:0");
  EXPECT_EQ(words(encode_abort(3, object::kMode, Abort::kReadOnly)),
            "SDO abort, object 0x6060:0, code 0x06010002, meaning the drive aborts (0x06010002, "
            "read only): set it with the maker's tool");
  EXPECT_EQ(words(encode_emergency(3, {0x8130, 0x10})),
            "emergency, code 0x8130, error this host's heartbeat was missed (0x8130: the drive's "
            "watchdog), register 0x10");
  EXPECT_EQ(words(encode_emergency(3, {0, 0})),
            "emergency, code 0x0000, error none: cleared, register 0x00");
  EXPECT_EQ(words(encode_torque(4, {})), "nothing");
}

TEST(Cia402Family, ChecksOptions) {
  const auto wrong = [](auto change) {
    DriveOptions options = bench_options();
    change(options);
    return check(options).size();
  };
  EXPECT_EQ(wrong([](DriveOptions&) {}), 0U);
  EXPECT_EQ(wrong([](DriveOptions& o) { o.id = 0; }), 1U);
  EXPECT_EQ(wrong([](DriveOptions& o) { o.id = 128; }), 1U);
  EXPECT_EQ(wrong([](DriveOptions& o) { o.id = 127; }), 1U);  // the host's own
  EXPECT_EQ(wrong([](DriveOptions& o) { o.fd = true; }), 1U);
  EXPECT_EQ(wrong([](DriveOptions& o) { o.torque_range_nm = 0.0; }), 1U);
  EXPECT_EQ(wrong([](DriveOptions& o) { o.torque_range_nm = std::nan(""); }), 1U);
  EXPECT_EQ(wrong([](DriveOptions& o) { o.torque_range_nm = 0.01; }), 1U);
  EXPECT_EQ(wrong([](DriveOptions& o) { o.torque_range_nm = 1000.0; }), 1U);
  EXPECT_EQ(wrong([](DriveOptions& o) { o.velocity_range_rad_s = -1.0; }), 1U);
  EXPECT_EQ(wrong([](DriveOptions& o) { o.watchdog_ns = 29'000'000; }), 1U);
  EXPECT_EQ(wrong([](DriveOptions& o) { o.watchdog_ns = 11'000'000'000; }), 1U);
  EXPECT_EQ(wrong([](DriveOptions& o) { put(o, Setting::kRatedTorque, 0.0); }), 1U);
  EXPECT_EQ(wrong([](DriveOptions& o) { put(o, Setting::kRatedTorque, 1.5); }), 1U);
  EXPECT_EQ(wrong([](DriveOptions& o) { put(o, Setting::kHostNode, 128); }), 1U);
  EXPECT_EQ(wrong([](DriveOptions& o) { put(o, Setting::kVelocityUnit, 5); }), 1U);
}

TEST(Cia402Family, TellsTheFramesOfACycle) {
  const std::vector<CyclicFrame> frames = cyclic_frames(bench_options(), 1000.0);
  ASSERT_EQ(frames.size(), 6U);
  EXPECT_EQ(frames[0].id, 0x203U);
  EXPECT_EQ(frames[0].bytes, 4);
  EXPECT_DOUBLE_EQ(frames[1].share, 0.1);
  EXPECT_TRUE(frames[2].once_a_bus);
  EXPECT_EQ(frames[2].bytes, 0);
  EXPECT_EQ(frames[3].id, 0x183U);
  EXPECT_EQ(frames[4].id, 0x283U);
  EXPECT_TRUE(frames[5].unasked);
  EXPECT_DOUBLE_EQ(frames[5].share, 0.05);
}

TEST(Cia402Family, KnowsWhatPowerOffForgets) {
  DriveOptions options = bench_options();
  EXPECT_EQ(family().position_period_rad(options), 0.0);
  put(options, Setting::kEncoderTurns, static_cast<double>(Turns::kLost));
  EXPECT_NEAR(family().position_period_rad(options), 2.0 * std::numbers::pi / 100.0, 1e-12);
  put(options, Setting::kEncoderAt, static_cast<double>(Side::kOutput));
  EXPECT_NEAR(family().position_period_rad(options), 2.0 * std::numbers::pi, 1e-12);
}

TEST(Cia402Family, NamesItsIdentifiers) {
  const Driver driver(bench_options());
  const auto ids = [](const std::vector<IdFilter>& filters) {
    std::vector<std::uint32_t> found;
    for (const IdFilter& filter : filters) {
      found.push_back(filter.id);
    }
    std::sort(found.begin(), found.end());
    return found;
  };
  EXPECT_EQ(ids(driver.reply_ids()),
            (std::vector<std::uint32_t>{0x083, 0x183, 0x283, 0x583, 0x703}));
  EXPECT_EQ(ids(driver.command_ids()),
            (std::vector<std::uint32_t>{0x000, 0x080, 0x203, 0x303, 0x403, 0x503, 0x603, 0x77F}));
}

TEST(Cia402Family, AcceptsItsOwnDefaults) {
  DriveOptions options;
  options.id = 1;
  options.torque_range_nm = 10.0;
  options.velocity_range_rad_s = 5.0;
  EXPECT_TRUE(check(options).empty());
  EXPECT_EQ(family().make_scanner(true), nullptr);  // no CANopen on CAN FD
}

/// Runs a dialogue against simulated drives, a millisecond at a time.
void converse(BenchDialogue& dialogue, std::vector<Simulated*> drives) {
  std::int64_t now_ns = 0;
  std::array<Frame, 4> reply;
  for (Simulated* drive : drives) {
    drive->speak(0, reply);
  }
  for (int i = 0; i < 20'000 && !dialogue.over(); ++i, now_ns += 1'000'000) {
    const std::optional<Frame> request = dialogue.transmit(now_ns);
    for (Simulated* drive : drives) {
      const std::size_t count = request ? drive->receive(*request, now_ns, reply) : 0;
      for (std::size_t k = 0; k < count; ++k) {
        dialogue.receive({reply[k], now_ns});
      }
    }
  }
  EXPECT_TRUE(dialogue.over());
}

TEST(Cia402Bench, TheScannerFindsDrivesAndChangesNothing) {
  DriveOptions other = bench_options();
  other.id = 126;
  Simulated one(bench_options());
  Simulated two(other);
  two.dictionary().remove(object::kRatedTorque);
  two.dictionary().set_factory(object::kSupportedModes, 1);
  CanopenScanner scanner;
  converse(scanner, {&two, &one});
  const std::vector<FoundDrive> found = scanner.found();
  ASSERT_EQ(found.size(), 2U);
  EXPECT_EQ(found[0].id, 3U);
  EXPECT_EQ(found[1].id, 126U);
  EXPECT_EQ(found[0].reply_id, 0U);
  EXPECT_EQ(found[0].firmware, "revision 0x00010002");
  const auto value = [&found](std::size_t drive, const char* key) -> std::string {
    for (const auto& [name, text] : found[drive].options) {
      if (name == key) {
        return text;
      }
    }
    return "none";
  };
  EXPECT_EQ(value(0, "encoder_increments"), "16384");
  EXPECT_EQ(value(0, "gear_motor_revolutions"), "100");
  EXPECT_EQ(value(0, "rated_torque_mnm"), "280");
  EXPECT_EQ(value(0, "torque_range_nm"), "28.0000");
  EXPECT_EQ(value(1, "rated_torque_mnm"), "none");
  EXPECT_GT(found[1].remarks.size(), found[0].remarks.size());
  EXPECT_EQ(one.nmt_state(), NmtState::kPreOperational);
  EXPECT_EQ(one.dictionary().value(object::kMode), 8U);
}

TEST(Cia402Bench, AnEmptyBusIsScannedInUnderASecond) {
  CanopenScanner scanner;
  std::int64_t now_ns = 0;
  for (; !scanner.over() && now_ns < 10'000'000'000; now_ns += 1'000'000) {
    scanner.transmit(now_ns);
  }
  EXPECT_LT(now_ns, 1'000'000'000);
  EXPECT_TRUE(scanner.found().empty());
}

TEST(Cia402Bench, ZeroingFindsTheSenseOfTheOffsetStoresAndReadsBack) {
  for (const auto kind : {Simulated::HomeOffset::kSubtracted, Simulated::HomeOffset::kAdded}) {
    for (const double angle : {0.7, -0.3, 0.0}) {
      Simulated drive(bench_options());
      drive.set_home_offset(kind);
      drive.dictionary().set_factory(object::kHomeOffset, 1234);
      drive.set_shaft(angle, 0.0);
      CanopenZeroing zeroing(bench_options());
      converse(zeroing, {&drive});
      EXPECT_TRUE(zeroing.done()) << zeroing.report();
      EXPECT_NEAR(zeroing.after_rad(), 0.0, 1e-3);
      EXPECT_NEAR(zeroing.before_rad(), angle, 0.01);
      drive.power_cycle();
      CanopenZeroing again(bench_options());
      converse(again, {&drive});
      EXPECT_NEAR(again.before_rad(), 0.0, 1e-3);  // it was kept
    }
  }
}

TEST(Cia402Bench, ZeroingRefusesAndLeavesTheDriveAsItWas) {
  const auto refused = [](auto prepare, const char* why) {
    Simulated drive(bench_options());
    drive.set_shaft(0.7, 0.0);
    drive.dictionary().set_factory(object::kHomeOffset, 1234);
    prepare(drive);
    CanopenZeroing zeroing(bench_options());
    converse(zeroing, {&drive});
    EXPECT_FALSE(zeroing.done());
    EXPECT_NE(zeroing.report().find(why), std::string::npos) << zeroing.report();
    return drive.dictionary().value(object::kHomeOffset);
  };
  EXPECT_EQ(refused([](Simulated& d) { d.set_home_offset(Simulated::HomeOffset::kOnlyByHoming); },
                    "only by homing"),
            1234U);
  EXPECT_EQ(refused([](Simulated& d) { d.inject_error(2); }, "an error"), 1234U);
  EXPECT_EQ(refused([](Simulated& d) { d.dictionary().remove(object::kStoreAll); }, "power-off"),
            1234U);
  EXPECT_EQ(refused([](Simulated& d) { d.dictionary().remove(object::kHomeOffset); }, "0x607C"),
            0U);
  Simulated enabled(bench_options());
  std::array<Frame, 4> reply;
  enabled.speak(0, reply);
  for (const std::uint32_t word : {0x06U, 0x07U, 0x0FU}) {
    enabled.receive(encode_write(3, object::kControlword, word), 0, reply);
  }
  ASSERT_TRUE(enabled.enabled());
  CanopenZeroing zeroing(bench_options());
  converse(zeroing, {&enabled});
  EXPECT_NE(zeroing.report().find("is enabled"), std::string::npos);
  CanopenZeroing nobody(bench_options());
  converse(nobody, {});
  EXPECT_NE(nobody.report().find("does not answer"), std::string::npos);
}

TEST(Cia402Bench, ZeroingRefusesAMovingJoint) {
  Simulated drive(bench_options());
  std::array<Frame, 4> reply;
  drive.speak(0, reply);
  CanopenZeroing zeroing(bench_options());
  for (std::int64_t now_ns = 0; !zeroing.over() && now_ns < 5'000'000'000; now_ns += 1'000'000) {
    drive.set_shaft(static_cast<double>(now_ns) * 1e-10, 0.1);
    if (const std::optional<Frame> request = zeroing.transmit(now_ns)) {
      if (drive.receive(*request, now_ns, reply) == 1) {
        zeroing.receive({reply[0], now_ns});
      }
    }
  }
  EXPECT_NE(zeroing.report().find("moves"), std::string::npos) << zeroing.report();
}

}  // namespace
}  // namespace geodesic::drivers::cia402::test
