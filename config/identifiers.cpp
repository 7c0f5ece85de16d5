// No two drives of a bus may share an identifier, nor may one's answer be another's command.
#include <fmt/format.h>

#include "config/checks.hpp"
#include "drivers/families.hpp"

namespace geodesic::config {
namespace {

/// Drives of one bus, in the file's order, for the messages' sake.
std::vector<const JointEntry*> on_bus(const RobotFile& file, const BusEntry& bus) {
  std::vector<const JointEntry*> entries;
  for (const JointEntry& entry : file.joints) {
    if (entry.bus.given && entry.bus.value == bus.name.value && entry.drive.id.given) {
      entries.push_back(&entry);
    }
  }
  return entries;
}

/// @return whether the two may be on one bus as far as these two identifiers go.
bool check_pair(const JointEntry& first, const JointEntry& second, Findings& findings) {
  const DriveEntry& a = first.drive;
  const DriveEntry& b = second.drive;
  if (a.family.value != b.family.value) return true;  // each counts in its own way
  const std::string other =
      fmt::format("joint {} (line {})", quote(first.name.value), first.place.line);
  bool fine = true;
  const auto clash = [&](const Given<std::int64_t>& mine, const char* key,
                         const Given<std::int64_t>& theirs, const char* meaning) {
    if (!mine.given || !theirs.given || mine.value != theirs.value) return;
    findings.error(mine.place, fmt::format("{}: {:#04x} is {} {}; expected identifiers of its own "
                                           "for every drive of a bus",
                                           key, mine.value, meaning, other));
    fine = false;
  };
  clash(b.id, "id", a.id, "the id of");
  clash(b.reply_id, "reply_id", a.id, "the id of");
  clash(b.id, "id", a.reply_id, "the reply_id of");
  return fine;
}

const Place& place(const JointEntry& entry) {
  return entry.drive.reply_id.given ? entry.drive.reply_id.place : entry.drive.id.place;
}

/// Families have more identifiers than the two (offsets, broadcast): the drives themselves know.
void check_by_drives(const JointEntry& first, const drivers::Drive& a, const JointEntry& second,
                     const drivers::Drive& b, Findings& findings) {
  const auto clash = [&](const JointEntry& speaker, const drivers::Drive& answers,
                         const JointEntry& hearer, const drivers::Drive& hears) {
    for (const drivers::IdFilter& reply : answers.reply_ids()) {
      for (const drivers::IdFilter& command : hears.command_ids()) {
        if (!drivers::overlap(reply, command)) continue;
        findings.error(
            place(speaker),
            fmt::format(
                "drive: {:#04x} that it answers on is an identifier that commands the drive of "
                "joint {} (line {})",
                reply.id, quote(hearer.name.value), hearer.place.line));
      }
    }
  };
  clash(second, b, first, a);
  clash(first, a, second, b);
  for (const drivers::IdFilter& reply : b.reply_ids()) {
    for (const drivers::IdFilter& other : a.reply_ids()) {
      if (!drivers::overlap(reply, other) || (reply.shared && other.shared)) continue;
      findings.error(place(second),
                     fmt::format("drive: {:#04x} that it answers on is one that the drive of joint "
                                 "{} (line {}) answers on",
                                 reply.id, quote(first.name.value), first.place.line));
    }
  }
}

}  // namespace

void check_identifiers(Draft& draft) {
  bool fine = true;
  for (const BusEntry& bus : draft.file.buses) {
    const std::vector<const JointEntry*> entries = on_bus(draft.file, bus);
    for (std::size_t i = 0; i < entries.size(); ++i) {
      for (std::size_t k = 0; k < i; ++k) {
        fine = check_pair(*entries[k], *entries[i], draft.findings) && fine;
      }
    }
  }
  if (!fine || draft.findings.has_errors()) return;  // drives are made of checked options only
  const auto& joints = draft.robot.arm.joints;
  std::vector<std::unique_ptr<drivers::Drive>> drives;
  std::vector<const JointEntry*> entries;
  for (const drivers::JointOptions& joint : joints) {
    drives.push_back(drivers::find_family(joint.drive.family)->make_drive(joint.drive));
    for (const JointEntry& entry : draft.file.joints) {
      if (entry.name.value == joint.name) entries.push_back(&entry);
    }
  }
  for (std::size_t i = 0; i < joints.size(); ++i) {
    for (std::size_t k = 0; k < i; ++k) {
      if (joints[i].bus != joints[k].bus) continue;
      check_by_drives(*entries[k], *drives[k], *entries[i], *drives[i], draft.findings);
    }
  }
}

}  // namespace geodesic::config
