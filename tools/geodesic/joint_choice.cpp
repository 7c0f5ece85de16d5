// Choosing a joint; see the header.
#include "tools/geodesic/joint_choice.hpp"

#include <fmt/format.h>

#include <vector>

#include "config/findings.hpp"
#include "tools/geodesic/command.hpp"

namespace geodesic::tools {

std::size_t choose_joint(const config::Robot& robot, const std::string& name) {
  std::vector<std::string> known;
  for (std::size_t i = 0; i < robot.arm.joints.size(); ++i) {
    known.push_back(robot.arm.joints[i].name);
    if (known.back() == name) return i;
  }
  throw BadInput(fmt::format("there is no joint {}{}; joints: {}", config::quote(name),
                             config::did_you_mean(name, known), config::list_names(known)));
}

const char* unit_of(const config::Robot& robot, std::size_t joint) {
  const std::string& name = robot.arm.joints[joint].name;
  for (const control::JointDescription& described : robot.tree.joints) {
    if (described.name == name && described.kind == control::JointKind::kPrismatic) return "m";
  }
  return "rad";
}

}  // namespace geodesic::tools
