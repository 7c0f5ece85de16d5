// Every option of a robot file, declared once: key, type, unit, range, default, meaning.
#include "config/robot_file.hpp"

namespace geodesic::config {
namespace {

constexpr std::string_view kTorque = "N·m or N";
constexpr std::string_view kPosition = "rad or m";
constexpr std::string_view kVelocity = "rad/s or m/s";
constexpr std::string_view kStiffness = "N·m/rad or N/m";
constexpr std::string_view kDamping = "N·m·s/rad or N·s/m";
constexpr std::string_view kInertia = "kg·m² or kg";
constexpr std::array<std::string_view, 3> kLaws = {"float", "hold", "damp"};

void describe_robot(OptionVisitor& o, RobotEntry& e) {
  o.text({.key = "name", .doc = "How logs and reports call the robot.", .required = true}, e.name);
  o.text({.key = "urdf", .doc = "The robot's URDF file.", .required = true}, e.urdf);
  o.vector({.key = "gravity",
            .doc = "Acceleration of free fall in the frame of the URDF's root link.",
            .unit = "m/s²",
            .range = between(-30.0, 30.0)},
           e.gravity);
  o.number({.key = "rate_hz", .doc = "Cycles a second.", .unit = "Hz", .range = between(50, 4000)},
           e.rate_hz);
  o.text(
      {.key = "tool_link", .doc = "The link whose pose reports speak of.", .default_text = "none"},
      e.tool_link);
  o.by_name({.key = "lock",
             .doc = "Joints that do not move and have no drive, each with its fixed position: "
                    "`lock = { finger_joint1 = 0.0 }`.",
             .unit = kPosition},
            e.lock);
}

void describe_realtime(OptionVisitor& o, RealtimeEntry& e) {
  o.integer({.key = "priority",
             .doc = "SCHED_FIFO priority of the cycle's thread.",
             .range = between(1, 98)},
            e.priority);
  o.integers({.key = "cpus",
              .doc = "Processors the thread may run on; empty: wherever the kernel likes.",
              .range = between(0, 1023)},
             e.cpus);
  o.number({.key = "receive_deadline",
            .doc = "Part of the period after which a missing reply counts as lost.",
            .range = between(0.1, 0.98)},
           e.receive_deadline);
}

void describe_bus(OptionVisitor& o, BusEntry& e) {
  e.place = o.here();
  o.text({.key = "name", .doc = "How joints refer to the bus.", .required = true}, e.name);
  o.text({.key = "interface",
          .doc = "`can0`, `vcan0`, or `unix:PATH` for a socket bus.",
          .required = true},
         e.interface);
  o.flag({.key = "fd", .doc = "Frames are CAN FD with bit-rate switch."}, e.fd);
  o.integer({.key = "bit_rate",
             .doc = "Nominal bit rate.",
             .unit = "bit/s",
             .range = between(10'000, 1'000'000)},
            e.bit_rate);
  o.integer({.key = "data_bit_rate",
             .doc = "Bit rate of the data phase; with `fd = true` only.",
             .unit = "bit/s",
             .range = between(10'000, 12'000'000)},
            e.data_bit_rate);
}

void describe_drive(OptionVisitor& o, DriveEntry& e) {
  e.place = o.here();
  o.text({.key = "family", .doc = "The drive's protocol, for example `damiao`.", .required = true},
         e.family);
  o.integer({.key = "id",
             .doc = "Identifier the drive listens on.",
             .range = between(0, 0x1FFFFFFF),
             .required = true},
            e.id);
  o.integer({.key = "reply_id",
             .doc = "Identifier the drive answers on.",
             .range = between(0, 0x1FFFFFFF),
             .required = true},
            e.reply_id);
  o.number({.key = "position_range_rad",
            .doc = "The drive's position scaling (Damiao PMAX); read back at start and compared.",
            .unit = "rad",
            .range = kPositive,
            .required = true},
           e.position_range_rad);
  o.number({.key = "velocity_range_rad_s",
            .doc = "The drive's velocity scaling (Damiao VMAX); read back and compared.",
            .unit = "rad/s",
            .range = kPositive,
            .required = true},
           e.velocity_range_rad_s);
  o.number({.key = "torque_range_nm",
            .doc = "The drive's torque scaling (Damiao TMAX); read back and compared.",
            .unit = "N·m",
            .range = kPositive,
            .required = true},
           e.torque_range_nm);
  o.number(
      {.key = "watchdog_ms",
       .doc = "Without a command for this long the drive stops on its own; at least 3 periods.",
       .unit = "ms",
       .range = {0.0, 10'000.0, true}},
      e.watchdog_ms);
  o.flag({.key = "clear_errors",
          .doc = "Clear an error that the drive already has at start, instead of refusing."},
         e.clear_errors);
}

void describe_limits(OptionVisitor& o, JointEntry& e) {
  o.number({.key = "position_lower",
            .doc = "Hard limit: beyond it is a fault.",
            .unit = kPosition,
            .default_text = "the URDF's"},
           e.position_lower);
  o.number({.key = "position_upper",
            .doc = "Hard limit: beyond it is a fault.",
            .unit = kPosition,
            .default_text = "the URDF's"},
           e.position_upper);
  o.number({.key = "velocity_limit",
            .doc = "Faster than this is a fault.",
            .unit = kVelocity,
            .range = kPositive,
            .default_text = "the lesser of the URDF's and the drive's range"},
           e.velocity_limit);
  o.number({.key = "torque_limit",
            .doc = "No more than this is ever commanded.",
            .unit = kTorque,
            .range = kPositive,
            .default_text = "the lesser of the URDF's and the drive's range"},
           e.torque_limit);
  o.number({.key = "torque_rate_limit",
            .doc = "The command changes no faster than this.",
            .unit = "N·m/s or N/s",
            .range = kPositive,
            .default_text = "none"},
           e.torque_rate_limit);
  o.number({.key = "soft_margin",
            .doc = "A spring-damper wall begins this far inside the position limits.",
            .unit = kPosition,
            .range = kNotNegative,
            .default_text = "0.1, but at most a tenth of the travel"},
           e.soft_margin);
  o.number({.key = "wall_stiffness",
            .doc = "Spring of that wall.",
            .unit = kStiffness,
            .range = kNotNegative},
           e.wall_stiffness);
  o.number({.key = "wall_damping",
            .doc = "Damper of that wall.",
            .unit = kDamping,
            .range = kNotNegative},
           e.wall_damping);
  o.number({.key = "temperature_warn_c",
            .doc = "Hotter than this is a warning.",
            .unit = "°C",
            .range = between(0, 150)},
           e.temperature_warn_c);
  o.number({.key = "temperature_limit_c",
            .doc = "Hotter than this is a fault.",
            .unit = "°C",
            .range = between(0, 150)},
           e.temperature_limit_c);
}

void describe_laws(OptionVisitor& o, JointEntry& e) {
  o.number({.key = "damping",
            .doc = "Law `float`: viscous damping.",
            .unit = kDamping,
            .range = kNotNegative},
           e.damping);
  o.number({.key = "hold_stiffness",
            .doc = "Law `hold`: spring to the pose at entry.",
            .unit = kStiffness,
            .range = kNotNegative},
           e.hold_stiffness);
  o.number({.key = "hold_damping",
            .doc = "Law `hold`: damper.",
            .unit = kDamping,
            .range = kNotNegative},
           e.hold_damping);
  o.number({.key = "stop_damping",
            .doc = "Damper of law `damp` and of every controlled stop.",
            .unit = kDamping,
            .range = kNotNegative},
           e.stop_damping);
  o.number({.key = "drive_damping",
            .doc = "Damping inside the drive while lowering and when encoders are not trusted.",
            .unit = kDamping,
            .range = kNotNegative},
           e.drive_damping);
  o.number({.key = "rotor_inertia",
            .doc = "The motor's rotor, reflected to the joint.",
            .unit = kInertia,
            .range = kNotNegative},
           e.rotor_inertia);
  o.number({.key = "coulomb_friction",
            .doc = "Friction that is compensated; 0: none.",
            .unit = kTorque,
            .range = kNotNegative},
           e.coulomb_friction);
  o.number({.key = "viscous_friction",
            .doc = "Viscous friction that is compensated.",
            .unit = kDamping,
            .range = kNotNegative},
           e.viscous_friction);
  o.number({.key = "friction_velocity",
            .doc = "Width of the smooth transition of Coulomb friction through rest.",
            .unit = kVelocity,
            .range = kPositive},
           e.friction_velocity);
}

void describe_joint(OptionVisitor& o, JointEntry& e, bool defaults) {
  e.place = o.here();
  if (!defaults) {
    o.text({.key = "name", .doc = "The joint's name in the URDF.", .required = true}, e.name);
  }
  o.text({.key = "bus", .doc = "Name of the bus its drive is on.", .required = true}, e.bus);
  o.integer({.key = "direction",
             .doc = "+1 or -1: sign of the drive's position at the joint.",
             .range = between(-1, 1)},
            e.direction);
  o.number({.key = "ratio",
            .doc = "Joint units for one radian of the drive's shaft: joint = direction * ratio * "
                   "drive + offset.",
            .unit = "rad/rad or m/rad",
            .range = kPositive},
           e.ratio);
  o.number({.key = "offset", .doc = "Joint position where the drive counts 0.", .unit = kPosition},
           e.offset);
  describe_limits(o, e);
  describe_laws(o, e);
  o.table({.key = "drive", .doc = "The drive that moves the joint.", .required = true},
          [&](OptionVisitor& t) { describe_drive(t, e.drive); });
  const auto simulation = [&](OptionVisitor& t) {
    const std::string_view same = "the joint's own";
    t.number({.key = "coulomb_friction",
              .doc = "Dry friction.",
              .unit = kTorque,
              .range = kNotNegative,
              .default_text = same},
             e.simulation.coulomb_friction);
    t.number({.key = "viscous_friction",
              .doc = "Viscous friction.",
              .unit = kDamping,
              .range = kNotNegative,
              .default_text = same},
             e.simulation.viscous_friction);
    t.number({.key = "rotor_inertia",
              .doc = "The rotor, reflected to the joint.",
              .unit = kInertia,
              .range = kNotNegative,
              .default_text = same},
             e.simulation.rotor_inertia);
  };
  o.table({.key = "simulation",
           .doc = "What the simulated arm adds to the URDF at this joint; the controller does not "
                  "know of it."},
          simulation);
}

void describe_control(OptionVisitor& o, ControlEntry& e) {
  o.text(
      {.key = "law",
       .doc = "What the arm does while active: float = gravity and Coriolis compensation, hold = "
              "float and a spring to the pose at entry, damp = float and the stop damping.",
       .choices = kLaws},
      e.law);
  o.flag({.key = "start_active", .doc = "Go to the law as soon as all drives are ready."},
         e.start_active);
  o.number({.key = "velocity_filter_hz",
            .doc = "Corner of the first-order low pass on measured velocity; 0: none.",
            .unit = "Hz",
            .range = between(0, 10'000)},
           e.velocity_filter_hz);
}

void describe_safety(OptionVisitor& o, SafetyEntry& e) {
  const Range seconds{0.0, 60.0, true};
  o.integer({.key = "silent_cycles",
             .doc = "A joint silent for as many cycles in a row is a fault.",
             .unit = "cycles",
             .range = between(1, 1000)},
            e.silent_cycles);
  o.integer({.key = "overrun_cycles",
             .doc = "As many overruns in a row are a fault.",
             .unit = "cycles",
             .range = between(1, 100'000)},
            e.overrun_cycles);
  o.number({.key = "start_ramp_s",
            .doc = "Torque authority rises from 0 to 1 in this time.",
            .unit = "s",
            .range = seconds},
           e.start_ramp_s);
  o.number({.key = "stop_rest_velocity",
            .doc = "Below it on every joint the arm is at rest.",
            .unit = kVelocity,
            .range = kPositive},
           e.stop_rest_velocity);
  o.number({.key = "stop_rest_s",
            .doc = "For as long, before a stop goes on to lowering.",
            .unit = "s",
            .range = seconds},
           e.stop_rest_s);
  o.number({.key = "stop_timeout_s",
            .doc = "A stop goes on to lowering after this, at rest or not.",
            .unit = "s",
            .range = seconds},
           e.stop_timeout_s);
  o.number({.key = "lower_s",
            .doc = "Torque authority falls from 1 to 0 in this time, drives damping.",
            .unit = "s",
            .range = seconds},
           e.lower_s);
  o.number({.key = "connect_timeout_s",
            .doc = "Every drive must be configured and report by then.",
            .unit = "s",
            .range = seconds},
           e.connect_timeout_s);
  o.number({.key = "enable_timeout_s",
            .doc = "Every drive must report enabled by then.",
            .unit = "s",
            .range = seconds},
           e.enable_timeout_s);
  o.number({.key = "start_velocity",
            .doc = "A start needs every joint slower than this.",
            .unit = kVelocity,
            .range = kPositive},
           e.start_velocity);
  o.number({.key = "encoder_jump",
            .doc = "A step in one cycle this far beyond what velocity allows is not trusted.",
            .unit = kPosition,
            .range = kPositive},
           e.encoder_jump);
}

void describe_simulation(OptionVisitor& o, SimulationEntry& e) {
  o.by_name(
      {.key = "pose",
       .doc = "Where the simulated arm starts; a joint that is not named starts at 0, or mid-way "
              "between its limits if 0 is not between them.",
       .unit = kPosition},
      e.pose);
  o.number({.key = "floor_z_m",
            .doc = "Height of a floor to touch.",
            .unit = "m",
            .range = between(-100, 100),
            .default_text = "no floor"},
           e.floor_z_m);
  o.number({.key = "reply_latency_us",
            .doc = "A simulated drive's time from the end of a command to the start of its reply.",
            .unit = "µs",
            .range = between(0, 10'000)},
           e.reply_latency_us);
}

}  // namespace

void describe(OptionVisitor& file, RobotFile& out) {
  file.table({.key = "robot", .doc = "The robot as a whole.", .required = true},
             [&](OptionVisitor& o) { describe_robot(o, out.robot); });
  file.table({.key = "realtime", .doc = "The thread that runs the cycle."},
             [&](OptionVisitor& o) { describe_realtime(o, out.realtime); });
  file.tables({.key = "bus", .doc = "One CAN bus; at most 8.", .required = true},
              [&](OptionVisitor& o) { describe_bus(o, out.buses.emplace_back()); });
  file.table(
      {.key = "defaults", .doc = "What tables that repeat fall back to."}, [&](OptionVisitor& o) {
        o.partial_table({.key = "joint",
                         .doc = "For every joint that does not say otherwise.",
                         .like = "[[joint]]"},
                        [&](OptionVisitor& t) { describe_joint(t, out.joint_defaults, true); });
      });
  file.tables(
      {.key = "joint",
       .doc = "One joint that moves: one entry for every joint of the URDF that is not fixed, "
              "locked or a mimic; at most 32.",
       .required = true},
      [&](OptionVisitor& o) {
        describe_joint(o, out.joints.emplace_back(out.joint_defaults), false);
      });
  file.table({.key = "control", .doc = "The controller."},
             [&](OptionVisitor& o) { describe_control(o, out.control); });
  file.table({.key = "safety", .doc = "When and how the arm stops."},
             [&](OptionVisitor& o) { describe_safety(o, out.safety); });
  file.table({.key = "simulation", .doc = "The simulated arm; a real one ignores it."},
             [&](OptionVisitor& o) { describe_simulation(o, out.simulation); });
}

}  // namespace geodesic::config
