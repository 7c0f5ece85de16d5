// Every seed and every input that once found something, through its target, in an ordinary build.
#include <gtest/gtest.h>

#include <algorithm>
#include <fstream>
#include <iterator>
#include <vector>

#include "tests/fuzz/fuzz.hpp"

namespace geodesic::fuzz {
namespace {

std::vector<std::filesystem::path> files_of(const std::filesystem::path& folder) {
  std::vector<std::filesystem::path> files;
  std::error_code none;
  for (const auto& entry : std::filesystem::directory_iterator(folder, none)) {
    files.push_back(entry.path());
  }
  std::sort(files.begin(), files.end());
  return files;
}

std::vector<std::uint8_t> contents(const std::filesystem::path& file) {
  std::ifstream stream(file, std::ios::binary);
  EXPECT_TRUE(stream) << file;
  return {std::istreambuf_iterator<char>(stream), std::istreambuf_iterator<char>()};
}

class Replay : public testing::TestWithParam<Target> {};

TEST_P(Replay, EverySeedAndEveryKeptInput) {
  const Target& target = GetParam();
  std::vector<std::filesystem::path> files =
      files_of(std::filesystem::path(GEODESIC_FUZZ_SEEDS) / "seeds" / target.name);
  EXPECT_FALSE(files.empty()) << "a target begins with examples of its input";
  const auto kept =
      files_of(std::filesystem::path(GEODESIC_SOURCE_DIR) / "tests/fuzz/corpus" / target.name);
  files.insert(files.end(), kept.begin(), kept.end());
  for (const std::filesystem::path& file : files) {
    try {
      target.run(contents(file));
    } catch (const std::exception& problem) {
      ADD_FAILURE() << file << ": " << problem.what();
    }
  }
}

/// What a fuzzer begins with must lead somewhere: cut anywhere, it is still only refused.
TEST_P(Replay, SeedsCutShort) {
  const Target& target = GetParam();
  for (const std::filesystem::path& file :
       files_of(std::filesystem::path(GEODESIC_FUZZ_SEEDS) / "seeds" / target.name)) {
    const std::vector<std::uint8_t> whole = contents(file);
    for (std::size_t parts = 1; parts < 8; ++parts) {
      try {
        target.run(Bytes(whole).first(whole.size() * parts / 8));
      } catch (const std::exception& problem) {
        ADD_FAILURE() << file << ", " << parts << "/8 of it: " << problem.what();
      }
    }
  }
}

INSTANTIATE_TEST_SUITE_P(Fuzz, Replay, testing::ValuesIn(kTargets),
                         [](const testing::TestParamInfo<Target>& tested) {
                           return std::string(tested.param.name);
                         });

TEST(FuzzTools, AViolationIsNoticed) {
  EXPECT_THROW(expect(false, "nothing"), Violation);
  EXPECT_NO_THROW(expect(true, "nothing"));
}

TEST(FuzzTools, WhatMayBeShown) {
  for (const char* good : {"", "plain", "N·m", "\xf0\x9f\x99\x82"}) {
    EXPECT_TRUE(is_printable(good)) << good;
  }
  for (const char* bad : {"\n", "\x1b[31m", "\x7f", "\xff", "\xc2", "\xc2\x41", "\x80"}) {
    EXPECT_FALSE(is_printable(bad));
  }
}

TEST(FuzzTools, PastTheEndEverythingIsZero) {
  const std::vector<std::uint8_t> two{1, 2};
  Input input{Bytes(two)};
  EXPECT_EQ(input.integer(4), 0x01020000U);
  EXPECT_TRUE(input.empty());
  EXPECT_EQ(input.real(1.0), 0.0);
  EXPECT_EQ(input.take(5).size(), 0U);
}

}  // namespace
}  // namespace geodesic::fuzz
