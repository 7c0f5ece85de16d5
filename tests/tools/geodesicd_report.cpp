// The shape of status and summary, the trace, and files that are whole or not there.
#include "tools/geodesicd/report.hpp"

#include <gtest/gtest.h>
#include <sys/stat.h>

#include "tests/tools/geodesicd_fixture.hpp"
#include "tools/geodesic/status_table.hpp"
#include "tools/geodesicd/output_file.hpp"
#include "tools/geodesicd/trace.hpp"

namespace geodesic::tools {
namespace {

class ReportTest : public testing::Test {
 protected:
  ReportTest() {
    phases_.state_to_torque_ns.add(5'000);
    loop_.cycles = 1000;
    loop_.missed = 2;
    last_.tick_ns = 3'000'000'000;
    last_.state = control::SupervisorState::kActive;
    last_.authority = 0.5F;
    last_.joint[0].position = 0.25;
    last_.joint[0].age_us = 0;
    last_.joint[1].drive_error = 8;
    counters_.first_tick_ns = 1'000'000'000;
    counters_.joint[1].frames = {10, 9, 1};
    counters_.joint[1].max_torque = 3.5;
    counters_.bus[0].frames.sent = 20;
    Event event;
    event.tick_ns = 2'000'000'000;
    event.fault = {.time_ns = event.tick_ns,
                   .fault = control::Fault::kJointSilent,
                   .action = control::Action::kControlledStop,
                   .joint = 1,
                   .found = 5,
                   .limit = 5,
                   .suspicion = {}};
    faults_.add(event, describe(event, words_, counters_.first_tick_ns));
    event.kind = Event::Kind::kState;
    faults_.add(event, describe(event, words_, counters_.first_tick_ns));
  }

  RunView view() const {
    return {words_,          loop_, phases_, last_, counters_, faults_,
            "tried in vain", 7,     0,       false, "",        health_};
  }

  config::Robot robot_ = small_robot();
  Vocabulary words_{robot_};
  rt::LoopStatistics loop_;
  Phases phases_{true};
  Record last_;
  Counters counters_;
  FaultList faults_;
  BusKeeper::Health health_;
};

TEST_F(ReportTest, ABusTellsHowItsControllerFeels) {
  health_[0].device = "can3";
  health_[0].state = drivers::ControllerState::kPassive;
  health_[0].transmit_errors = 130;
  health_[0].bus_offs = 2;
  health_[0].reopened = 1;
  const nlohmann::ordered_json bus = status_json(view()).at("buses").at(0);
  EXPECT_EQ(bus.at("device"), "can3");
  EXPECT_EQ(bus.at("controller"), "error-passive");
  EXPECT_EQ(bus.at("transmit_errors"), 130);
  EXPECT_EQ(bus.at("bus_offs"), 2);
  const std::string table = status_table(status_json(view()));
  EXPECT_NE(table.find("(vcan0 = can3): ok"), std::string::npos) << table;
  EXPECT_NE(table.find("error-passive, error counters 130 sending, 0 receiving, 2 times bus-off, 1 "
                       "times opened again"),
            std::string::npos)
      << table;
}

TEST_F(ReportTest, SummaryHasAllThatIsPromised) {
  const nlohmann::ordered_json summary = summary_json(view(), false);
  EXPECT_EQ(summary.at("cycles"), 1000);
  EXPECT_EQ(summary.at("period_ns"), 1'000'000);
  EXPECT_EQ(summary.at("missed"), 2);
  for (const char* name : {"wake_latency_ns", "cycle_time_ns", "state_to_torque_ns", "exchange_ns",
                           "compute_ns", "transmit_ns", "publish_ns"}) {
    for (const char* figure : {"min", "p50", "p99", "p999", "max"}) {
      EXPECT_TRUE(summary.at(name).at(figure).is_number_integer()) << name << "." << figure;
    }
  }
  EXPECT_EQ(summary.at("state_to_torque_ns").at("max"), 5'000);
  EXPECT_EQ(summary.at("page_faults"), 0);
  EXPECT_EQ(summary.at("allocations"), 0);
  const auto& joint = summary.at("joints").at(1);
  EXPECT_EQ(joint.at("name"), "slide");
  EXPECT_EQ(joint.at("frames_sent"), 10);
  EXPECT_EQ(joint.at("frames_received"), 9);
  EXPECT_EQ(joint.at("losses"), 1);
  EXPECT_EQ(joint.at("max_torque"), 3.5);
  ASSERT_EQ(summary.at("faults").size(), 1U) << "a change of state is no fault";
  const auto& fault = summary.at("faults").at(0);
  EXPECT_DOUBLE_EQ(fault.at("time").get<double>(), 1.0);
  EXPECT_EQ(fault.at("joint"), "slide");
  EXPECT_EQ(fault.at("name"), "joint_silent");
  EXPECT_EQ(fault.at("class"), "controlled_stop");
  EXPECT_EQ(summary.at("final_state"), "active");
  EXPECT_EQ(summary.at("buses").at(0).at("sent"), 20);
  EXPECT_EQ(summary.at("robot"), "bench");
  EXPECT_FALSE(summary.at("realtime").get<bool>());
}

TEST_F(ReportTest, ARefusedStartHasTheSameKeys) {
  const nlohmann::ordered_json refused = refused_summary_json("bench", 1'000'000, "no bus");
  for (const char* key :
       {"cycles", "period_ns", "missed", "wake_latency_ns", "cycle_time_ns", "state_to_torque_ns",
        "page_faults", "allocations", "joints", "faults", "final_state"}) {
    EXPECT_TRUE(refused.contains(key)) << key;
  }
  EXPECT_EQ(refused.at("final_state"), "refused");
  EXPECT_EQ(refused.at("error"), "no bus");
}

TEST_F(ReportTest, StatusIsOneLineOfPlainFigures) {
  const nlohmann::ordered_json status = status_json(view());
  EXPECT_TRUE(status.at("ok").get<bool>());
  EXPECT_EQ(status.at("state"), "active");
  EXPECT_EQ(status.at("law"), "float");
  EXPECT_DOUBLE_EQ(status.at("authority").get<double>(), 0.5);
  EXPECT_DOUBLE_EQ(status.at("time_s").get<double>(), 2.0);
  EXPECT_EQ(status.at("realtime_reason"), "tried in vain");
  EXPECT_EQ(status.at("telemetry_dropped"), 7);
  const auto& joints = status.at("joints");
  ASSERT_EQ(joints.size(), 2U);
  EXPECT_EQ(joints.at(0).at("age_ms"), 0.0);
  EXPECT_TRUE(joints.at(1).at("age_ms").is_null()) << "never heard";
  EXPECT_TRUE(joints.at(1).contains("drive_error"));
  EXPECT_EQ(joints.at(1).at("lost"), 1);
  EXPECT_EQ(joints.at(1).at("unit"), "m");
  EXPECT_EQ(status.at("buses").at(0).at("state"), "ok");
  EXPECT_TRUE(status.at("latencies").at("exchange_ns").contains("p99"));
  EXPECT_EQ(status.dump().find('\n'), std::string::npos);
}

TEST_F(ReportTest, AFloodOfFaultsIsBounded) {
  Event event;
  event.fault = {.fault = control::Fault::kOverrun,
                 .action = control::Action::kControlledStop,
                 .found = 10,
                 .limit = 10,
                 .suspicion = {}};
  for (int i = 0; i < 10'000; ++i) {
    faults_.add(event, describe(event, words_, 0));
  }
  EXPECT_EQ(faults_.entries.size(), FaultList::kMost);
  EXPECT_EQ(faults_.count, 10'001U);
}

TEST(OutputFile, IsWrittenWholeAndLeavesNothingBeside) {
  const TemporaryFolder folder;
  std::ofstream(folder / "run.json") << "of an older run";
  EXPECT_FALSE(prepare_output(folder / "run.json"));
  EXPECT_FALSE(std::filesystem::exists(folder / "run.json")) << "the older run's would mislead";
  EXPECT_FALSE(write_output(folder / "run.json", "{}\n"));
  EXPECT_EQ(read_text(folder / "run.json"), "{}\n");
  const auto files = std::filesystem::directory_iterator(folder.path());
  EXPECT_EQ(std::distance(begin(files), end(files)), 1);
}

TEST(OutputFile, TellsWhatStandsInTheWay) {
  const TemporaryFolder folder;
  const auto absent = prepare_output(folder / "absent/run.json");
  ASSERT_TRUE(absent);
  EXPECT_NE(absent->find("make its folder first"), std::string::npos) << *absent;
  ASSERT_TRUE(prepare_output(folder.path()));
  EXPECT_TRUE(write_output(folder / "absent/run.json", "{}"));
  const auto full = write_output("/dev/full", "{}");
  ASSERT_TRUE(full);
  EXPECT_NE(full->find("free some space"), std::string::npos) << *full;
}

TEST(Trace, WritesAHeaderAndEveryNthCycle) {
  const TemporaryFolder folder;
  {
    Trace trace(folder / "run.csv", {"swing", "slide"}, 2, 10);
    Record record;
    for (std::int64_t i = 5; i < 30; ++i) {  // begins and ends anywhere
      record.index = i;
      record.tick_ns = 1'000'000'000 + i * 1'000'000;
      record.joint[1].position = 0.125;
      record.sent[1] = 2;
      EXPECT_FALSE(trace.write(record));
    }
  }
  std::istringstream text(read_text(folder / "run.csv"));
  std::vector<std::string> lines;
  for (std::string line; std::getline(text, line);) {
    lines.push_back(line);
  }
  ASSERT_EQ(lines.size(), 4U);
  EXPECT_EQ(lines[0],
            "time_s,state,law,authority,overran,q_swing,v_swing,torque_swing,command_swing,"
            "model_swing,external_swing,q_slide,v_slide,torque_slide,command_slide,model_slide,"
            "external_slide,sent_0,sent_1");
  EXPECT_EQ(lines[1], "0.000000,off,float,0.0000,0,0,0,0,0,0,0,0.125,0,0,0,0,0,0,2");
  EXPECT_EQ(lines[2].substr(0, 8), "0.005000");
  EXPECT_EQ(lines[3].substr(0, 8), "0.015000");
}

TEST(Trace, TellsThatItCannotBeWritten) {
  try {
    const Trace trace("/dev/full", {"swing"}, 1, 1);
    FAIL() << "the header cannot be written there";
  } catch (const std::runtime_error& error) {
    EXPECT_NE(std::string(error.what()).find("/dev/full"), std::string::npos);
  }
}

}  // namespace
}  // namespace geodesic::tools
