// Holds rows of golden vectors against the CubeMars codec and simulated drive; see vectors.hpp.
#include "tests/drivers/cubemars/vectors.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <utility>

#include "drivers/cubemars/codec.hpp"
#include "drivers/cubemars/family.hpp"
#include "drivers/cubemars/settings.hpp"
#include "drivers/cubemars/simulated.hpp"

namespace geodesic::drivers::test {

namespace {

using namespace cubemars;  // NOLINT(google-build-using-namespace): the codec under test

struct MitField {
  const char* key;
  Field field;
  double MitCommand::*value;
};

constexpr std::array kMitFields = {
    MitField{"p_des", mit::kPosition, &MitCommand::position_rad},
    MitField{"v_des", mit::kVelocity, &MitCommand::velocity_rad_s},
    MitField{"kp", mit::kStiffness, &MitCommand::stiffness_nm_rad},
    MitField{"kd", mit::kDamping, &MitCommand::damping_nm_s_rad},
    MitField{"t_ff", mit::kTorque, &MitCommand::torque_nm},
};

struct ServoOperation {
  const char* op;
  Function function;
  const char* key;
};

constexpr std::array kServoOperations = {
    ServoOperation{"servo_current", Function::kCurrent, "current"},
    ServoOperation{"servo_brake", Function::kBrakeCurrent, "brake_current"},
    ServoOperation{"servo_rpm", Function::kSpeed, "erpm"},
    ServoOperation{"servo_pos", Function::kPosition, "position_deg"},
    ServoOperation{"servo_duty", Function::kDuty, "duty"},
    ServoOperation{"servo_origin", Function::kOrigin, "origin"},
};

class Checker {
 public:
  explicit Checker(const Row& row) : row_(row) {}

  std::vector<std::string> run() {
    if (row_.description.rfind("DISAGREEMENT", 0) == 0) {
      return {};  // what somebody else sends: documentation
    }
    if (row_.text("mode") == "mit") {
      check_mit();
    } else if (const auto op = row_.text("op")) {
      check_operation(*op);
    } else if (!row_.command && row_.has("position")) {
      check_reply();
    } else {
      problem("neither mode=mit, nor op=, nor a reply: nothing to hold it against");
    }
    return problems_;
  }

 private:
  void problem(std::string text) { problems_.push_back(std::move(text)); }

  static std::string words(const Frame& frame) {
    std::string text = fmt::format("{:X}{}#", frame.id, frame.extended ? " ext" : "");
    for (const std::uint8_t byte : frame.payload()) {
      text += fmt::format("{:02X}", byte);
    }
    return text;
  }

  void expect_frame(const std::optional<Frame>& encoded) {
    if (!encoded || *encoded != row_.frame) {
      problem(fmt::format("encoded as {}, the vector is {}",
                          encoded ? words(*encoded) : std::string("nothing"), words(row_.frame)));
    }
  }

  void expect_near(const std::string& what, double decoded, double expected, double code = 0.0) {
    if (!(std::abs(decoded - expected) <= 1e-6 * std::abs(expected) + 1e-12 + 1.001 * code)) {
      problem(fmt::format("{} decoded as {:.9g}, the vector says {:.9g}", what, decoded, expected));
    }
  }

  /// tmax and vmax as the row says; position as its source has it.
  DriveOptions options(std::uint32_t id, bool servo) const {
    DriveOptions options;
    options.family = "cubemars";
    options.id = id;
    options.reply_id = row_.command ? 0 : row_.frame.id;
    options.position_range_rad = row_.has("pmax") ? row_.number("pmax") : 12.5;
    options.velocity_range_rad_s = row_.has("vmax") ? row_.number("vmax") : 50.0;
    options.torque_range_nm = row_.has("tmax") ? row_.number("tmax") : 100.0;
    options.settings.values[kMode] = servo ? 1.0 : 0.0;
    options.settings.values[kGearRatio] = 9.0;
    options.settings.values[kTorqueConstant] = 0.1;
    return options;
  }

  static Ranges ranges(const DriveOptions& options) {
    return {options.position_range_rad, options.velocity_range_rad_s, options.torque_range_nm};
  }

  void expect_words(const DriveOptions& options) {
    if (!decode(row_.frame, options)) {
      problem("cannot be told in words");
    }
  }

