// Looking for Damiao drives and setting their zeros, on a bus in memory: who is found, what is said
// of them, and that nothing is moved, enabled or written.
#include "drivers/damiao/scanner.hpp"

#include <gtest/gtest.h>

#include <deque>
#include <functional>
#include <memory>

#include "drivers/damiao/family.hpp"
#include "drivers/damiao/zeroing.hpp"
#include "tests/drivers/damiao/bench.hpp"

namespace geodesic::drivers::damiao::test {
namespace {

DriveOptions drive(std::uint32_t id, std::uint32_t reply_id, bool fd = false) {
  DriveOptions options = bench_options();
  options.id = id;
  options.reply_id = reply_id;
  options.fd = fd;
  return options;
}

struct Shelf {
  Simulated& add(const DriveOptions& options) { return drives.emplace_back(options); }

  void run(BenchDialogue& dialogue, int most_ms = 3000) {
    for (int i = 0; i < most_ms && !dialogue.over(); ++i) {
      now_ns += 1'000'000;
      const std::optional<Frame> asked = dialogue.transmit(now_ns);
      if (!asked) continue;
      sent.push_back(*asked);
      for (Simulated& one : drives) {
        std::array<Frame, 4> replies;
        const std::size_t count = one.receive(*asked, now_ns, replies);
        for (std::size_t r = 0; r < count && !mute; ++r) {
          if (change) change(replies[r]);
          dialogue.receive({replies[r], now_ns + 300'000});
        }
      }
      if (step) step();
    }
  }

  std::vector<FoundDrive> scan(bool fd = false) {
    Scanner scanner(fd);
    run(scanner);
    EXPECT_TRUE(scanner.over());
    return scanner.found();
  }

  std::deque<Simulated> drives;
  std::vector<Frame> sent;
  bool mute = false;
  std::function<void(Frame&)> change;
  std::function<void()> step;
  std::int64_t now_ns = 0;
};

std::string all_remarks(const FoundDrive& found) {
  std::string text;
  for (const std::string& remark : found.remarks) text += remark + "\n";
  return text;
}

TEST(DamiaoScanner, FindsWhoAnswersAndWhatTheyAre) {
  Shelf shelf;
  shelf.add(drive(0x01, 0x11));
  shelf.add(drive(0x7F, 0x300));
  shelf.add(drive(0xFF, 0x0FE, true));  // another wire format: silent here
  const std::vector<FoundDrive> found = shelf.scan();
  ASSERT_EQ(found.size(), 2U);
  EXPECT_EQ(found[0].id, 0x01U);
  EXPECT_EQ(found[0].reply_id, 0x11U);
  EXPECT_EQ(found[1].id, 0x7FU);
  EXPECT_EQ(found[1].reply_id, 0x300U);
  EXPECT_EQ(found[0].firmware, "5016");
  EXPECT_EQ(found[0].model, "DM4310 by its ranges");
  const std::vector<std::pair<std::string, std::string>> options{
      {"position_range_rad", "12.5"}, {"velocity_range_rad_s", "30"}, {"torque_range_nm", "10"}};
  EXPECT_EQ(found[0].options, options);
  EXPECT_EQ(all_remarks(found[0]), "");
  ASSERT_EQ(shelf.scan(true).size(), 1U);
}

TEST(DamiaoScanner, OnlyReadsAndTakesItsTime) {
  Shelf shelf;
  shelf.add(drive(0x05, 0x15));
  std::int64_t last = -Scanner::kProbeNs;
  std::size_t probes = 0;
  shelf.step = [&] {
    if (shelf.sent.size() <= Scanner::kLastId) {
      EXPECT_GE(shelf.now_ns - last, Scanner::kProbeNs);
      ++probes;
    }
    last = shelf.now_ns;
  };
  shelf.scan();
  EXPECT_EQ(probes, Scanner::kLastId);
  for (const Frame& frame : shelf.sent) {
    EXPECT_EQ(frame.id, kRegisterId);
    EXPECT_TRUE(frame.data[2] == 0x33 || frame.data[2] == 0xCC);
  }
  EXPECT_FALSE(shelf.drives[0].enabled());
}

TEST(DamiaoScanner, SaysWhatAPersonShouldKnow) {
  Shelf shelf;
  shelf.add(drive(0x01, 0x00));
  shelf.add(drive(0x02, 0x00));
  shelf.add(drive(0x03, 0x01));
  shelf.add(drive(0x04, 0x14));
  shelf.add(drive(0x04, 0x24));
  shelf.drives[0].set_register(9, 0);
  shelf.drives[1].inject_error(0xC);
  shelf.drives[2].set_register(10, 2);
  shelf.drives[3].set_register(23, Bench::raw(-3.0));
  shelf.drives[4].set_register(23, Bench::raw(-3.0));
  const std::vector<FoundDrive> found = shelf.scan();
  ASSERT_EQ(found.size(), 4U);
  EXPECT_NE(all_remarks(found[0]).find("factory setting"), std::string::npos);
  EXPECT_NE(all_remarks(found[0]).find("as drive 0x2 does"), std::string::npos);
  EXPECT_NE(all_remarks(found[0]).find("watchdog is off"), std::string::npos);
  EXPECT_NE(all_remarks(found[1]).find("rotor over-temperature"), std::string::npos);
  EXPECT_NE(all_remarks(found[2]).find("its reports command that one"), std::string::npos);
  EXPECT_NE(all_remarks(found[2]).find("CTRL_MODE (register 10) is 2"), std::string::npos);
  EXPECT_NE(all_remarks(found[3]).find("two drives answer to this id"), std::string::npos);
  EXPECT_NE(all_remarks(found[3]).find("no range a drive can work with"), std::string::npos);
  EXPECT_EQ(found[3].options.size(), 2U);
}

TEST(DamiaoScanner, TakesAnAnswerThatABusyHostReadsLate) {
  Simulated one(drive(0x01, 0x11));
  Simulated last(drive(0xFF, 0x1FF));
  Scanner scanner(false);
  std::deque<ReceivedFrame> waiting;
  for (std::int64_t now_ns = 0; now_ns < 3'000'000'000 && !scanner.over(); now_ns += 1'000'000) {
    if (const std::optional<Frame> asked = scanner.transmit(now_ns)) {
      for (Simulated* drive : {&one, &last}) {
        std::array<Frame, 4> replies;
        if (drive->receive(*asked, now_ns, replies) == 1) {
          waiting.push_back({replies[0], now_ns + 15'000'000});
        }
      }
    }
    while (!waiting.empty() && waiting.front().stamp_ns <= now_ns) {
      scanner.receive(waiting.front());
      waiting.pop_front();
    }
  }
  ASSERT_EQ(scanner.found().size(), 2U);
  EXPECT_EQ(scanner.found()[1].id, 0xFFU);
  EXPECT_EQ(scanner.found()[1].options.size(), 3U);
}

TEST(DamiaoScanner, IsNotTakenInByNonsense) {
  Shelf shelf;
  shelf.add(drive(0x05, 0x15));
  shelf.change = [](Frame& frame) { frame.data[2] = static_cast<std::uint8_t>(~frame.data[2]); };
  EXPECT_TRUE(shelf.scan().empty());
  shelf.change = [](Frame& frame) { frame.length = 7; };
  EXPECT_TRUE(shelf.scan().empty());
  shelf.change = [](Frame& frame) { frame.extended = true; };
  EXPECT_TRUE(shelf.scan().empty());
  // It tells its id, and nothing else.
  shelf.change = [](Frame& frame) { frame.length = frame.data[3] == 8 ? 8 : 3; };
  const std::vector<FoundDrive> found = shelf.scan();
  ASSERT_EQ(found.size(), 1U);
  EXPECT_TRUE(found[0].options.empty());
  EXPECT_NE(all_remarks(found[0]).find("does not answer a state request"), std::string::npos);
}

TEST(DamiaoZeroing, SetsTheZeroAndReadsItBack) {
  Shelf shelf;
  Simulated& one = shelf.add(bench_options());
  one.set_shaft(1.25, 0.0);
  Zeroing zeroing(bench_options());
  shelf.run(zeroing);
  EXPECT_TRUE(zeroing.done()) << zeroing.report();
  EXPECT_NEAR(zeroing.before_rad(), 1.25, 1e-3);
  EXPECT_NEAR(zeroing.after_rad(), 0.0, 1e-3);
  EXPECT_NE(zeroing.report().find("stood at +1.2"), std::string::npos) << zeroing.report();
  EXPECT_FALSE(one.enabled());
  one.power_cycle();
  Zeroing again(bench_options());
  shelf.run(again);
  EXPECT_NEAR(again.before_rad(), 0.0, 1e-3);
}

std::string refusal(Shelf& shelf, const DriveOptions& options = bench_options()) {
  const std::size_t before = shelf.sent.size();
  Zeroing zeroing(options);
  shelf.run(zeroing);
  EXPECT_TRUE(zeroing.over());
  EXPECT_FALSE(zeroing.done());
  for (std::size_t i = before; i < shelf.sent.size(); ++i) {
    EXPECT_NE(decode_special(shelf.sent[i]), Special::kSetZero);
  }
  return zeroing.report();
}

TEST(DamiaoZeroing, RefusesBeforeItWrites) {
  Shelf shelf;
  Simulated& one = shelf.add(bench_options());
  DriveOptions wrong = bench_options();
  wrong.position_range_rad = 3.14159;
  EXPECT_NE(refusal(shelf, wrong).find("PMAX (register 21) is 12.5"), std::string::npos);

  std::array<Frame, 4> out;
  one.receive(encode_special(5, false, Special::kEnable), shelf.now_ns, out);
  ASSERT_TRUE(one.enabled());
  EXPECT_NE(refusal(shelf).find("is enabled"), std::string::npos);
  EXPECT_TRUE(one.enabled());
  one.receive(encode_special(5, false, Special::kDisable), shelf.now_ns, out);

  one.inject_error(0xA);
  EXPECT_NE(refusal(shelf).find("over-current"), std::string::npos);
  one.power_cycle();

  double shaft = 0.0;
  shelf.step = [&] { one.set_shaft(shaft += 0.02, 0.0); };
  EXPECT_NE(refusal(shelf).find("moves"), std::string::npos);
  shelf.step = nullptr;

  shelf.mute = true;
  EXPECT_NE(refusal(shelf).find("does not answer"), std::string::npos);
}

TEST(DamiaoZeroing, SaysThatTheZeroWasNotTaken) {
  Shelf shelf;
  Simulated& one = shelf.add(bench_options());
  double shaft = 1.0;
  one.set_shaft(shaft, 0.0);
  std::size_t zeros = 0;
  shelf.step = [&] {  // moved away just as the zero is set
    if (decode_special(shelf.sent.back()) == Special::kSetZero) {
      ++zeros;
      one.set_shaft(shaft += 0.5, 0.0);
    }
  };
  Zeroing zeroing(bench_options());
  shelf.run(zeroing);
  EXPECT_TRUE(zeroing.over());
  EXPECT_FALSE(zeroing.done());
  EXPECT_EQ(zeros, 3U);
  EXPECT_NE(zeroing.report().find("has not taken its zero"), std::string::npos);
}

}  // namespace
}  // namespace geodesic::drivers::damiao::test
