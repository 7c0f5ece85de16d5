// Implements subject.hpp.
#include "tools/geodesic/subject.hpp"

#include <fmt/format.h>

#include <cstdio>
#include <filesystem>
#include <utility>

#include "config/urdf.hpp"
#include "tools/geodesic/command.hpp"

namespace geodesic::tools {

Subject read_subject(const std::string& file) {
  Subject subject;
  if (std::filesystem::path(file).extension() == ".toml") {
    const config::Robot robot = load({file, {}, false});
    subject.tree = robot.tree;
    subject.gravity = robot.gravity;
    subject.frame = robot.tool_link;
    subject.rotor_inertia.resize(static_cast<Eigen::Index>(robot.controller.joints.size()));
    for (std::size_t i = 0; i < robot.controller.joints.size(); ++i) {
      subject.rotor_inertia[static_cast<Eigen::Index>(i)] =
          robot.controller.joints[i].rotor_inertia;
    }
    return subject;
  }
  config::UrdfResult urdf = config::load_urdf(file, false);
  for (const config::Message& message : urdf.messages) {
    fmt::print(stderr, "{}\n", config::to_string(message));
  }
  if (!urdf.ok) throw BadInput("");
  subject.tree = std::move(urdf.tree);
  return subject;
}

}  // namespace geodesic::tools
