// A folder of its own for each test, with a small valid robot in it that tests then spoil.
#pragma once

#include <gtest/gtest.h>
#include <unistd.h>

#include <cctype>
#include <filesystem>
#include <fstream>
#include <string>
#include <string_view>

#include "config/robot.hpp"

namespace geodesic::config {

inline constexpr std::string_view kRobotToml = R"([robot]
name = "two"
urdf = "two.urdf"
gravity = [0, -9.81, 0]
rate_hz = 1000
tool_link = "tip"

[[bus]]
name = "arm"
interface = "can0"

[[joint]]
name = "shoulder"
bus = "arm"
drive = { family = "damiao", id = 0x01, reply_id = 0x11, position_range_rad = 12.5, velocity_range_rad_s = 45, torque_range_nm = 54 }

[[joint]]
name = "elbow"
bus = "arm"
drive = { family = "damiao", id = 0x02, reply_id = 0x12, position_range_rad = 12.5, velocity_range_rad_s = 45, torque_range_nm = 54 }

[simulation.pose]
elbow = -0.5
)";

inline constexpr std::string_view kTwoUrdf = R"(<?xml version="1.0"?>
<robot name="two">
  <link name="base"/>
  <link name="upper">
    <inertial>
      <origin xyz="0.25 0 0" rpy="0 0 0"/>
      <mass value="1.3"/>
      <inertia ixx="0.001" ixy="0" ixz="0" iyy="0.027" iyz="0" izz="0.027"/>
    </inertial>
  </link>
  <link name="lower">
    <inertial>
      <origin xyz="0.2 0 0" rpy="0 0 0"/>
      <mass value="0.9"/>
      <inertia ixx="0.001" ixy="0" ixz="0" iyy="0.012" iyz="0" izz="0.012"/>
    </inertial>
  </link>
  <link name="tip"/>
  <joint name="shoulder" type="revolute">
    <parent link="base"/>
    <child link="upper"/>
    <origin xyz="0 0 0" rpy="0 0 0"/>
    <axis xyz="0 0 1"/>
    <limit lower="-3.14" upper="3.14" effort="100" velocity="10"/>
  </joint>
  <joint name="elbow" type="revolute">
    <parent link="upper"/>
    <child link="lower"/>
    <origin xyz="0.5 0 0" rpy="0 0 0"/>
    <axis xyz="0 0 1"/>
    <limit lower="-2.5" upper="2.5" effort="20" velocity="10"/>
  </joint>
  <joint name="tip_joint" type="fixed">
    <parent link="lower"/>
    <child link="tip"/>
    <origin xyz="0.4 0 0" rpy="0 0 0"/>
  </joint>
</robot>
)";

/// Replaces the one place where `from` stands; fails the test if there is none.
inline std::string replaced(std::string_view text, std::string_view from, std::string_view to) {
  std::string out(text);
  const std::size_t at = out.find(from);
  EXPECT_NE(at, std::string::npos) << "the base text has no: " << from;
  if (at != std::string::npos) out.replace(at, from.size(), to);
  return out;
}

class Bench : public ::testing::Test {
 public:
  Bench() {
    std::string pattern = (std::filesystem::temp_directory_path() / "config-XXXXXX").string();
    folder_ = mkdtemp(pattern.data());
    write("robot.toml", kRobotToml);
    write("two.urdf", kTwoUrdf);
  }
  ~Bench() override {
    std::error_code ignored;
    std::filesystem::remove_all(folder_, ignored);
  }
  Bench(const Bench&) = delete;
  Bench& operator=(const Bench&) = delete;

  std::filesystem::path write(const std::string& name, std::string_view text) const {
    std::ofstream(folder_ / name, std::ios::binary) << text;
    return folder_ / name;
  }
  LoadResult load(const LoadOptions& options = {}) const {
    return load_robot(folder_ / "robot.toml", options);
  }
  const std::filesystem::path& folder() const { return folder_; }

 private:
  std::filesystem::path folder_;
};

inline std::string all_of(const std::vector<Message>& messages) {
  std::string text;
  for (const Message& message : messages) text += to_string(message) + "\n";
  return text;
}

/// "no mass" as GoogleTest wants names: "no_mass".
inline std::string test_name(std::string words) {
  for (char& letter : words) {
    if (std::isalnum(static_cast<unsigned char>(letter)) == 0) letter = '_';
  }
  return words;
}

/// Whether one of the messages is in that file, line and column and says that.
inline bool says(const std::vector<Message>& messages, std::string_view file, int line, int column,
                 std::string_view fragment, Message::Severity severity) {
  for (const Message& m : messages) {
    if (m.severity == severity && m.place.file.filename() == file && m.place.line == line &&
        m.place.column == column && m.text.find(fragment) != std::string::npos) {
      return true;
    }
  }
  return false;
}

}  // namespace geodesic::config
