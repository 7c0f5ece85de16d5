// The record of which zero was set when and by whom: one JSON object a line, beside the robot file,
// only ever appended to.
#pragma once

#include <cstdint>
#include <filesystem>
#include <string>

namespace geodesic::tools {

struct ZeroRecord {
  std::string when;  ///< UTC, "2026-11-23T01:30:00Z"
  std::string who;   ///< "user@host"
  std::string joint;
  std::string interface;
  std::string family;
  std::uint32_t drive_id = 0;
  bool done = false;        ///< read back as zero; else see report
  double before_rad = 0.0;  ///< the drive's own; NaN: not told
  double after_rad = 0.0;
  std::string report;
};

/// "arm/robot.toml" has its record in "arm/robot.zeros.jsonl".
std::filesystem::path zero_record_file(const std::filesystem::path& robot_file);

/// Makes sure that the file can be appended to. @throws BadInput if not.
void prepare_record(const std::filesystem::path& file);

/// Appends a line, to the disk. @throws BadInput if it cannot.
void append_record(const std::filesystem::path& file, const ZeroRecord& record);

std::string to_json_line(const ZeroRecord& record);

std::string utc_now();
/// Who is at the keyboard: the user who called sudo, else the process' own, and the host.
std::string who_am_i();

}  // namespace geodesic::tools
