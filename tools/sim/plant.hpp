// The simulated arm without a bus: mechanics, one simulated drive a joint, the stand that carries
// the arm until its drives are enabled, and the script of pushes and faults, all on one clock.
#pragma once

#include <cstdint>
#include <functional>
#include <memory>
#include <optional>
#include <span>
#include <stdexcept>
#include <string>
#include <vector>

#include "config/robot.hpp"
#include "drivers/drive.hpp"
#include "drivers/families.hpp"
#include "tools/sim/physics.hpp"
#include "tools/sim/script.hpp"

namespace geodesic::tools {

struct PlantOptions {
  double release_s = 2.0;  ///< the stand lets go when all drives have been enabled this long
  Script script;
  std::int64_t start_ns = 0;                      ///< the clock's first value
  double timestep_s = Physics::kDefaultTimestep;  ///< of the mechanics, at most
};

/// What became of one joint. [rad, N·m] or [m, N].
struct JointHistory {
  std::string name;
  double start = 0.0;           ///< position at the start
  double at_release = 0.0;      ///< position at the release
  double motion_before = 0.0;   ///< largest distance from the start while carried
  double residual = 0.0;        ///< torque beyond what the pose needs, at the release
  double drift_max = 0.0;       ///< largest distance from at_release, ever since
  double drift_rest = 0.0;      ///< largest distance from where it came to rest after all pushes
  double torque_max = 0.0;      ///< largest |torque| of the drive
  std::uint64_t heard = 0;      ///< frames to its drive
  std::uint64_t answered = 0;   ///< replies of its drive
  std::uint64_t swallowed = 0;  ///< frames it did not hear for a scripted fault
  std::uint64_t watchdog_trips = 0;
};

/// A scripted fault as it happened.
struct Injection {
  std::size_t joint = 0;
  FaultKind kind = FaultKind::kSilent;
  double at_s = 0.0;       ///< since the start
  std::int64_t at_ns = 0;  ///< of the plant's clock
};

struct PlantReport {
  static constexpr double kDriftBin = 0.01;  ///< [s]
  std::vector<JointHistory> joints;
  std::vector<Injection> injections;  ///< in order of time
  std::optional<double> enabled_s;    ///< all drives enabled for the first time, since the start
  std::optional<double> release_s;    ///< the stand let go, since the start
  std::optional<double> disabled_s;   ///< a drive left enabled after the release, since the start
  std::optional<double> rest_s;       ///< at rest after the last push, since the start
  std::vector<double> drift;          ///< largest of any joint in each kDriftBin since the release
  PhysicsEnergy energy_at_release;
  double contact_s = 0.0;  ///< time in contact with the floor
  double contact_force_max_n = 0.0;
};

/// The mechanics left the finite numbers.
class Diverged : public std::runtime_error {
 public:
  using std::runtime_error::runtime_error;
};

class Plant {
 public:
  struct Answer {
    std::size_t joint = 0;
    drivers::Frame frame;
  };

  /// @throws std::invalid_argument, std::runtime_error as Physics, or for an unknown drive family.
  Plant(const config::Robot& robot, PlantOptions options);

  std::int64_t now_ns() const noexcept { return now_ns_; }
  std::int64_t step_ns() const noexcept { return step_ns_; }
  double elapsed_s() const noexcept;
  bool released() const noexcept { return report_.release_s.has_value(); }
  std::size_t joints() const noexcept { return drives_.size(); }
  double position(std::size_t joint) const noexcept { return physics_.position(joint); }
  double velocity(std::size_t joint) const noexcept { return physics_.velocity(joint); }
  /// Torque of the drive on the joint in the last step.
  double torque(std::size_t joint) const noexcept { return torque_[joint]; }
  bool enabled(std::size_t joint) const { return drives_[joint].simulated->enabled(); }
  /// A scripted fault has cut its drive off: it neither hears nor answers.
  bool silent(std::size_t joint) const noexcept;
  /// Something floods this bus: none of its drives hears or answers.
  bool babbling(std::size_t bus) const noexcept { return now_ns_ < babbling_until_ns_[bus]; }
  /// Nothing is to move on this bus.
  bool held(std::size_t bus) const noexcept { return now_ns_ < held_until_ns_[bus]; }
  const std::vector<std::string>& warnings() const noexcept { return physics_.warnings(); }
  Physics& physics() noexcept { return physics_; }
  const PlantReport& report() const noexcept { return report_; }

