// What a recorded frame means to a robot; see the header.
#include "tools/geodesic/frame_meaning.hpp"

#include <fmt/format.h>

namespace geodesic::tools {
namespace {

std::string bytes_of(const drivers::Frame& frame) {
  std::string text;
  for (const std::uint8_t byte : frame.payload()) text += fmt::format("{:02X}", byte);
  return text;
}

}  // namespace

FrameMeaning meaning_of(const CandumpLine& line, const config::Robot& robot) {
  if (line.frame.error) {
    return {
        "",
        "bus error frame",
        {{"class", fmt::format("0x{:X}", line.frame.id), ""}, {"data", bytes_of(line.frame), ""}}};
  }
  if (line.remote) return {"", "remote request", {}};
  const auto& buses = robot.arm.buses;
  for (const drivers::JointOptions& joint : robot.arm.joints) {
    if (buses.size() > 1 && buses[joint.bus].interface != line.interface) continue;
    const drivers::Family* family = drivers::find_family(joint.drive.family);
    if (family == nullptr) continue;
    if (auto decoded = family->decode(line.frame, joint.drive)) {
      return {joint.name, std::move(decoded->kind), std::move(decoded->fields)};
    }
  }
  bool known = buses.size() <= 1;
  for (const drivers::BusOptions& bus : buses) known = known || bus.interface == line.interface;
  return {"",
          known ? "unknown" : "the robot has no bus " + line.interface,
          {{"data", bytes_of(line.frame), ""}}};
}

}  // namespace geodesic::tools
