// Holds rows of golden vectors against the MyActuator codec and simulated drive; see vectors.hpp.
#include "tests/drivers/myactuator/vectors.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <utility>

#include "drivers/myactuator/codec.hpp"
#include "drivers/myactuator/family.hpp"
#include "drivers/myactuator/settings.hpp"
#include "drivers/myactuator/simulated.hpp"

namespace geodesic::drivers::test {

namespace {

using namespace myactuator;  // NOLINT(google-build-using-namespace): the codec under test

struct BareRequest {
  const char* op;
  Command command;
};

constexpr std::array kBareRequests = {
    BareRequest{"read_status1", Command::kStatus1},
    BareRequest{"read_status2", Command::kStatus2},
    BareRequest{"read_status3", Command::kStatus3},
    BareRequest{"read_angle", Command::kAngle},
    BareRequest{"shutdown", Command::kShutdown},
    BareRequest{"stop", Command::kStop},
    BareRequest{"release_brake", Command::kReleaseBrake},
    BareRequest{"zero", Command::kZeroHere},
    BareRequest{"reset", Command::kReset},
};

struct MotionField {
  const char* key;
  Field field;
  double MotionCommand::*value;
};

constexpr std::array kMotionFields = {
    MotionField{"p_des", motion::kPosition, &MotionCommand::position_rad},
    MotionField{"v_des", motion::kVelocity, &MotionCommand::velocity_rad_s},
    MotionField{"kp", motion::kStiffness, &MotionCommand::stiffness_nm_rad},
    MotionField{"kd", motion::kDamping, &MotionCommand::damping_nm_s_rad},
    MotionField{"t_ff", motion::kTorque, &MotionCommand::torque_nm},
};

class Checker {
 public:
  explicit Checker(const Row& row) : row_(row), id_(static_cast<std::uint32_t>(row.number("id"))) {
    options_.family = "myactuator";
    options_.id = id_;
    options_.velocity_range_rad_s = 100.0;
    options_.torque_range_nm = 1e6;
    options_.settings.values[kTorqueConstant] = 1.0;
    if (row.has("pmax")) {
      options_.settings.values[kMode] = 1.0;
      options_.position_range_rad = row.number("pmax");
      options_.velocity_range_rad_s = row.number("vmax");
      options_.torque_range_nm = row.number("tmax");
    }
    if (row.has("kpmax")) {
      options_.settings.values[kStiffnessRange] = row.number("kpmax");
      options_.settings.values[kDampingRange] = row.number("kdmax");
    }
  }

  std::vector<std::string> run() {
    if (row_.description.rfind("DISAGREEMENT", 0) == 0) {
      return {};  // what somebody else sends: documentation
    }
    const std::string op = row_.text("op").value_or("");
    if (row_.command) {
      check_command(op);
    } else {
      check_reply(op);
    }
    if (!decode(row_.frame, options_)) {
      problem("cannot be told in words");
    }
    return problems_;
  }

 private:
  void problem(std::string text) { problems_.push_back(std::move(text)); }

  static std::string words(const Frame& frame) {
    std::string text = fmt::format("{:X}#", frame.id);
    for (const std::uint8_t byte : frame.payload()) {
      text += fmt::format("{:02X}", byte);
    }
    return text;
  }

  void expect_frame(const std::optional<Frame>& encoded, const char* who = "") {
    if (!encoded || *encoded != row_.frame) {
      problem(fmt::format("{}encoded as {}, the vector is {}", who,
                          encoded ? words(*encoded) : std::string("nothing"), words(row_.frame)));
    }
  }

  /// `range`: computed in float32 there, whose last digit is as coarse as its range.
  void expect_near(const char* what, double decoded, double expected, double range = 1.0) {
    if (!(std::abs(decoded - expected) <= 1e-6 * std::abs(expected) + 1e-7 * range)) {
      problem(fmt::format("{} decoded as {:.9g}, the vector says {:.9g}", what, decoded, expected));
    }
  }

