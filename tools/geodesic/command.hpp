// What every subcommand of `geodesic` shares: exit statuses, the robot argument, how a command is
// added. The commands themselves are in a file each.
#pragma once

#include <functional>
#include <nlohmann/json_fwd.hpp>
#include <stdexcept>
#include <string>
#include <vector>

#include "config/robot.hpp"

// NOLINTNEXTLINE(readability-identifier-naming): the library's own name
namespace CLI {
class App;
}

namespace geodesic::tools {

inline constexpr int kExitOk = 0;
inline constexpr int kExitRefused = 1;  ///< bad input, or refused
inline constexpr int kExitUsage = 2;    ///< wrong call
inline constexpr int kExitFault = 3;    ///< it ran, and ended in a fault

/// Bad input, in words for the user; an empty text has been said already. Ends with kExitRefused.
class BadInput : public std::runtime_error {
 public:
  using std::runtime_error::runtime_error;
};

/// Set by the chosen subcommand; main() calls it and ends with what it returns.
using Run = std::function<int()>;

/// Each adds one subcommand to `app`.
void add_sim(CLI::App& app, Run& run);
void add_bus(CLI::App& app, Run& run);
void add_check(CLI::App& app, Run& run);
void add_model(CLI::App& app, Run& run);
void add_derive(CLI::App& app, Run& run);
void add_compile(CLI::App& app, Run& run);
void add_shoot(CLI::App& app, Run& run);
void add_scan(CLI::App& app, Run& run);
void add_doctor(CLI::App& app, Run& run);
void add_zero(CLI::App& app, Run& run);
void add_jog(CLI::App& app, Run& run);
void add_decode(CLI::App& app, Run& run);
void add_status(CLI::App& app, Run& run);
void add_law(CLI::App& app, Run& run);
void add_stop(CLI::App& app, Run& run);
void add_faults(CLI::App& app, Run& run);
void add_tune(CLI::App& app, Run& run);

/// The robot a command works on.
struct RobotArguments {
  std::string file;
  std::vector<std::string> buses;
  bool strict = false;
};

/// Adds ROBOT.toml and --bus.
void add_robot(CLI::App& command, RobotArguments& arguments);

/// Reads the file; its messages go to stderr. @throws BadInput if it is not whole.
config::Robot load(const RobotArguments& arguments);

/// Messages of a file as a list of {severity, file, line, column, text}.
nlohmann::ordered_json to_json(const std::vector<config::Message>& messages);

/// Appends the lines all help texts end with.
std::string footer(const std::string& examples);

/// Writes text to a file, whole or not at all. @throws BadInput if it cannot.
void write_file(const std::string& file, const std::string& text);

}  // namespace geodesic::tools
