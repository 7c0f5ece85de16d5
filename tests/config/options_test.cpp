// The reference is complete and current; did-you-mean finds what people mean; no file, however
// spoilt, breaks the reader.
#include "config/options/options.hpp"

#include <random>

#include "config/findings.hpp"
#include "config/options/reference.hpp"
#include "config/robot_file.hpp"
#include "config/urdf.hpp"
#include "tests/config/bench.hpp"

namespace geodesic::config {
namespace {

std::string contents(const std::filesystem::path& file) {
  std::ifstream stream(file, std::ios::binary);
  return {std::istreambuf_iterator<char>(stream), {}};
}

/// Counts options, and those that say too little.
class Auditor final : public OptionVisitor {
 public:
  void number(const Spec& spec, Given<double>& value) override {
    value_of(spec);
    // A default outside its own range would be a slip. Where text explains it, it is no constant.
    if (!spec.required && spec.default_text.empty()) {
      EXPECT_TRUE(spec.range.holds(value.value)) << spec.key << " = " << value.value;
    }
  }
  void integer(const Spec& spec, Given<std::int64_t>& value) override {
    value_of(spec);
    if (!spec.required) {
      EXPECT_TRUE(spec.range.holds(static_cast<double>(value.value))) << spec.key;
    }
  }
  void flag(const Spec& spec, Given<bool>& /*value*/) override { value_of(spec); }
  void text(const Spec& spec, Given<std::string>& /*value*/) override { value_of(spec); }
  void integers(const Spec& spec, Given<std::vector<std::int64_t>>& /*value*/) override {
    value_of(spec);
  }
  void vector(const Spec& spec, Given<std::array<double, 3>>& /*value*/) override {
    value_of(spec);
  }
  void by_name(const Spec& spec, std::vector<NamedNumber>& /*values*/) override { value_of(spec); }
  void table(const Spec& spec, const Describe& describe) override {
    audit(spec);
    describe(*this);
  }
  void partial_table(const Spec& spec, const Describe& describe) override { table(spec, describe); }
  void tables(const Spec& spec, std::size_t present, const DescribeOne& describe) override {
    EXPECT_NE(spec.live, Live::kUnsaid) << spec.key << ": may one be added to a running daemon?";
    table(spec, [&](OptionVisitor& inner) { describe(inner, present); });
  }
  Place here() const override { return {}; }

  int options = 0;

