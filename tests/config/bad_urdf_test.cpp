// Every way a URDF can be broken or odd: refused or warned of, at its line and column.
#include "config/urdf.hpp"
#include "tests/config/bench.hpp"

namespace geodesic::config {
namespace {

struct Bad {
  const char* what;
  const char* from;
  const char* to;
  int line;
  int column;
  const char* fragment;
};

const Bad kBad[] = {
    {"cut short", "</robot>", "", 2, 1, "not well-formed XML"},
    {"mismatched", "</link>", "</lynk>", 4, 3, "not well-formed XML"},
    {"not a robot", "<robot name=\"two\">", "<sdf name=\"two\"/><robot name=\"two\">", 2, 1,
     "found <sdf>, expected a URDF"},
    {"no name", "<robot name=\"two\">", "<robot>", 2, 1, "<robot> has no name"},
    {"xacro", "<link name=\"base\"/>", "<xacro:include filename=\"x\"/>", 3, 3, "a xacro source"},
    {"link without name", "<link name=\"tip\"/>", "<link/>", 18, 3, "<link> has no name"},
    {"link twice", "<link name=\"tip\"/>", "<link name=\"base\"/>", 18, 14,
     "a second link \"base\"; the first is in line 3"},
    {"joint twice", "name=\"elbow\"", "name=\"shoulder\"", 26, 15, "a second joint \"shoulder\""},
    {"type", "<joint name=\"elbow\" type=\"revolute\">", "<joint name=\"elbow\" type=\"hinge\">",
     26, 28,
     "found type \"hinge\", expected revolute, continuous, prismatic, planar, floating or fixed"},
    {"no type", "<joint name=\"elbow\" type=\"revolute\">", "<joint name=\"elbow\">", 26, 3,
     "found type \"\""},
    {"spherical", "<joint name=\"elbow\" type=\"revolute\">",
     "<joint name=\"elbow\" type=\"spherical\">", 26, 28, "found type \"spherical\", expected"},
    {"no parent", "    <parent link=\"lower\"/>\n", "", 33, 3,
     "joint \"tip_joint\" has no <parent"},
    {"no child", "    <child link=\"tip\"/>\n", "", 33, 3, "joint \"tip_joint\" has no <child"},
    {"unknown parent", "<parent link=\"lower\"/>", "<parent link=\"lowr\"/>", 34, 18,
     "there is no link \"lowr\"; did you mean \"lower\"?"},
    {"unknown child", "<child link=\"tip\"/>", "<child link=\"top\"/>", 35, 17,
     "there is no link \"top\"; did you mean \"tip\"?"},
    {"two parents", "<child link=\"tip\"/>", "<child link=\"lower\"/>", 35, 17,
     "is the child of joint"},
    {"itself", "<child link=\"tip\"/>", "<child link=\"lower\"/>", 33, 3,
     "joins link \"lower\" to itself"},
    {"two roots", "<link name=\"tip\"/>", "<link name=\"tip\"/>\n  <link name=\"stray\"/>", 19, 3,
     "2 links are nobody's child: base, stray"},
    {"loop", "<parent link=\"base\"/>", "<parent link=\"tip\"/>", 26, 3, "a loop of joints"},
    {"zero axis", "<axis xyz=\"0 0 1\"/>", "<axis xyz=\"0 0 0\"/>", 23, 15, "has the axis 0 0 0"},
    {"axis without figures", "<axis xyz=\"0 0 1\"/>", "<axis xzy=\"0 0 1\"/>", 23, 5,
     "<axis> of joint \"shoulder\" has no xyz"},
    {"long axis", "<axis xyz=\"0 0 1\"/>", "<axis xyz=\"0 0 1e200\"/>", 23, 15,
     "has an axis of length 1e+200"},
    {"short axis", "<axis xyz=\"0 0 1\"/>", "<axis xyz=\"0 1\"/>", 23, 15,
     "(2 numbers), expected three"},
    {"nan", "<origin xyz=\"0.5 0 0\"", "<origin xyz=\"nan 0 0\"", 29, 17,
     "found \"nan\", expected a finite number"},
    {"huge", "<origin xyz=\"0.5 0 0\"", "<origin xyz=\"1e999 0 0\"", 29, 17, "found \"1e999\""},
    {"comma", "<origin xyz=\"0.5 0 0\"", "<origin xyz=\"0,5 0 0\"", 29, 17,
     "decimal mark is a point"},
    {"hexadecimal", "<mass value=\"0.9\"/>", "<mass value=\"0x1p3\"/>", 14, 19, "found \"0x1p3\""},
    {"unit", "<mass value=\"0.9\"/>", "<mass value=\"0.9kg\"/>", 14, 19, "found \"0.9kg\""},
    {"no mass", "      <mass value=\"0.9\"/>\n", "", 12, 5, "of link \"lower\" has no <mass"},
    {"negative mass", "<mass value=\"0.9\"/>", "<mass value=\"-0.9\"/>", 14, 19, "mass -0.9 kg"},
    {"no inertia",
     "      <inertia ixx=\"0.001\" ixy=\"0\" ixz=\"0\" iyy=\"0.012\" iyz=\"0\" izz=\"0.012\"/>\n",
     "", 12, 5, "of link \"lower\" has no <inertia"},
    {"inertia entry", "ixz=\"0\" iyy=\"0.012\"", "iyy=\"0.012\"", 15, 7, "<inertia> has no ixz"},
    {"two inertials", "  <link name=\"tip\"/>",
     "  <link name=\"tip\"><inertial><mass value=\"1\"/><inertia ixx=\"1\" ixy=\"0\" ixz=\"0\" "
     "iyy=\"1\" "
     "iyz=\"0\" izz=\"1\"/></inertial>\n<inertial/></link>",
     19, 1, "a second <inertial> in link \"tip\""},
    {"no limit", "    <limit lower=\"-2.5\" upper=\"2.5\" effort=\"20\" velocity=\"10\"/>\n", "",
     26, 3, "joint \"elbow\" has no <limit"},
    {"no effort", " effort=\"20\"", "", 31, 5, "<limit> has no effort"},
    {"no velocity", "effort=\"20\" velocity=\"10\"", "effort=\"20\"", 31, 5,
     "<limit> has no velocity"},
    {"negative effort", "effort=\"20\"", "effort=\"-20\"", 31, 44,
     "effort is -20, expected 0 or more"},
    {"crossed", "lower=\"-2.5\"", "lower=\"2.6\"", 31, 18, "lower 2.6 is above upper 2.5"},
    {"mimic unknown", "effort=\"20\" velocity=\"10\"/>",
     "effort=\"20\" velocity=\"10\"/>\n<mimic joint=\"sholder\"/>", 32, 14,
     "mimics \"sholder\", which does not exist; did you mean \"shoulder\"?"},
    {"mimic itself", "effort=\"20\" velocity=\"10\"/>",
     "effort=\"20\" velocity=\"10\"/>\n<mimic joint=\"elbow\"/>", 32, 14,
     "mimics \"elbow\", expected another"},
    {"mimic fixed", "effort=\"20\" velocity=\"10\"/>",
     "effort=\"20\" velocity=\"10\"/>\n<mimic joint=\"tip_joint\"/>", 32, 14,
     "expected another joint"},
    {"mimic planar", "<joint name=\"elbow\" type=\"revolute\">",
     "<joint name=\"elbow\" type=\"planar\"><mimic joint=\"shoulder\"/>", 26, 37,
     "joint \"elbow\" is planar and mimics another; only a revolute"},
    {"planar axis", "<joint name=\"elbow\" type=\"revolute\">",
     "<joint name=\"elbow\" type=\"planar\"><axis xyz=\"0 0 0\"/>", 30, 5, "a second <axis>"},
    {"mimic multiplier", "effort=\"20\" velocity=\"10\"/>",
     "effort=\"20\" velocity=\"10\"/>\n<mimic joint=\"shoulder\" multiplier=\"two\"/>", 32, 36,
     "\"two\""},
};

class BadUrdf : public Bench, public ::testing::WithParamInterface<Bad> {};

TEST_P(BadUrdf, IsRefusedWhereItStands) {
  const Bad& bad = GetParam();
  const auto file = write("two.urdf", replaced(kTwoUrdf, bad.from, bad.to));
  testing::internal::CaptureStderr();
  testing::internal::CaptureStdout();
  const UrdfResult result = load_urdf(file, false);
  EXPECT_EQ(testing::internal::GetCapturedStdout(), "");
  EXPECT_EQ(testing::internal::GetCapturedStderr(), "");
  EXPECT_FALSE(result.ok);
  EXPECT_TRUE(says(result.messages, "two.urdf", bad.line, bad.column, bad.fragment,
                   Message::Severity::kError))
      << "expected " << bad.line << ":" << bad.column << ": " << bad.fragment << "\nfound\n"
      << all_of(result.messages);
}

/// Odd, but usable: a warning, and with strict an error.
const Bad kOdd[] = {
    {"triangle", "iyy=\"0.012\"", "iyy=\"0.5\"", 15, 7,
     "link \"lower\": no body can have this inertia: the principal moments break the triangle "
     "inequality A + B >= C (principal moments 0.001, 0.012, 0.5 kg·m²"},
    {"negative moment", "ixx=\"0.001\" ixy=\"0\" ixz=\"0\" iyy=\"0.012\"",
     "ixx=\"-0.001\" ixy=\"0\" ixz=\"0\" iyy=\"0.012\"", 15, 7, "The nearest physical one: ixx="},
    {"inertia without mass", "<mass value=\"0.9\"/>", "<mass value=\"0\"/>", 15, 7,
     "has inertia but no mass"},
    {"grams", "<mass value=\"0.9\"/>", "<mass value=\"900\"/>", 14, 7, "mass of 900 kg"},
    {"too light", "<mass value=\"0.9\"/>", "<mass value=\"0.0009\"/>", 14, 7, "mass of 0.0009 kg"},
    {"millimetres", "<origin xyz=\"0.2 0 0\"", "<origin xyz=\"200 0 0\"", 13, 7,
     "centre of mass of link \"lower\" is 200 m from its joint"},
    {"massless tip", "<joint name=\"tip_joint\" type=\"fixed\">",
     "<joint name=\"tip_joint\" type=\"continuous\">", 33, 3,
     "nothing that joint \"tip_joint\" moves"},
    {"effort 0", "effort=\"20\"", "effort=\"0\"", 31, 44, "has effort 0"},
    {"velocity 0", "effort=\"20\" velocity=\"10\"", "effort=\"20\" velocity=\"0\"", 31, 58,
     "velocity 0"},
    {"cannot move", "lower=\"-2.5\" upper=\"2.5\"", "lower=\"0\" upper=\"0\"", 31, 5,
     "cannot move"},
};

class OddUrdf : public Bench, public ::testing::WithParamInterface<Bad> {};

TEST_P(OddUrdf, IsWarnedOfAndRefusedIfStrict) {
  const Bad& odd = GetParam();
  const auto file = write("two.urdf", replaced(kTwoUrdf, odd.from, odd.to));
  for (const bool strict : {false, true}) {
    const UrdfResult result = load_urdf(file, strict);
    EXPECT_EQ(result.ok, !strict) << all_of(result.messages);
    EXPECT_TRUE(says(result.messages, "two.urdf", odd.line, odd.column, odd.fragment,
                     strict ? Message::Severity::kError : Message::Severity::kWarning))
        << "expected " << odd.line << ":" << odd.column << ": " << odd.fragment << "\nfound\n"
        << all_of(result.messages);
  }
}

std::string name_of(const testing::TestParamInfo<Bad>& bad) {
  return test_name(bad.param.what);
}
INSTANTIATE_TEST_SUITE_P(Table, BadUrdf, ::testing::ValuesIn(kBad), name_of);
INSTANTIATE_TEST_SUITE_P(Table, OddUrdf, ::testing::ValuesIn(kOdd), name_of);

using UrdfFiles = Bench;

TEST_F(UrdfFiles, MissingFolderAndNoise) {
  EXPECT_NE(all_of(load_urdf(folder() / "none.urdf", false).messages).find("there is no file"),
            std::string::npos);
  EXPECT_NE(all_of(load_urdf(folder(), false).messages).find("is a folder"), std::string::npos);
  for (const char* text :
       {"", "hello", "<", "<?xml version=\"1.0\"?>", "\xff\xfe\x01\x02", "<robot/>"}) {
    const UrdfResult result = load_urdf(write("noise.urdf", text), false);
    EXPECT_FALSE(result.ok) << text;
    EXPECT_FALSE(result.messages.empty()) << text;
  }
}

TEST_F(UrdfFiles, ShapesAndExtensionsDoNotMatter) {
  const auto file = write("two.urdf", replaced(kTwoUrdf, "<link name=\"tip\"/>",
                                               "<link name=\"tip\"><visual><geometry><mesh/>"
                                               "</geometry></visual><collision/></link>"
                                               "<gazebo><x y=\"z\"/></gazebo><transmission/>"));
  const UrdfResult result = load_urdf(file, true);
  EXPECT_TRUE(result.ok) << all_of(result.messages);
}

}  // namespace
}  // namespace geodesic::config
