// Every option of a robot file, declared once: key, type, unit, range, default, meaning, and
// whether a running daemon takes a change of it. Those of a joint are in joint_options.cpp.
#include "config/robot_file.hpp"
#include "config/joint_options.hpp"
#include "config/watch_options.hpp"

namespace geodesic::config {
namespace {

constexpr std::array<std::string_view, 3> kLaws = {"float", "hold", "damp"};

void describe_robot(OptionVisitor& o, RobotEntry& e) {
  o.text({.key = "name",
          .doc = "How logs and reports call the robot.",
          .required = true,
          .live = kRestart},
         e.name);
  o.text({.key = "urdf", .doc = "The robot's URDF file.", .required = true, .live = kRestart},
         e.urdf);
  o.vector({.key = "gravity",
            .doc = "Acceleration of free fall in the frame of the URDF's root link.",
            .unit = "m/s²",
            .range = between(-30.0, 30.0),
            .live = kLive},
           e.gravity);
  o.number({.key = "rate_hz",
            .doc = "Cycles a second.",
            .unit = "Hz",
            .range = between(50, 4000),
            .live = kRestart},
           e.rate_hz);
  o.text({.key = "tool_link",
          .doc = "The link whose pose reports speak of.",
          .default_text = "none",
          .live = kRestart},
         e.tool_link);
  o.by_name({.key = "lock",
             .doc = "Joints that do not move and have no drive, each with its fixed position: "
                    "`lock = { finger_joint1 = 0.0 }`.",
             .unit = kPosition,
             .live = kRestart},
            e.lock);
  o.text({.key = "payload",
          .doc = "Name of the [[payload]] that the arm carries, or `none`.",
          .live = kLive},
         e.payload);
}

void describe_realtime(OptionVisitor& o, RealtimeEntry& e) {
  o.integer({.key = "priority",
             .doc = "SCHED_FIFO priority of the cycle's thread.",
             .range = between(1, 98),
             .live = kRestart},
            e.priority);
  o.integers({.key = "cpus",
              .doc = "Processors the thread may run on; empty: wherever the kernel likes.",
              .range = between(0, 1023),
              .live = kRestart},
             e.cpus);
  o.number({.key = "receive_deadline",
            .doc = "Part of the period after which a missing reply counts as lost.",
            .range = between(0.1, 0.98),
            .live = kRestart},
           e.receive_deadline);
}

void describe_bus(OptionVisitor& o, BusEntry& e) {
  e.place = o.here();
  o.text({.key = "name", .doc = "How joints refer to the bus.", .required = true, .live = kRestart},
         e.name);
  o.text(
      {.key = "interface",
       .doc = "`can0`, `vcan0`; `usb:1-2.3`, the adapter in that USB socket; `serial:NUMBER`, the "
              "adapter of that number (with `/1` behind either: its second channel); or "
              "`unix:PATH` for a socket bus.",
       .required = true,
       .live = kRestart},
      e.interface);
  o.flag({.key = "fd", .doc = "Frames are CAN FD with bit-rate switch.", .live = kRestart}, e.fd);
  o.integer({.key = "bit_rate",
             .doc = "Nominal bit rate.",
             .unit = "bit/s",
             .range = between(10'000, 1'000'000),
             .live = kRestart},
            e.bit_rate);
  o.integer({.key = "data_bit_rate",
             .doc = "Bit rate of the data phase; with `fd = true` only.",
             .unit = "bit/s",
             .range = between(10'000, 12'000'000),
             .live = kRestart},
            e.data_bit_rate);
  o.flag({.key = "bring_up",
          .doc = "Set the interface up as these options say, where geodesicd may (CAP_NET_ADMIN), "
                 "and empty its queue when the bus stands still. Otherwise it is only checked, and "
                 "refused with the `ip link` line that helps.",
          .live = kRestart},
         e.bring_up);
  o.number({.key = "sample_point",
            .doc = "Where a bit is sampled, as part of its length.",
            .range = between(0.5, 0.95),
            .default_text = "the kernel's choice",
            .live = kRestart},
           e.sample_point);
  o.number({.key = "data_sample_point",
            .doc = "The same in the data phase; with `fd = true` only.",
            .range = between(0.5, 0.95),
            .default_text = "the kernel's choice",
            .live = kRestart},
           e.data_sample_point);
  o.integer(
      {.key = "restart_ms",
       .doc = "A controller that left the bus (bus-off) comes back after this long; 0: when a "
              "law is asked for. Checked if given.",
       .unit = "ms",
       .range = between(0, 10'000),
       .live = kRestart},
      e.restart_ms);
  o.integer({.key = "queue",
             .doc = "Frames that the interface's transmit queue holds. Checked if given.",
             .range = between(1, 4096),
             .live = kRestart},
            e.queue);
}

void describe_control(OptionVisitor& o, ControlEntry& e) {
  o.text(
      {.key = "law",
       .doc = "What the arm does while active: float = gravity and Coriolis compensation, hold = "
              "float and a spring to the pose at entry, damp = float and the stop damping.",
       .choices = kLaws,
       .live = kRestart},
      e.law);
  o.flag({.key = "start_active",
          .doc = "Go to the law as soon as all drives are ready.",
          .live = kRestart},
         e.start_active);
  o.number({.key = "velocity_filter_hz",
            .doc = "Corner of the first-order low pass on measured velocity; 0: none.",
            .unit = "Hz",
            .range = between(0, 10'000),
            .live = kLive},
           e.velocity_filter_hz);
  o.number(
      {.key = "coriolis",
       .doc = "Share of the Coriolis torque that is compensated, beside gravity. 1: left alone, "
              "joints keep their velocities; 0: the arm moves along geodesics of its "
              "kinetic-energy metric, as a weightless body would.",
       .range = between(0, 1),
       .live = kLive},
      e.coriolis);
  o.number({.key = "retune_s",
            .doc = "When options change while the arm runs, torque goes over to them in this time.",
            .unit = "s",
            .range = between(0.01, 60),
            .live = kLive},
           e.retune_s);
  o.text(
      {.key = "compiled",
       .doc = "The model's functions as `geodesic compile` has built them for this robot, beside "
              "this file; refused at the start if they are another robot's or differ from the "
              "model.",
       .default_text = "none",
       .live = kRestart},
      e.compiled);
}

constexpr std::array<std::string_view, 2> kOtherArm = {"stop", "carry_on"};

void describe_safety(OptionVisitor& o, SafetyEntry& e) {
  const Range seconds{0.0, 60.0, true};
  o.integer({.key = "carry_on_cycles",
             .doc = "A joint that misses replies is predicted to move on for as many cycles.",
             .unit = "cycles",
             .range = between(1, 1000),
             .live = kLive},
            e.carry_on_cycles);
  o.integer({.key = "damp_cycles",
             .doc = "From as many missing replies in a row on, the joint's drive damps and its law "
                    "fades to gravity compensation; more than carry_on_cycles.",
             .unit = "cycles",
             .range = between(1, 1000),
             .live = kLive},
            e.damp_cycles);
  o.integer({.key = "silent_cycles",
             .doc = "A joint silent for as many cycles in a row is a fault; damp_cycles or more.",
             .unit = "cycles",
             .range = between(1, 1000),
             .live = kLive},
            e.silent_cycles);
  o.integer({.key = "overrun_cycles",
             .doc = "As many overruns in a row are a fault.",
             .unit = "cycles",
             .range = between(1, 100'000),
             .live = kLive},
            e.overrun_cycles);
  o.number({.key = "start_ramp_s",
            .doc = "Torque authority rises from 0 to 1 in this time.",
            .unit = "s",
            .range = seconds,
            .live = kLive},
           e.start_ramp_s);
  o.number({.key = "stop_rest_velocity",
            .doc = "Below it on every joint the arm is at rest.",
            .unit = kVelocity,
            .range = kPositive,
            .live = kLive},
           e.stop_rest_velocity);
  o.number({.key = "stop_rest_s",
            .doc = "For as long, before a stop goes on to lowering.",
            .unit = "s",
            .range = seconds,
            .live = kLive},
           e.stop_rest_s);
  o.number({.key = "stop_timeout_s",
            .doc = "A stop goes on to lowering after this, at rest or not.",
            .unit = "s",
            .range = seconds,
            .live = kLive},
           e.stop_timeout_s);
  o.number({.key = "lower_s",
            .doc = "Torque authority falls from 1 to 0 in this time, drives damping.",
            .unit = "s",
            .range = seconds,
            .live = kLive},
           e.lower_s);
  o.number({.key = "settle_timeout_s",
            .doc = "Then drives damp on until the arm rests, but no longer than this.",
            .unit = "s",
            .range = seconds,
            .live = kLive},
           e.settle_timeout_s);
  o.text({.key = "other_arm",
          .doc = "When one arm has a fault, the others: stop = each comes to its own controlled "
                 "stop, carry_on = go on.",
          .choices = kOtherArm,
          .live = kLive},
         e.other_arm);
  o.number({.key = "connect_timeout_s",
            .doc = "Every drive must be configured and report by then.",
            .unit = "s",
            .range = seconds,
            .live = kLive},
           e.connect_timeout_s);
  o.number({.key = "enable_timeout_s",
            .doc = "Every drive must report enabled by then.",
            .unit = "s",
            .range = seconds,
            .live = kLive},
           e.enable_timeout_s);
  o.number({.key = "start_velocity",
            .doc = "A start needs every joint slower than this.",
            .unit = kVelocity,
            .range = kPositive,
            .live = kLive},
           e.start_velocity);
  o.number({.key = "encoder_jump",
            .doc = "A step in one cycle this far beyond what velocity allows is not trusted.",
            .unit = kPosition,
            .range = kPositive,
            .live = kLive},
           e.encoder_jump);
  o.number({.key = "encoder_stuck",
            .doc = "The way that velocity says while the position stands still: not trusted.",
            .unit = kPosition,
            .range = kPositive,
            .live = kLive},
           e.encoder_stuck);
}

void describe_payload(OptionVisitor& o, PayloadEntry& e) {
  e.place = o.here();
  o.text({.key = "name",
          .doc = "How `[robot] payload` and `geodesic tune` call it.",
          .required = true,
          .live = kLive},
         e.name);
  o.number({.key = "mass",
            .doc = "Its mass.",
            .unit = "kg",
            .range = {0.0, 200.0, true},
            .required = true,
            .live = kLive},
           e.mass);
  o.vector({.key = "com",
            .doc = "Its centre of mass in the frame of the link that holds it.",
            .unit = "m",
            .range = between(-10, 10),
            .live = kLive},
           e.com);
  o.vector({.key = "inertia",
            .doc = "`[ixx, iyy, izz]` about its centre of mass, axes of the link; zero: a point.",
            .unit = "kg·m²",
            .range = between(0, 1000),
            .live = kLive},
           e.inertia);
  o.vector({.key = "products",
            .doc = "`[ixy, ixz, iyz]`, as a URDF counts them.",
            .unit = "kg·m²",
            .range = between(-1000, 1000),
            .live = kLive},
           e.products);
  o.text({.key = "link",
          .doc = "The link that holds it.",
          .default_text = "`tool_link`",
          .live = kLive},
         e.link);
}

void describe_simulation(OptionVisitor& o, SimulationEntry& e) {
  o.text({.key = "payload",
          .doc = "The [[payload]] that the simulated arm really carries, or `none`.",
          .live = kElsewhere},
         e.payload);
  o.by_name(
      {.key = "pose",
       .doc = "Where the simulated arm starts; a joint that is not named starts at 0, or mid-way "
              "between its limits if 0 is not between them.",
       .unit = kPosition,
       .live = kElsewhere},
      e.pose);
  o.number({.key = "floor_z_m",
            .doc = "Height of a floor to touch.",
            .unit = "m",
            .range = between(-100, 100),
            .default_text = "no floor",
            .live = kElsewhere},
           e.floor_z_m);
  o.number({.key = "reply_latency_us",
            .doc = "A simulated drive's time from the end of a command to the start of its reply.",
            .unit = "µs",
            .range = between(0, 10'000),
            .live = kElsewhere},
           e.reply_latency_us);
}

}  // namespace

void describe(OptionVisitor& file, RobotFile& out) {
  file.table({.key = "robot", .doc = "The robot as a whole.", .required = true},
             [&](OptionVisitor& o) { describe_robot(o, out.robot); });
  file.table({.key = "realtime", .doc = "The thread that runs the cycle."},
             [&](OptionVisitor& o) { describe_realtime(o, out.realtime); });
  file.tables({.key = "bus", .doc = "One CAN bus; at most 8.", .required = true, .live = kRestart},
              out.buses.size(), [&](OptionVisitor& o, std::size_t i) {
                describe_bus(o, i < out.buses.size() ? out.buses[i] : out.buses.emplace_back());
              });
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
       .required = true,
       .live = kRestart},
      out.joints.size(), [&](OptionVisitor& o, std::size_t i) {
        const bool there = i < out.joints.size();
        describe_joint(o, there ? out.joints[i] : out.joints.emplace_back(out.joint_defaults),
                       false);
      });
  file.tables({.key = "payload",
               .doc = "Something the arm may carry, rigidly held by a link; at most 64.",
               .live = kLive},
              out.payloads.size(), [&](OptionVisitor& o, std::size_t i) {
                const bool there = i < out.payloads.size();
                describe_payload(o, there ? out.payloads[i] : out.payloads.emplace_back());
              });
  file.table({.key = "control", .doc = "The controller."},
             [&](OptionVisitor& o) { describe_control(o, out.control); });
  file.table({.key = "safety", .doc = "When and how the arm stops."},
             [&](OptionVisitor& o) { describe_safety(o, out.safety); });
  file.table({.key = "contact", .doc = "When something pushes the arm; see `contact_torque`."},
             [&](OptionVisitor& o) { describe_contact(o, out.contact); });
  file.table({.key = "vibration", .doc = "Limit cycles of a joint; see `vibration_velocity`."},
             [&](OptionVisitor& o) { describe_vibration(o, out.vibration); });
  file.table({.key = "simulation", .doc = "The simulated arm; a real one ignores it."},
             [&](OptionVisitor& o) { describe_simulation(o, out.simulation); });
}

}  // namespace geodesic::config