  void check_command(const std::string& op) {
    for (const BareRequest& known : kBareRequests) {
      if (op == known.op) {
        expect_frame(encode_request(id_, known.command));
        if (command_of(row_.frame) != static_cast<std::uint8_t>(known.command)) {
          problem("was decoded as another request");
        }
        return;
      }
    }
    if (op == "torque") {
      expect_frame(encode_torque(id_, row_.number("current_requested")));
      expect_near("current", decode_torque(row_.frame).value_or(NAN),
                  row_.number("current_on_wire"));
      Simulated drive(options_);
      std::array<Frame, SimulatedDrive::kMaxReplies> out;
      drive.receive(row_.frame, 0, out);
      expect_near("simulated torque", drive.torque_nm(0), row_.number("current_on_wire"));
    } else if (op == "speed") {
      expect_frame(encode_speed(id_, row_.number("speed")));
      expect_near("speed", decode_speed(row_.frame).value_or(NAN), row_.number("speed_on_wire"));
    } else if (op == "position") {
      expect_frame(encode_position(id_, {row_.number("position"), row_.number("max_speed")}));
      const auto decoded = decode_position(row_.frame).value_or(PositionCommand{});
      expect_near("position", decoded.angle_deg, row_.number("position_on_wire"));
      expect_near("max_speed", decoded.speed_limit_deg_s, row_.number("max_speed"));
    } else if (op == "timeout") {
      const auto ms = static_cast<std::uint32_t>(row_.number("ms"));
      expect_frame(encode_value(id_, Command::kWatchdog, ms));
      expect_near("ms", decode_value(row_.frame), ms);
    } else if (op == "motion") {
      check_motion();
    } else {
      problem("op=" + op + " is not known");
    }
  }

  void check_motion() {
    const Ranges ranges = ranges_of(options_);
    MotionCommand requested;
    for (const MotionField& field : kMotionFields) {
      requested.*field.value = row_.number(field.key);
    }
    const auto encoded = encode_motion(id_, requested, ranges);
    const auto decoded = decode_motion(row_.frame, ranges);
    if (!encoded || !decoded || encoded->id != row_.frame.id) {
      problem("was refused, or goes elsewhere");
      return;
    }
    const MotionCommand top{ranges.position_rad, ranges.velocity_rad_s, ranges.stiffness_nm_rad,
                            ranges.damping_nm_s_rad, ranges.torque_nm};
    for (const MotionField& field : kMotionFields) {
      const std::uint32_t ours = extract(*encoded, field.field);
      const std::uint32_t theirs = extract(row_.frame, field.field);
      if (std::max(ours, theirs) - std::min(ours, theirs) > 1) {
        problem(fmt::format("{} = {} encoded as {:X}, the vector has {:X}", field.key,
                            requested.*field.value, ours, theirs));
      }
      const double code =
          2.0 * top.*field.value / static_cast<double>((1U << field.field.bits) - 1U);
      const double wanted =
          std::clamp(requested.*field.value, -(top.*field.value), top.*field.value);
      if (!(std::abs((*decoded).*field.value - wanted) <= 1.001 * code)) {
        problem(fmt::format("{} decoded as {}, requested was {}", field.key,
                            (*decoded).*field.value, wanted));
      }
    }
    expect_frame(encode_motion(id_, *decoded, ranges), "decoded again, ");
    Simulated drive(options_);
    std::array<Frame, SimulatedDrive::kMaxReplies> out;
    drive.receive(row_.frame, 0, out);
    const double made = decoded->stiffness_nm_rad * decoded->position_rad +
                        decoded->damping_nm_s_rad * decoded->velocity_rad_s + decoded->torque_nm;
    const double limited = std::clamp(made, -ranges.torque_nm, ranges.torque_nm);
    if (!(std::abs(drive.torque_nm(0) - limited) <= 1e-5 * std::max(24.0, std::abs(made)))) {
      problem(fmt::format("the simulated drive makes {} N·m of it, not {}", drive.torque_nm(0),
                          limited));
    }
  }

