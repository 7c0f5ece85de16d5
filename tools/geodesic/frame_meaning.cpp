// What a recorded frame means to a robot; see the header.
#include "tools/geodesic/frame_meaning.hpp"

#include <fmt/format.h>

#include <algorithm>

#include "drivers/lockstep_tick.hpp"
#include "tools/geodesic/error_frame_words.hpp"

namespace geodesic::tools {
namespace {

std::string bytes_of(const drivers::Frame& frame) {
  std::string text;
  for (const std::uint8_t byte : frame.payload()) text += fmt::format("{:02X}", byte);
  return text;
}

/// One reading of a frame, and the joints whose drives read it so.
struct Reading {
  drivers::DecodedFrame words;
  std::string_view family;
  std::vector<std::string> joints;
};

bool same(const drivers::DecodedFrame& a, const drivers::DecodedFrame& b) {
  return a.kind == b.kind &&
         std::equal(a.fields.begin(), a.fields.end(), b.fields.begin(), b.fields.end(),
                    [](const drivers::DecodedField& one, const drivers::DecodedField& other) {
                      return one.name == other.name && one.value == other.value &&
                             one.unit == other.unit;
                    });
}

std::string joined(const std::vector<std::string>& names) {
  std::string text;
  for (const std::string& name : names) text += (text.empty() ? "" : ", ") + name;
  return text;
}

}  // namespace

FrameMeaning meaning_of(const CandumpLine& line, const config::Robot& robot) {
  if (line.frame.error) return {"", "bus error frame", error_frame_words(line.frame)};
  if (drivers::is_tick(line.frame)) return {"", "tick of simulated time", {}};
  const drivers::Frame& frame = line.frame;
  const auto& buses = robot.arm.buses;
  std::vector<Reading> readings;
  for (const drivers::JointOptions& joint : robot.arm.joints) {
    if (buses.size() > 1 && buses[joint.bus].interface != line.interface) continue;
    const drivers::Family* family = drivers::find_family(joint.drive.family);
    if (family == nullptr) continue;
    std::optional<drivers::DecodedFrame> decoded = family->decode(frame, joint.drive);
    if (!decoded) continue;
    const auto known = std::find_if(readings.begin(), readings.end(), [&](const Reading& reading) {
      return reading.family == family->name && same(reading.words, *decoded);
    });
    if (known != readings.end()) {
      known->joints.push_back(joint.name);  // a frame to all of them: SYNC, NMT, an emergency stop
    } else {
      readings.push_back({std::move(*decoded), family->name, {joint.name}});
    }
  }
  if (!readings.empty()) {
    Reading& first = readings.front();
    for (std::size_t i = 1; i < readings.size(); ++i) {
      first.words.fields.push_back(
          {"also read as",
           fmt::format("{} of {}", readings[i].words.kind, joined(readings[i].joints)), ""});
    }
    return {joined(first.joints), std::move(first.words.kind), std::move(first.words.fields)};
  }
  if (frame.remote) return {"", "remote request", {}};
  bool known = buses.size() <= 1;
  for (const drivers::BusOptions& bus : buses) known = known || bus.interface == line.interface;
  return {"",
          known ? "unknown" : "the robot has no bus " + line.interface,
          {{"data", bytes_of(line.frame), ""}}};
}

}  // namespace geodesic::tools
