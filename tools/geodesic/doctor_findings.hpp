// What `geodesic doctor` finds: one thing looked at, how it stands, and the command that mends it.
#pragma once

#include <cstdint>
#include <string>
#include <utility>
#include <vector>

namespace geodesic::tools {

enum class Grade : std::uint8_t { kOk, kWarn, kBad };

struct Finding {
  Grade grade = Grade::kOk;
  std::string area;  ///< "kernel", "processors", "rights", "bus can0", "joint elbow"
  std::string what;  ///< "PREEMPT_RT"
  std::string text;  ///< what was found, and what was expected
  std::string fix;   ///< a command line; empty where all is well, or no command can help
};

using Findings = std::vector<Finding>;

/// "OK", "WARN", "BAD".
const char* to_string(Grade grade);

/// Collects findings of one area.
class Area {
 public:
  Area(std::string name, Findings& findings) : name_(std::move(name)), findings_(findings) {}

  void ok(std::string what, std::string text) {
    findings_.push_back({Grade::kOk, name_, std::move(what), std::move(text), {}});
  }
  void warn(std::string what, std::string text, std::string fix) {
    findings_.push_back({Grade::kWarn, name_, std::move(what), std::move(text), std::move(fix)});
  }
  void bad(std::string what, std::string text, std::string fix) {
    findings_.push_back({Grade::kBad, name_, std::move(what), std::move(text), std::move(fix)});
  }

 private:
  std::string name_;
  Findings& findings_;
};

}  // namespace geodesic::tools