  void check_mit() {
    const DriveOptions drive = options(row_.frame.id, false);
    MitCommand requested;
    for (const MitField& field : kMitFields) {
      requested.*field.value = row_.number(field.key);
    }
    const auto encoded = encode_mit(row_.frame.id, requested, ranges(drive));
    if (!encoded || row_.frame.length != 8 || row_.frame.extended || row_.frame.fd) {
      problem("was refused, or is no classic frame of 8 bytes");
      return;
    }
    for (const MitField& field : kMitFields) {
      const std::uint32_t ours = extract(*encoded, field.field);
      const std::uint32_t theirs = extract(row_.frame, field.field);
      if (std::max(ours, theirs) - std::min(ours, theirs) > 1) {
        problem(fmt::format("{} = {} encoded as {:X}, the vector has {:X}", field.key,
                            requested.*field.value, ours, theirs));
      }
    }
    const auto decoded = decode_mit(row_.frame, ranges(drive));
    if (!decoded) {
      problem("was not decoded as an MIT command");
      return;
    }
    const std::array spans = {drive.position_range_rad, drive.velocity_range_rad_s,
                              mit::kMaxStiffness, mit::kMaxDamping, drive.torque_range_nm};
    constexpr std::array kDriveKeys = {"drive_p", "drive_v", "drive_kp", "drive_kd", "drive_t"};
    for (std::size_t i = 0; i < kMitFields.size(); ++i) {
      // The drive's side was computed in float32, whose last digit is as coarse as its range.
      expect_near(kDriveKeys[i], (*decoded).*kMitFields[i].value, row_.number(kDriveKeys[i]),
                  1e-7 * spans[i]);
    }
    const auto again = encode_mit(row_.frame.id, *decoded, ranges(drive));
    if (!again || again->data != row_.frame.data) {
      problem("decoded and encoded again, it is another frame");
    }
    check_simulated_torque(drive);
    expect_words(drive);
  }

  /// The simulated drive makes the torque that the row's drive side decoded.
  void check_simulated_torque(const DriveOptions& drive) {
    Simulated simulated(drive);
    std::array<Frame, SimulatedDrive::kMaxReplies> reply;
    simulated.receive(encode_special(drive.id, Special::kEnter), 0, reply);
    simulated.receive(row_.frame, 1000, reply);
    const double t = row_.number("drive_t") + row_.number("drive_kp") * row_.number("drive_p") +
                     row_.number("drive_kd") * row_.number("drive_v");
    const double limit = drive.torque_range_nm;
    const double made = simulated.torque_nm(1000);
    const double expected = std::clamp(t, -limit, limit);
    if (!(std::abs(made - expected) <= 1e-5 * std::max(limit, std::abs(t)))) {
      problem(fmt::format("the simulated drive makes {} N·m of it, not {}", made, expected));
    }
  }

  void check_reply() {
    const auto id = static_cast<std::uint32_t>(row_.number("id"));
    const DriveOptions drive = options(id, false);
    const auto decoded = decode_reply(row_.frame, ranges(drive));
    if (!decoded) {
      problem("was not decoded as a reply");
      return;
    }
    // What the open firmware was told to report, where the others say what a host decodes.
    const bool requested = row_.has("firmware");
    const double step = requested ? 1.0 : 0.0;
    const double torque = row_.number("torque");
    const bool wraps = std::abs(torque) > drive.torque_range_nm;  // its encoder does not clamp
    expect_near("id", decoded->motor, id);
    expect_near("position", decoded->position_rad, row_.number("position"),
                step * 2.0 * drive.position_range_rad / 65535.0);
    expect_near("velocity", decoded->velocity_rad_s, row_.number("velocity"),
                (wraps ? 2.0 : step) * 2.0 * drive.velocity_range_rad_s / 4095.0);
    if (!wraps) {
      expect_near("torque", decoded->torque_nm, torque,
                  step * 2.0 * drive.torque_range_nm / 4095.0);
    }
    if (row_.has("temp_raw")) {
      expect_near("temperature", decoded->temperature_raw.value_or(0), row_.number("temp_raw"));
      expect_near("°C", decoded->temperature_raw.value_or(0) + Facts(drive).temperature_offset_c,
                  row_.number("temp_c_vendor"));
      expect_near("error", decoded->error, row_.number("error"));
    }
    if (row_.has("vbus")) {
      expect_near("vbus", decoded->voltage_v.value_or(0.0), row_.number("vbus"), 40.0 / 255.0);
    }
    if (!wraps) {
      check_simulated_reply(drive, *decoded);
    }
    expect_words(drive);
  }

