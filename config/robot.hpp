// A robot as its file describes it, checked whole: the option structs of every room, the tree of
// its URDF, and the warnings that were found on the way. Reading is in load_robot().
#pragma once

#include <cstdint>
#include <filesystem>
#include <optional>
#include <string>
#include <vector>

#include "control/mechanism/tree.hpp"
#include "control/options.hpp"
#include "drivers/arm.hpp"

namespace geodesic::config {

/// Where in which file something was found; line and column count from 1, 0: unknown.
struct Place {
  std::filesystem::path file;
  int line = 0;
  int column = 0;
};

/// One finding: "FILE:LINE:COLUMN: error: TEXT".
struct Message {
  enum class Severity : std::uint8_t { kWarning, kError } severity = Severity::kError;
  Place place;
  std::string text;  ///< what was found, what was expected, often the fix
};
std::string to_string(const Message& message);

/// Whether a running daemon takes a change of an option (options/options.hpp).
enum class Live : std::uint8_t;

/// One option of a robot as it stands, with what its declaration says of it (settings.hpp).
struct Setting {
  std::vector<std::string> steps;  ///< {"joint", "elbow", "damping"}
  std::string path;                ///< "joint.elbow.damping"
  std::string value;               ///< as TOML, exact; empty: not given, and no constant stands in
  std::string fallback;            ///< where `value` is empty: how it is found, "the URDF's"
  std::string unit;
  std::string range;
  std::string doc;
  Live live{};
  bool element = false;  ///< stands for a whole [[table]], not for a value
  Place place;           ///< where a file says so; line 0: nowhere
};

struct RealtimeOptions {
  int priority = 80;              ///< SCHED_FIFO
  std::vector<int> cpus;          ///< pin to these; empty: wherever the kernel likes
  double receive_deadline = 0.8;  ///< part of the period after which missing replies are lost
};

/// What the simulated arm adds to the URDF, for one joint.
struct SimulatedJoint {
  double coulomb_friction = 0.0;  ///< [N·m or N]
  double viscous_friction = 0.0;  ///< [N·m·s/rad or N·s/m]
  double rotor_inertia = 0.0;     ///< [kg·m² or kg]
};

struct SimulationOptions {
  std::vector<SimulatedJoint> joints;  ///< in order of v
  std::vector<double> pose;            ///< start configuration, in order of v [rad or m]
  double floor_z_m = 0.0;
  bool floor = false;               ///< there is a floor to touch at floor_z_m
  double reply_latency_s = 100e-6;  ///< a drive's, from end of command to start of reply
  /// What the simulated arm carries, index into Robot::payloads; the controller does not know of
  /// it.
  std::optional<std::size_t> payload;
};

/// Something the arm may carry, rigidly held by a link.
struct Payload {
  std::string name;
  std::string link;
  control::LinkInertia inertia;  ///< in the link's frame
};

struct Robot {
  std::string name;
  std::filesystem::path file;  ///< the TOML
  std::filesystem::path urdf;
  std::int64_t period_ns = 1'000'000;
  Eigen::Vector3d gravity{0.0, 0.0, -9.81};  ///< [m/s²], world frame
  std::string tool_link;                     ///< frame that reports speak of; may be empty
  control::TreeDescription tree;             ///< joints that the file locks are fixed in here
  drivers::ArmOptions arm;
  control::ControllerOptions controller;
  std::filesystem::path compiled;  ///< shared object of the model; empty: none
  RealtimeOptions realtime;
  SimulationOptions simulation;
  std::vector<Payload> payloads;
  std::optional<std::size_t> payload;  ///< what the controller counts with; none: nothing
  std::vector<Setting> settings;       ///< every option there is, in the order of the reference
};

/// The texts a robot is made from.
struct RobotText {
  std::string robot;  ///< the TOML
  std::string urdf;
};

/// A value to be taken in place of what the file says.
struct Override {
  std::string path;   ///< as Setting::path
  std::string value;  ///< as TOML
};

struct LoadOptions {
  bool strict = false;  ///< warnings of the model lint are errors
  /// Replaces the buses' interfaces, one for each in order (a single name for several buses is
  /// refused: identifiers are told apart by bus). From --bus of the command line.
  std::vector<std::string> bus_override;
  /// Taken as if the file said so, and checked alike; messages name them in place of a file.
  std::vector<Override> overrides;
  /// These texts are read in place of the files.
  std::optional<RobotText> text;
};

struct LoadResult {
  Robot robot;                    ///< whole only if ok
  std::vector<Message> messages;  ///< in order of place
  RobotText text;                 ///< what was read
  bool ok = false;
};

/// Reads and checks a robot file and its URDF. Never throws for what a file says; every finding is
/// a message, and all findings of one reading are reported together. Not real-time.
LoadResult load_robot(const std::filesystem::path& file, const LoadOptions& options = {});

}  // namespace geodesic::config