 private:
  void value_of(const Spec& spec) {
    audit(spec);
    EXPECT_NE(spec.live, Live::kUnsaid)
        << spec.key << " does not say whether a running daemon takes it: .live = kLive, kRestart "
        << "or kElsewhere";
  }
  void audit(const Spec& spec) {
    ++options;
    EXPECT_FALSE(spec.key.empty());
    EXPECT_GT(spec.doc.size(), 8U) << spec.key;
    EXPECT_EQ(spec.doc.find('|'), std::string_view::npos) << spec.key;  // a Markdown table
    const std::string row = "`" + std::string(spec.key) + "`";
    EXPECT_TRUE(reference_.find(row) != std::string::npos ||
                reference_.find(std::string(spec.key) + "]") != std::string::npos)
        << spec.key << " is not in the reference";
  }
  std::string reference_ = option_reference_markdown();
};

TEST(Options, EveryOneIsDocumented) {
  Auditor auditor;
  RobotFile defaults;
  describe(auditor, defaults);
  EXPECT_GT(auditor.options, 80);
}

TEST(Options, ReferenceFileIsCurrent) {
  const std::string file =
      contents(std::filesystem::path(GEODESIC_SOURCE_DIR) / "config/OPTIONS.md");
  EXPECT_TRUE(file == option_reference_markdown())
      << "config/OPTIONS.md is out of date; it must be exactly option_reference_markdown()";
}

TEST(DidYouMean, Distances) {
  EXPECT_EQ(edit_distance("", ""), 0U);
  EXPECT_EQ(edit_distance("abc", ""), 3U);
  EXPECT_EQ(edit_distance("kitten", "sitting"), 3U);
  EXPECT_EQ(edit_distance("flaot", "float"), 1U);  // swapped neighbours
  EXPECT_EQ(edit_distance("rate", "rate"), 0U);
}

TEST(DidYouMean, NamesNearEnoughOnly) {
  const std::vector<std::string> known = {"torque_limit", "velocity_limit", "name", "bus"};
  EXPECT_EQ(nearest_name("torqe_limit", known), "torque_limit");
  EXPECT_EQ(nearest_name("torque", known), "torque_limit");
  EXPECT_EQ(nearest_name("nmae", known), "name");
  EXPECT_EQ(nearest_name("xyz", known), "");
  EXPECT_EQ(nearest_name("", known), "");
  EXPECT_EQ(nearest_name(std::string(10'000, 'x'), known), "");
  EXPECT_EQ(did_you_mean("bux", known), "; did you mean \"bus\"?");
}

TEST(Messages, QuotedTextIsHarmless) {
  EXPECT_EQ(quote("a\nb\x1b[31m"), "\"a?b?[31m\"");
  EXPECT_EQ(quote(std::string(100, 'x')).size(), 65U);
  std::string two_bytes_too_long(59, 'x');
  two_bytes_too_long += "\u00e9\u00e9";
  const std::string cut = quote(two_bytes_too_long);
  EXPECT_EQ(cut.substr(cut.size() - 5), "x...\"");
}

TEST(Messages, WhatIsNoTextIsNeverShown) {
  EXPECT_EQ(printable("N·m \u20ac \U0001f642"), "N·m \u20ac \U0001f642");
  EXPECT_EQ(printable("\xff|\xc2|\xe2\x82|\x80|\xc1\x81|\xf5\x80\x80\x80"), "?|?|??|?|??|????");
  EXPECT_EQ(printable("\xc2\x9b[31m\t\n"), "??[31m??") << "CSI as one letter";
  Findings findings;
  findings.error({"a.urdf", 1, 1}, "found <\xff>");
  EXPECT_EQ(findings.take().front().text, "found <?>");
}

TEST(Messages, FormIsFileLineColumn) {
  EXPECT_EQ(to_string({Message::Severity::kError, {"a.toml", 3, 7}, "no"}),
            "a.toml:3:7: error: no");
  EXPECT_EQ(to_string({Message::Severity::kWarning, {"a.toml", 0, 0}, "hm"}),
            "a.toml: warning: hm");
}

/// Swaps, removes, repeats and inserts bytes; the same every time for a seed.
std::string spoilt(std::string text, unsigned seed) {
  std::mt19937 random(seed);
  const auto below = [&random](std::size_t n) { return n == 0 ? 0 : random() % n; };
  constexpr std::string_view kLikely = "[]{}=\"'<>/.,-0123456789eE#\n\t nax_\xff\x00&;";
  for (std::size_t i = 0, n = 1 + below(6); i < n && !text.empty(); ++i) {
    const std::size_t at = below(text.size());
    switch (below(4)) {
      case 0:
        text[at] = kLikely[below(kLikely.size())];
        break;
      case 1:
        text.erase(at, 1 + below(20));
        break;
      case 2:
        text.insert(at, text.substr(below(text.size()), below(60)));
        break;
      default:
        text.insert(at, 1, static_cast<char>(random() & 0xFFU));
        break;
    }
  }
  return text;
}

using Mutations = Bench;

TEST_F(Mutations, OfARobotFileAreReadOrRefused) {
  for (unsigned seed = 0; seed < 1500; ++seed) {
    write("robot.toml", spoilt(std::string(kRobotToml), seed));
    const LoadResult result = load();
    EXPECT_TRUE(result.ok || !result.messages.empty()) << "seed " << seed;
  }
}

TEST_F(Mutations, OfAUrdfAreReadOrRefused) {
  for (unsigned seed = 0; seed < 1500; ++seed) {
    write("two.urdf", spoilt(std::string(kTwoUrdf), seed));
    const LoadResult result = load();
    EXPECT_TRUE(result.ok || !result.messages.empty()) << "seed " << seed;
  }
}

}  // namespace
}  // namespace geodesic::config
