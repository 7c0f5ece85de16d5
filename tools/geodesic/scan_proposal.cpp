// Proposing a robot's files from what answered; see the header.
#include "tools/geodesic/scan_proposal.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <charconv>
#include <map>
#include <set>

#include "drivers/bus/unix_address.hpp"

namespace geodesic::tools {
namespace {

/// Where the drive does not tell: so little that a wrong scaling shows before it hurts.
constexpr const char* kSmallVelocity = "5.0";
constexpr const char* kSmallTorque = "1.0";

bool has_option(const Sighting& sighting, std::string_view key) {
  const auto& options = sighting.drive.options;
  return std::any_of(options.begin(), options.end(),
                     [key](const auto& option) { return option.first == key; });
}

bool speaks_fd(const std::vector<Sighting>& sightings, const std::string& interface) {
  return std::any_of(sightings.begin(), sightings.end(), [&](const Sighting& sighting) {
    return sighting.fd && sighting.interface == interface;
  });
}

/// A name for each bus: the interface's, or bus1, bus2 for socket buses.
std::map<std::string, std::string> bus_names(const std::vector<Sighting>& sightings) {
  std::map<std::string, std::string> names;
  for (const Sighting& sighting : sightings) {
    if (names.contains(sighting.interface)) continue;
    const std::size_t number = names.size() + 1;
    names[sighting.interface] = drivers::is_socket_bus(sighting.interface)
                                    ? fmt::format("bus{}", number)
                                    : sighting.interface;
  }
  return names;
}

/// A TOML string; a path may hold anything.
std::string quoted(const std::string& text) {
  std::string result = "\"";
  for (const char c : text) {
    if (c == '"' || c == '\\') result += '\\';
    result += c;
  }
  return result + "\"";
}

/// Remarks of drives are comments here: one line, whatever they hold.
std::string one_line(std::string text) {
  std::replace_if(
      text.begin(), text.end(), [](unsigned char c) { return c < ' '; }, ' ');
  return text;
}

std::string joint_text(const Sighting& sighting, const std::string& name, const std::string& bus,
                       std::vector<std::string>& gaps) {
  const drivers::FoundDrive& drive = sighting.drive;
  std::string text = fmt::format("\n[[joint]]\nname = \"{}\"\nbus = {}\n", name, quoted(bus));
  if (!drive.model.empty() || !drive.firmware.empty()) {
    text += fmt::format(
        "# {}\n", one_line(fmt::format("{}, firmware {}",
                                       drive.model.empty() ? "model not told" : drive.model,
                                       drive.firmware.empty() ? "not told" : drive.firmware)));
  }
  for (const std::string& remark : drive.remarks) text += "# NOTE: " + one_line(remark) + "\n";
  text +=
      fmt::format("\n[joint.drive]\nfamily = \"{}\"\nid = 0x{:02X}\n", sighting.family, drive.id);
  if (drive.reply_id != 0) text += fmt::format("reply_id = 0x{:02X}\n", drive.reply_id);
  for (const auto& [key, value] : drive.options) text += fmt::format("{} = {}\n", key, value);
  const auto fill = [&](const char* key, const char* value) {
    if (has_option(sighting, key)) return;
    text +=
        fmt::format("{} = {}  # not told by the drive: take it from its data sheet\n", key, value);
    gaps.push_back(fmt::format("{}: {} = {} is a guess; take it from the drive's data sheet", name,
                               key, value));
  };
  fill("velocity_range_rad_s", kSmallVelocity);
  fill("torque_range_nm", kSmallTorque);
  const drivers::Family* family = drivers::find_family(sighting.family);
  if (family == nullptr) return text;
  for (const drivers::DriveSetting& setting : family->settings) {
    if (!setting.required || has_option(sighting, setting.key)) continue;
    text += fmt::format("# {} = ...  # REQUIRED: {}{}{}\n", setting.key, setting.doc,
                        setting.unit.empty() ? "" : " ", setting.unit);
    gaps.push_back(fmt::format("{}: {} must be filled in: {}", name, setting.key, setting.doc));
  }
  for (const std::string& wrong : family->check(options_of(sighting))) {
    text += "# WRONG: " + one_line(wrong) + "\n";
    gaps.push_back(fmt::format("{}: {}", name, wrong));
  }
  return text;
}

std::string urdf_text(std::size_t joints) {
  std::string text =
      "<?xml version=\"1.0\"?>\n<!-- A stand-in by `geodesic scan`: replace it with your robot's; "
      "nothing here is measured. -->\n<robot name=\"bench\">\n  <link name=\"base_link\"/>\n";
  for (std::size_t i = 1; i <= joints; ++i) {
    text += fmt::format(
        "  <link name=\"link{0}\">\n    <inertial>\n      <origin xyz=\"0 0 0\"/>\n      <mass "
        "value=\"0.1\"/>\n      <inertia ixx=\"0.001\" ixy=\"0\" ixz=\"0\" iyy=\"0.001\" iyz=\"0\" "
        "izz=\"0.001\"/>\n    </inertial>\n  </link>\n  <joint name=\"joint{0}\" "
        "type=\"continuous\">\n    <parent link=\"base_link\"/>\n    <child link=\"link{0}\"/>\n"
        "    <origin xyz=\"0 {1:.1f} 0\"/>\n    <axis xyz=\"0 0 1\"/>\n"
        "    <limit effort=\"1000\" velocity=\"100\"/>\n  </joint>\n",
        i, 0.2 * static_cast<double>(i));
  }
  return text + "</robot>\n";
}

}  // namespace

drivers::DriveOptions options_of(const Sighting& sighting) {
  drivers::DriveOptions options;
  options.family = sighting.family;
  options.id = sighting.drive.id;
  options.reply_id = sighting.drive.reply_id;
  options.fd = sighting.fd;
  options.velocity_range_rad_s = 5.0;
  options.torque_range_nm = 1.0;
  const drivers::Family* family = drivers::find_family(sighting.family);
  for (const auto& [key, text] : sighting.drive.options) {
    double value = 0.0;
    const bool number =
        std::from_chars(text.data(), text.data() + text.size(), value).ec == std::errc();
    if (number && key == "position_range_rad") options.position_range_rad = value;
    if (number && key == "velocity_range_rad_s") options.velocity_range_rad_s = value;
    if (number && key == "torque_range_nm") options.torque_range_nm = value;
    if (family == nullptr) continue;
    for (std::size_t i = 0; i < family->settings.size(); ++i) {
      const drivers::DriveSetting& setting = family->settings[i];
      if (setting.key != key) continue;
      if (number) options.settings.values[i] = value;
      for (std::size_t choice = 0; choice < setting.choices.size(); ++choice) {
        if (text == setting.choices[choice] ||
            text == fmt::format("\"{}\"", setting.choices[choice])) {
          options.settings.values[i] = static_cast<double>(choice);
        }
      }
    }
  }
  return options;
}

void compare(std::vector<Sighting>& sightings) {
  for (Sighting& one : sightings) {
    for (const Sighting& other : sightings) {
      if (&one == &other || one.interface != other.interface) continue;
      if (one.family != other.family && one.drive.id == other.drive.id) {
        one.drive.remarks.push_back(
            fmt::format("a drive of family {} has answered with this id too: one drive taken for "
                        "two, or two whose "
                        "identifiers may clash; unplug one and scan again",
                        other.family));
      }
      if (one.family == other.family && one.fd && !other.fd) {
        one.drive.remarks.push_back(fmt::format(
            "answers CAN FD, drive 0x{:X} of its family classic CAN only: a bus carries one of "
            "them; set both alike",
            other.drive.id));
      }
    }
  }
}

Proposal propose(const std::vector<Sighting>& sightings) {
  Proposal proposal;
  const std::map<std::string, std::string> names = bus_names(sightings);
  proposal.toml =
      "# Proposed by `geodesic scan` from the drives that answered. Before anything may move: name "
      "the\n# joints as your URDF does, say each one's direction, offset and limits, and check "
      "what is\n# marked. Then: geodesic check robot.toml\n[robot]\nname = \"bench\"\nurdf = "
      "\"robot.urdf\"  # a stand-in; yours instead\n\n[control]\nlaw = \"float\"\nstart_active = "
      "false\n";
  std::set<std::string> written;
  for (const Sighting& sighting : sightings) {
    if (!written.insert(sighting.interface).second) continue;
    proposal.toml += fmt::format("\n[[bus]]\nname = {}\ninterface = {}\nfd = {}\n",
                                 quoted(names.at(sighting.interface)), quoted(sighting.interface),
                                 speaks_fd(sightings, sighting.interface));
  }
  for (std::size_t i = 0; i < sightings.size(); ++i) {
    Sighting sighting = sightings[i];
    sighting.fd = speaks_fd(sightings, sighting.interface);  // a bus carries one of them
    proposal.toml += joint_text(sighting, fmt::format("joint{}", i + 1),
                                names.at(sighting.interface), proposal.gaps);
  }
  proposal.urdf = urdf_text(sightings.size());
  return proposal;
}

}  // namespace geodesic::tools