  void check_reply(const std::string& op) {
    if (op == "torque_reply" || op == "status2") {
      const auto reply = decode_loop_reply(row_.frame).value_or(LoopReply{});
      expect_near("temperature", reply.temperature_c, row_.number("temperature"));
      expect_near("current", reply.current_a, row_.number("current"));
      expect_near("speed_dps", reply.speed_deg_s, row_.number("speed_dps"));
      expect_near("angle_deg", reply.angle_deg, row_.number("angle_deg"));
      check_simulated_loop_reply(reply);
    } else if (op == "status1") {
      const auto status = decode_status1(row_.frame).value_or(Status1{});
      expect_near("temperature", status.motor_c, row_.number("temperature"));
      expect_near("mos_temperature", status.mosfet_c, row_.number("mos_temperature"));
      expect_near("brake_released", status.brake_released ? 1.0 : 0.0,
                  row_.number("brake_released"));
      expect_near("voltage", status.voltage_v, row_.number("voltage"));
      expect_near("error", status.errors, row_.number("error"));
    } else if (op == "status3") {
      const auto status = decode_status3(row_.frame).value_or(Status3{});
      expect_near("temperature", status.temperature_c, row_.number("temperature"));
      expect_near("ia", status.current_a[0], row_.number("ia"));
      expect_near("ib", status.current_a[1], row_.number("ib"));
      expect_near("ic", status.current_a[2], row_.number("ic"));
    } else if (op == "angle") {
      const double angle = decode_angle(row_.frame).value_or(NAN);
      expect_near("angle_deg", angle, row_.number("angle_deg"));
      Simulated drive(options_);
      drive.set_shaft((angle + std::copysign(1e-3, angle)) * kDegree, 0.0);
      std::array<Frame, SimulatedDrive::kMaxReplies> out;
      drive.receive(encode_request(id_, Command::kAngle), 0, out);
      expect_frame(out[0], "by the simulated drive ");
    } else if (op == "motion_reply") {
      check_motion_reply();
    } else {
      problem("op=" + op + " is not known");
    }
  }

  /// The simulated drive, brought to what the row reports, reports it so.
  void check_simulated_loop_reply(const LoopReply& reply) {
    Simulated drive(options_);
    std::array<Frame, SimulatedDrive::kMaxReplies> out;
    const auto away = [](double value) { return value + std::copysign(1e-3, value); };
    drive.set_shaft(away(reply.angle_deg) * kDegree, away(reply.speed_deg_s) * kDegree);
    drive.receive(*encode_torque(id_, reply.current_a), 0, out);
    if (row_.frame.data[0] != static_cast<std::uint8_t>(Command::kTorque)) {
      drive.receive(encode_request(id_, static_cast<Command>(row_.frame.data[0])), 0, out);
    }
    Frame told = out[0];
    told.data[1] = row_.frame.data[1];  // at 127 °C it would not run
    expect_frame(told, "by the simulated drive ");
  }

  void check_motion_reply() {
    const Ranges ranges = ranges_of(options_);
    const auto reply = decode_motion_reply(row_.frame, ranges).value_or(MotionReply{});
    if (row_.frame.id != kMotionReplyId + id_ || reply.motor != id_) {
      problem("is of another motor");
    }
    expect_near("position", reply.position_rad, row_.number("position"), ranges.position_rad);
    expect_near("velocity", reply.velocity_rad_s, row_.number("velocity"), ranges.velocity_rad_s);
    expect_near("torque", reply.torque_nm, row_.number("torque"), ranges.torque_nm);
    Simulated drive(options_);
    std::array<Frame, SimulatedDrive::kMaxReplies> out;
    drive.set_shaft(reply.position_rad, reply.velocity_rad_s);
    drive.receive(*encode_motion(id_, {.torque_nm = reply.torque_nm}, ranges), 0, out);
    for (const Field field :
         {motion::kReplyPosition, motion::kReplyVelocity, motion::kReplyTorque}) {
      const std::uint32_t ours = extract(out[0], field);
      const std::uint32_t theirs = extract(row_.frame, field);
      if (std::max(ours, theirs) - std::min(ours, theirs) > 1 || out[0].id != row_.frame.id) {
        problem(fmt::format("the simulated drive reports {}", words(out[0])));
      }
    }
  }

  const Row& row_;
  std::uint32_t id_;
  DriveOptions options_;
  std::vector<std::string> problems_;
};

}  // namespace

std::vector<std::string> check_myactuator_row(const Row& row) {
  return Checker(row).run();
}

}  // namespace geodesic::drivers::test
