// Every golden vector of the folder that GEODESIC_VECTORS names (default: tests/data/vectors)
// against the codec of its family; and that a wrong vector, or a malformed file, would be noticed.
#include <gtest/gtest.h>

#include <algorithm>
#include <cstdlib>
#include <fstream>
#include <iostream>
#include <sstream>

#include "drivers/families.hpp"
#include "tests/drivers/vectors/checkers.hpp"

namespace geodesic::drivers::test {
namespace {

std::filesystem::path folder() {
  const char* named = std::getenv("GEODESIC_VECTORS");
  return named != nullptr ? named : GEODESIC_TEST_DATA "/vectors";
}

std::vector<Row> rows_of(const std::string& text) {
  std::istringstream stream(text);
  return read_rows(stream, "brought.csv");
}

constexpr const char* kHeading = "direction,description,can_id,is_extended,is_fd,data,values\n";

std::string error_of(const std::string& rows) {
  try {
    rows_of(kHeading + rows);
  } catch (const RowError& error) {
    return error.what();
  }
  return {};
}

TEST(Vectors, EveryRowOfEveryFileAgrees) {
  std::vector<std::filesystem::path> files;
  for (const auto& entry : std::filesystem::directory_iterator(folder())) {
    if (entry.path().extension() == ".csv") {
      files.push_back(entry.path());
    }
  }
  std::sort(files.begin(), files.end());
  ASSERT_FALSE(files.empty()) << "no CSV in " << folder();
  for (const std::filesystem::path& file : files) {
    const VectorChecker* checker = checker_for(file.stem().string());
    if (checker == nullptr) {
      ADD_FAILURE() << file << ": its name holds no drive family's, so nobody checks its rows";
      continue;
    }
    std::ifstream stream(file);
    ASSERT_TRUE(stream) << "cannot read " << file;
    std::vector<Row> rows;
    try {
      rows = read_rows(stream, file);
    } catch (const RowError& error) {
      ADD_FAILURE() << error.what();
      continue;
    }
    for (const Row& row : rows) {
      try {
        for (const std::string& problem : checker->check(row)) {
          ADD_FAILURE_AT(file.c_str(), row.line) << row.description << ": " << problem;
        }
      } catch (const std::invalid_argument& error) {
        ADD_FAILURE_AT(file.c_str(), row.line) << row.description << ": " << error.what();
      }
    }
    std::cout << file.filename().string() << ": " << rows.size() << " rows held against "
              << checker->family << "\n";
  }
}

TEST(Vectors, EveryFamilyHasAChecker) {
  for (const Family& family : families()) {
    EXPECT_NE(checker_for(family.name), nullptr) << family.name;
  }
}

TEST(Vectors, FilesOfAnyNameWithTheFamilyInItAreFound) {
  EXPECT_NE(checker_for("damiao"), nullptr);
  EXPECT_NE(checker_for("my-damiao-2"), nullptr);
  EXPECT_EQ(checker_for("odd"), nullptr);
}

TEST(Vectors, QuotedFieldsAndWindowsLineEndsAreRead) {
  const std::vector<Row> rows = rows_of(
      "direction,description,can_id,is_extended,is_fd,data,values\r\n"
      "command,\"a, \"\"b\"\"\",7FF,0,0,0AFF,x=1.5;y=nan\r\n");
  ASSERT_EQ(rows.size(), 1U);
  EXPECT_EQ(rows[0].description, "a, \"b\"");
  EXPECT_EQ(rows[0].frame.id, 0x7FFU);
  EXPECT_EQ(rows[0].frame.length, 2);
  EXPECT_EQ(rows[0].frame.data[1], 0xFF);
  EXPECT_EQ(rows[0].number("x"), 1.5);
  EXPECT_NE(rows[0].number("y"), rows[0].number("y"));
}

TEST(Vectors, AMalformedRowIsNamedByFileAndLine) {
  const std::string good = "command,enable,001,0,0,FFFFFFFFFFFFFFFC,op=enable\n";
  EXPECT_EQ(error_of(good), "");
  for (const char* bad :
       {"command,enable,001,0,0,FFFFFFFFFFFFFFFC", "commando,enable,001,0,0,FF,op=enable",
        "command,enable,0x1,0,0,FF,op=enable", "command,enable,800,0,0,FF,op=enable",
        "command,enable,001,2,0,FF,op=enable", "command,enable,001,0,0,FFF,op=enable",
        "command,enable,001,0,0,FG,op=enable", "command,enable,001,0,0,FF,op",
        "command,\"enable,001,0,0,FF,op=enable", "command,enable,001,0,0,FFFFFFFFFFFFFFFFFF,a=b"}) {
    EXPECT_EQ(error_of(good + bad).rfind("brought.csv:3: ", 0), 0U) << bad << "\n"
                                                                    << error_of(good + bad);
  }
  EXPECT_THROW(rows_of("direction,data\n"), RowError);
  EXPECT_THROW(rows_of(kHeading), RowError);
}

TEST(Vectors, AWrongVectorIsNoticed) {
  const std::string ranges = ";pmax=12.5;vmax=45;tmax=54\n";
  const std::string mit = "mode=mit;p_des=-1.1905;v_des=5.3795;kp=232.825;kd=2.5392;t_ff=45.8147";
  const std::string state = "motor_id=1;status=1;position=-9.86934463;velocity=22.7802198;";
  const std::string temperatures = "torque=25.9120879;t_mos=24;t_rotor=56";
  const auto problems = [](const std::string& row) {
    return checker_for("damiao")->check(rows_of(kHeading + row).front()).size();
  };
  EXPECT_EQ(problems("command,right,001,0,0,73CE8F477281FEC8," + mit + ranges), 0U);
  const auto with = [](const char* start, const std::string& bytes, const std::string& values) {
    std::string row = start;
    row.append(bytes).append(",").append(values);
    return row;
  };
  for (const char* bytes : {"73CC8F477281FEC8", "73CE91477281FEC8", "73CE8F4A7281FEC8",
                            "73CE8F477281FECB", "73CE8F477481FEC8", "73CE8F477281FE"}) {
    EXPECT_NE(problems(with("command,wrong,001,0,0,", bytes, mit + ranges)), 0U) << bytes;
  }
  const std::string reported = state + temperatures + ranges;
  EXPECT_EQ(problems(with("feedback,right,011,0,0,", "111AF0C0CBD61838", reported)), 0U);
  for (const char* bytes : {"111AF1C0CBD61838", "111AF0C1CBD61838", "111AF0C0CBD71838",
                            "211AF0C0CBD61838", "121AF0C0CBD61838", "111AF0C0CBD61938"}) {
    EXPECT_NE(problems(with("feedback,wrong,011,0,0,", bytes, reported)), 0U) << bytes;
  }
  EXPECT_NE(problems("command,wrong,001,0,0,FFFFFFFFFFFFFFFD,op=enable;motor_id=1\n"), 0U);
  EXPECT_NE(problems("command,wrong,002,0,0,FFFFFFFFFFFFFFFC,op=enable;motor_id=1\n"), 0U);
  EXPECT_NE(problems("command,wrong,7FF,0,0,0100331600000000,op=read_reg;motor_id=1;rid=21\n"), 0U);
  EXPECT_NE(problems("command,wrong,201,0,0,0D0207C1,op=vel;motor_id=1;v_des=-8.43799973\n"), 0U);
  EXPECT_NE(problems("command,what,201,0,0,0D0207C1,op=dance;motor_id=1\n"), 0U);
  EXPECT_THROW(problems("command,lacks,001,0,0,0000000000000000,mode=mit;p_des=1\n"),
               std::invalid_argument);
}

}  // namespace
}  // namespace geodesic::drivers::test
