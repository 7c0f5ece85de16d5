// geodesicd's command line as a struct. Reads no file and opens no bus.
#pragma once

#include <cstdint>
#include <filesystem>
#include <optional>
#include <string>
#include <vector>

#include "config/robot.hpp"
#include "tools/geodesicd/log.hpp"

namespace geodesic::tools {

enum class ExitCode : int {
  kClean = 0,
  kRefused = 1,  ///< bad configuration, or the start was refused
  kUsage = 2,
  kFault = 3,  ///< the run ended in a fault, or torque was forced off
};

struct CommandLine {
  std::filesystem::path robot;
  std::filesystem::path summary;
  std::filesystem::path trace;
  double trace_hz = 100.0;
  std::vector<std::string> buses;
  std::filesystem::path socket;
  std::string law;
  std::string compiled;  ///< a compiled model's file in place of the robot file's; "none": no such
  double seconds = 0.0;  ///< 0: no end
  bool best_effort = false;
  bool no_seal = false;
  bool simulated_time = false;
  bool strict = false;
  bool no_start = false;
  bool allow_zero_law = false;
  bool exit_on_fault = false;
  bool json = false;
  Severity log_level = Severity::kInfo;
};

/// Prints help, version or what is wrong by itself.
/// @return the options, or the exit code if there is nothing more to do.
struct ParseResult {
  std::optional<CommandLine> options;
  ExitCode code = ExitCode::kClean;
};
ParseResult parse_command_line(int argc, const char* const* argv);

/// Whether no real arm can be behind this bus: unix:PATH, or a kernel interface named vcan* or
/// vxcan* that no hardware is behind.
bool is_virtual_bus(const std::string& interface);

/// Puts what the command line says over what the robot file says.
/// @return why it may not be (a real bus where only a virtual one will do), or nothing.
std::optional<std::string> apply(const CommandLine& options, config::Robot& robot);

}  // namespace geodesic::tools
