// Values change where they stand and nothing else does, whatever the layout; files are replaced
// whole or not at all.
#include "config/edit.hpp"

#include <sys/stat.h>

#include <random>

#include "config/settings.hpp"
#include "config/write_back.hpp"
#include "tests/config/bench.hpp"

namespace geodesic::config {
namespace {

std::string edited(const std::string& text, const std::vector<std::string>& steps,
                   const std::string& value) {
  const EditResult result = edit_toml(text, steps, value);
  return result.text.value_or("PROBLEM: " + result.problem);
}

constexpr const char* kText =
    "# héllo — π\n[a]\nx = 1  # one\ny = [1,\n     2] # two\n\n"
    "[[j]]\n  name = \"p\"\n  d = { k = 1 } # drive\n  [j.sub]\n  z = 3\n"
    "[[j]]\nname = \"q.r\"\ns = \"é\"  # s\n";

TEST(Edit, ReplacesWhereItStands) {
  EXPECT_EQ(edited(kText, {"a", "x"}, "2.5"), replaced(kText, "x = 1  # one", "x = 2.5  # one"));
  EXPECT_EQ(edited(kText, {"a", "y"}, "[3]"), replaced(kText, "[1,\n     2] # two", "[3] # two"));
  EXPECT_EQ(edited(kText, {"j", "q.r", "s"}, "\"ü\""), replaced(kText, "\"é\"  # s", "\"ü\"  # s"));
  EXPECT_EQ(edited(kText, {"j", "p", "d", "k"}, "7"), replaced(kText, "k = 1 }", "k = 7 }"));
  EXPECT_EQ(edited(kText, {"j", "p", "sub", "z"}, "4"), replaced(kText, "z = 3", "z = 4"));
}

TEST(Edit, InsertsBelowTheLastOfItsTable) {
  EXPECT_EQ(edited(kText, {"a", "w"}, "0"), replaced(kText, "2] # two\n", "2] # two\nw = 0\n"));
  EXPECT_EQ(edited(kText, {"j", "p", "w"}, "0"),
            replaced(kText, "# drive\n", "# drive\n  w = 0\n"));
  EXPECT_EQ(edited(kText, {"j", "q.r", "w"}, "0"), std::string(kText) + "w = 0\n");
  EXPECT_EQ(edited(kText, {"j", "p", "d", "m"}, "2"), replaced(kText, "k = 1 }", "k = 1, m = 2 }"));
  EXPECT_EQ(edited(kText, {"j", "p", "sub", "y"}, "5"),
            replaced(kText, "z = 3\n", "z = 3\n  y = 5\n"));
  EXPECT_EQ(edited(kText, {"j", "q.r", "sim", "f"}, "5"), std::string(kText) + "sim.f = 5\n");
}

TEST(Edit, AppendsATableThatIsNotThere) {
  EXPECT_EQ(edited("[a]\nx = 1", {"b", "y"}, "2"), "[a]\nx = 1\n\n[b]\ny = 2\n");
  EXPECT_EQ(edited(kText, {"b", "c", "y"}, "2"), std::string(kText) + "\n[b.c]\ny = 2\n");
}

TEST(Edit, KeepsLineBreaksAndMarks) {
  EXPECT_EQ(edited("[a]\r\nx = 1\r\n", {"a", "y"}, "2"), "[a]\r\nx = 1\r\ny = 2\r\n");
  EXPECT_EQ(edited("\xEF\xBB\xBF[a]\nx = 1\n", {"a", "x"}, "2"), "\xEF\xBB\xBF[a]\nx = 2\n");
  EXPECT_EQ(edited("[a]\n[c]\nx = 1\n", {"a", "y"}, "2"), "[a]\ny = 2\n[c]\nx = 1\n");
  EXPECT_EQ(edited("a = {}\n[c]\n", {"a", "y"}, "2"), "a = { y = 2 }\n[c]\n");
}

TEST(Edit, RefusesWhatItCannotPlace) {
  EXPECT_FALSE(edit_toml("[a\n", {"a", "x"}, "1").text);
  EXPECT_FALSE(edit_toml("[[j]]\nname = \"p\"\n", {"j", "q", "x"}, "1").text);
  EXPECT_FALSE(edit_toml("a = 1\n", {"a", "x"}, "1").text);
  EXPECT_FALSE(edit_toml("", {"x"}, "1").text);
}

class WriteBack : public Bench {
 public:
  std::string contents() const {
    std::ifstream stream(folder() / "robot.toml", std::ios::binary);
    return {std::istreambuf_iterator<char>(stream), {}};
  }
  WriteResult put(const std::vector<Override>& values) const {
    return write_back(folder() / "robot.toml", values);
  }
};

TEST_F(WriteBack, ChangesTheseBytesAndKeepsTheMode) {
  ASSERT_EQ(chmod((folder() / "robot.toml").c_str(), 0640), 0);
  const WriteResult result = put({{"joint.elbow.damping", "0.25"},
                                  {"robot.gravity", "[0, 0, -9.81]"},
                                  {"safety.lower_s", "2"}});
  ASSERT_TRUE(result.ok) << (result.problems.empty() ? "" : result.problems.front());
  EXPECT_EQ(result.changes.size(), 3U);
  std::string expected = replaced(kRobotToml, "gravity = [0, -9.81, 0]", "gravity = [0, 0, -9.81]");
  expected = replaced(expected, "\n\n[simulation.pose]", "\ndamping = 0.25\n\n[simulation.pose]");
  EXPECT_EQ(contents(), expected + "\n[safety]\nlower_s = 2\n");
  struct stat status {};
  ASSERT_EQ(stat((folder() / "robot.toml").c_str(), &status), 0);
  EXPECT_EQ(status.st_mode & 07777U, 0640U);
  std::size_t files = 0;
  for ([[maybe_unused]] const auto& entry : std::filesystem::directory_iterator(folder())) ++files;
  EXPECT_EQ(files, 2U) << "nothing else may be left behind";
}

TEST_F(WriteBack, ASymbolicLinkStaysOne) {
  std::filesystem::rename(folder() / "robot.toml", folder() / "real.toml");
  std::filesystem::create_symlink("real.toml", folder() / "robot.toml");
  ASSERT_TRUE(put({{"safety.lower_s", "2"}}).ok);
  EXPECT_TRUE(std::filesystem::is_symlink(folder() / "robot.toml"));
  EXPECT_TRUE(contents().ends_with("lower_s = 2\n"));
}

TEST_F(WriteBack, NothingIsWrittenThatIsWrong) {
  const std::string before = contents();
  EXPECT_FALSE(put({{"safety.lower_s", "-2"}}).ok);
  EXPECT_FALSE(put({{"safety.lower", "2"}}).ok);
  EXPECT_FALSE(put({{"safety.lower_s", "2"}, {"joint.elbow.position_upper", "-9"}}).ok);
  EXPECT_EQ(contents(), before);
  write("robot.toml", before + "nonsense = \n");
  const WriteResult broken = put({{"safety.lower_s", "2"}});
  EXPECT_FALSE(broken.ok);
  ASSERT_FALSE(broken.problems.empty());
  EXPECT_NE(broken.problems.front().find("robot.toml:24:"), std::string::npos)
      << broken.problems.front();
}

// Every live option of the example robots, one after the other, into one file: after each, the file
// says exactly what was asked.
TEST_F(WriteBack, EveryLiveOptionOfTheExamples) {
  const std::filesystem::path robots = std::filesystem::path(GEODESIC_SOURCE_DIR) / "config/robots";
  int written = 0;
  for (const auto& robot : std::filesystem::directory_iterator(robots)) {
    if (!std::filesystem::exists(robot.path() / "robot.toml")) continue;
    const std::filesystem::path copy = folder() / robot.path().filename();
    std::filesystem::copy(robot.path(), copy, std::filesystem::copy_options::recursive);
    const LoadResult before = load_robot(copy / "robot.toml");
    ASSERT_TRUE(before.ok) << robot.path();
    std::mt19937 random(7);  // NOLINT(bugprone-random-generator-seed): repeatable on purpose
    for (const Setting& setting : before.robot.settings) {
      const bool number = !setting.value.empty() &&
                          setting.value.find_first_not_of("0123456789.e-") == std::string::npos;
      if (setting.live != Live::kYes || setting.element || !number || random() % 12 != 0) continue;
      const double value = std::stod(setting.value);
      const bool whole = value == std::floor(value);
      const std::string asked = std::to_string(whole ? value + 1.0 : value * 0.9);
      const WriteResult result =
          write_back(copy / "robot.toml", std::vector<Override>{{setting.path, asked}});
      if (!result.ok) {
        // Some values clash with others (warn above limit); then the reason is the value's.
        ASSERT_NE(result.problems.front().find(setting.path), std::string::npos)
            << result.problems.front();
        continue;
      }
      ++written;
      ASSERT_EQ(result.changes.size(), 1U) << setting.path;
    }
  }
  EXPECT_GT(written, 30);
}

}  // namespace
}  // namespace geodesic::config