  /// The simulated drive, brought to what the row reports, reports it so.
  void check_simulated_reply(const DriveOptions& drive, const MitReply& wanted) {
    Simulated simulated(drive);
    std::array<Frame, SimulatedDrive::kMaxReplies> reply;
    const double half_code = 1e-6;
    simulated.set_reply_bytes(row_.frame.length);
    simulated.set_shaft(wanted.position_rad + half_code, wanted.velocity_rad_s + half_code);
    simulated.receive(encode_special(drive.id, Special::kEnter), 0, reply);
    const auto command = encode_mit(drive.id, {.torque_nm = wanted.torque_nm}, ranges(drive));
    simulated.receive(*command, 0, reply);
    simulated.receive(*command, 0, reply);
    const Frame& told = reply[0];
    if (told.id != row_.frame.id || told.length != row_.frame.length ||
        told.data[0] != row_.frame.data[0]) {
      problem(fmt::format("the simulated drive reports {}", words(told)));
    }
    for (const Field field : {reply::kPosition, reply::kVelocity, reply::kTorque}) {
      const std::uint32_t ours = extract(told, field);
      const std::uint32_t theirs = extract(row_.frame, field);
      if (std::max(ours, theirs) - std::min(ours, theirs) > 1) {
        problem(fmt::format("the simulated drive reports {:X} in the field at bit {}", ours,
                            field.first));
      }
    }
  }

  void check_operation(const std::string& op) {
    const auto id = static_cast<std::uint32_t>(row_.number("id"));
    if (op == "enter") {
      check_special(id, Special::kEnter);
    } else if (op == "exit") {
      check_special(id, Special::kExit);
    } else if (op == "zero") {
      check_special(id, Special::kSetZero);
    } else if (op == "servo_posspd") {
      const PositionSpeedCommand command{row_.number("position_deg"), row_.number("erpm"),
                                         row_.number("acc")};
      expect_frame(encode_position_speed(id, command));
      const auto decoded = decode_position_speed(row_.frame).value_or(PositionSpeedCommand{});
      expect_near("position_deg", decoded.position_deg, command.position_deg);
      expect_near("erpm", decoded.speed_erpm, command.speed_erpm);
      expect_near("acc", decoded.acceleration_erpm_s, command.acceleration_erpm_s);
      expect_words(options(id, true));
    } else if (op == "servo_status") {
      check_status(id);
    } else {
      check_servo(op, id);
    }
  }

  void check_special(std::uint32_t id, Special special) {
    expect_frame(encode_special(id, special));
    if (decode_special(row_.frame) != special) {
      problem("was decoded as another special frame");
    }
    expect_words(options(id, false));
  }

  void check_servo(const std::string& op, std::uint32_t id) {
    for (const ServoOperation& known : kServoOperations) {
      if (op == known.op) {
        expect_frame(encode_servo(id, {known.function, row_.number(known.key)}));
        const auto decoded = decode_servo(row_.frame);
        if (!decoded || decoded->function != known.function) {
          problem("was decoded as another servo command");
          return;
        }
        expect_near(known.key, decoded->value, row_.number(known.key));
        expect_words(options(id, true));
        return;
      }
    }
    problem("op=" + op + " is not known");
  }

  void check_status(std::uint32_t id) {
    const auto status = decode_status(row_.frame);
    if (!status || row_.frame.id != servo_id(Function::kStatus, id) || !row_.frame.extended) {
      problem("was not decoded as a status");
      return;
    }
    expect_near("position_deg", status->position_deg, row_.number("position_deg"));
    expect_near("erpm", status->speed_erpm, row_.number("erpm"));
    expect_near("current", status->current_a, row_.number("current"));
    expect_near("temp", status->temperature_c, row_.number("temp"));
    expect_near("error", status->error, row_.number("error"));
    const DriveOptions drive = options(id, true);
    const Facts facts(drive);
    Simulated simulated(drive);
    const double nudge = 1e-9;  // truncation of what is a whole count but for rounding
    const auto away = [nudge](double value) { return value * (1.0 + nudge); };
    simulated.set_shaft(away(status->position_deg * facts.radians_per_degree),
                        away(status->speed_erpm * facts.rad_s_per_erpm));
    std::array<Frame, SimulatedDrive::kMaxReplies> out;
    simulated.receive(*encode_servo(id, {Function::kCurrent, away(status->current_a)}), 0, out);
    const std::size_t count = simulated.speak(0, out);
    const Frame& told = out[count - 1];
    if (count != 3 || told.id != row_.frame.id ||
        !std::equal(told.data.begin(), told.data.begin() + 6, row_.frame.data.begin())) {
      problem(fmt::format("the simulated drive reports {}", words(told)));
    }
    expect_words(drive);
  }

  const Row& row_;
  std::vector<std::string> problems_;
};

}  // namespace

std::vector<std::string> check_cubemars_row(const Row& row) {
  return Checker(row).run();
}

}  // namespace geodesic::drivers::test
