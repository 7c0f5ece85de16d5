// Implements subjects.hpp.
#include "tests/cross/subjects.hpp"

#include <gtest/gtest.h>

#include <algorithm>
#include <filesystem>
#include <stdexcept>

#include "config/urdf.hpp"

namespace geodesic::cross {
namespace {

control::TreeDescription read(const std::filesystem::path& file) {
  config::UrdfResult result = config::load_urdf(file, false);
  if (!result.ok) {
    std::string all = file.string();
    for (const auto& message : result.messages) {
      all.append("\n").append(config::to_string(message));
    }
    throw std::runtime_error(all);
  }
  return std::move(result.tree);
}

}  // namespace

std::vector<Subject> subjects() {
  std::vector<Subject> all;
  const std::filesystem::path data = GEODESIC_TEST_DATA;
  std::vector<std::filesystem::path> files;
  for (const char* folder : {"oracles", "robots"}) {
    for (const auto& entry : std::filesystem::directory_iterator(data / folder)) {
      if (entry.path().extension() == ".urdf") {
        files.push_back(entry.path());
      }
    }
  }
  std::sort(files.begin(), files.end());
  for (const auto& file : files) {
    all.push_back({file.stem().string(), read(file), control::Base::kFixed});
    all.push_back({file.stem().string(), read(file), control::Base::kFloating});
  }
  constexpr int kSizes[] = {1, 2, 4, 7, 13, 32};
  for (unsigned seed = 0; seed < 24; ++seed) {
    control::testing::RandomArm random(500 + seed);
    control::testing::RandomTreeOptions shape;
    shape.joints = kSizes[seed % 6];
    shape.mimic_joints = seed % 4 == 3 ? 3 : 0;
    shape.any_kind = seed >= 12;
    all.push_back({"random" + std::to_string(seed), random.tree(shape),
                   seed % 3 == 1 ? control::Base::kFloating : control::Base::kFixed});
  }
  return all;
}

void expect_same(const Eigen::MatrixXd& ours, const Eigen::MatrixXd& theirs, double tolerance,
                 const char* what) {
  ASSERT_EQ(ours.rows(), theirs.rows()) << what;
  ASSERT_EQ(ours.cols(), theirs.cols()) << what;
  const double scale = std::max(1e-3, theirs.cwiseAbs().maxCoeff());
  const double difference = (ours - theirs).cwiseAbs().maxCoeff();
  EXPECT_LE(difference, tolerance * scale) << what << ": apart by " << difference / scale;
}

}  // namespace geodesic::cross