  /// Mechanics and drives' watchdogs up to the last whole step before to_ns.
  /// @throws Diverged.
  void advance(std::int64_t to_ns);
  /// The clock jumps to to_ns, nothing moves: this host was not able to keep up.
  void skip(std::int64_t to_ns) noexcept;

  /// Shows a frame to every drive on a bus, at now_ns (not before now_ns()). Appends the answers.
  void hear(std::size_t bus, const drivers::Frame& frame, std::int64_t now_ns,
            std::vector<Answer>& answers);
  /// Appends what the drives of a bus send unasked by now_ns.
  void speak(std::size_t bus, std::int64_t now_ns, std::vector<Answer>& answers);
  /// Whose drive a frame on that bus commands, if anybody's.
  std::optional<std::size_t> addressee(std::size_t bus, const drivers::Frame& frame) const;

  /// Called every `interval_s` of the clock, the first time at once. For traces.
  void on_sample(double interval_s, std::function<void()> sample);

 private:
  struct PlantDrive {
    const drivers::JointOptions* options = nullptr;
    const drivers::Family* family = nullptr;
    std::unique_ptr<drivers::SimulatedDrive> simulated;
    std::vector<drivers::IdFilter> own_ids;  // command identifiers nobody else on the bus has
    std::int64_t silent_until_ns = 0;
    double encoder_offset = 0.0;                    // [rad or m] at the joint
    std::optional<double> stuck_position;           // [rad or m] at the joint
    std::unique_ptr<drivers::SimulatedDrive> twin;  // where the script has one
    bool twin_answers = false;
  };

  void list_own_ids(const config::Robot& robot);
  void one_step();
  void turn_shafts(double ahead_s);
  void turn_shafts_at(std::int64_t now_ns);
  void act_out_faults();
  std::optional<std::int64_t> begin_of(FaultBase base) const;
  void act_out(const ScriptedFault& fault);
  static void set_shaft(drivers::SimulatedDrive& drive, const drivers::JointOptions& joint,
                        double position, double velocity);
  void act_out_pushes(double since_release_s);
  /// The stand gives each joint what its drive does not, up to what the pose needs, and resists
  /// nothing: torque beyond the need, or of the wrong sign, moves the arm off it.
  void lean_on_stand();
  void watch_stand();
  void let_go();
  void observe();
  void note_disabled();
  void observe_rest(double since_release_s);

  config::Robot robot_;
  PlantOptions options_;
  std::int64_t step_ns_;
  Physics physics_;
  std::int64_t now_ns_;
  std::int64_t turned_ns_ = -1;  ///< the shafts stand where they are then; -1: somewhere
  std::vector<PlantDrive> drives_;
  std::vector<double> torque_;
  std::vector<bool> fault_done_;
  std::vector<std::int64_t> babbling_until_ns_;  // of each bus
  std::vector<std::int64_t> held_until_ns_;
  std::vector<int> force_link_;
  bool forces_act_ = false;
  std::int64_t enabled_since_ns_ = -1;
  std::int64_t release_ns_ = 0;
  double pushes_end_s_ = 0.0;
  double at_rest_since_s_ = -1.0;
  std::vector<double> rest_position_;
  PlantReport report_;
  std::function<void()> sample_;
  std::int64_t sample_interval_ns_ = 0;
  std::int64_t next_sample_ns_ = 0;
};

}  // namespace geodesic::tools
