// Holds rows of golden vectors against the Damiao codec, both ways; see vectors.hpp.
#include "tests/drivers/damiao/vectors.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <bit>
#include <cmath>
#include <stdexcept>

#include "drivers/damiao/codec.hpp"
#include "drivers/damiao/family.hpp"

namespace geodesic::drivers::test {

namespace {

using namespace damiao;  // NOLINT(google-build-using-namespace): the codec under test

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

class Checker {
 public:
  explicit Checker(const Row& row) : row_(row) {}

  std::vector<std::string> run() {
    if (row_.description.rfind("DISAGREEMENT", 0) == 0) {
      return {};  // what somebody else sends: documentation
    }
    if (row_.text("mode") == "mit") {
      check_mit();
    } else if (!row_.command && row_.has("status")) {
      check_state();
    } else if (const auto op = row_.text("op")) {
      check_operation(*op);
    } else {
      problem("neither mode=mit, nor op=, nor a state: nothing to hold it against");
    }
    return problems_;
  }

 private:
  void problem(std::string text) { problems_.push_back(std::move(text)); }

  void expect_frame(const Frame& encoded) {
    if (encoded != row_.frame) {
      problem(fmt::format("encoded as {}, the vector is {}", words(encoded), words(row_.frame)));
    }
  }

  void expect_near(const char* what, double decoded, double expected) {
    if (!(std::abs(decoded - expected) <= 1e-6 * std::abs(expected) + 1e-12)) {
      problem(fmt::format("{} decoded as {:.9g}, the vector says {:.9g}", what, decoded, expected));
    }
  }

  void expect_words(std::uint32_t id, std::uint32_t reply_id, const Ranges& ranges) {
    DriveOptions options;
    options.id = id;
    options.reply_id = reply_id;
    options.position_range_rad = ranges.position_rad;
    options.velocity_range_rad_s = ranges.velocity_rad_s;
    options.torque_range_nm = ranges.torque_nm;
    if (!decode(row_.frame, options)) {
      problem("cannot be told in words");
    }
  }

  static std::string words(const Frame& frame) {
    std::string text =
        fmt::format("{:X}{}{}#", frame.id, frame.extended ? " ext" : "", frame.fd ? " fd" : "");
    for (const std::uint8_t byte : frame.payload()) {
      text += fmt::format("{:02X}", byte);
    }
    return text;
  }

  Ranges ranges() const { return {row_.number("pmax"), row_.number("vmax"), row_.number("tmax")}; }

  std::uint32_t id() const { return static_cast<std::uint32_t>(row_.number("motor_id")); }

  void check_mit() {
    MitCommand requested;
    for (const MitField& field : kMitFields) {
      requested.*field.value = row_.number(field.key);
    }
    const auto encoded = encode_mit(row_.frame.id, row_.frame.fd, requested, ranges());
    if (row_.says("encoder must refuse")) {
      if (encoded) {
        problem("a number that is not finite was encoded");
      }
      return;
    }
    if (!encoded) {
      problem("was refused");
      return;
    }
    if (row_.frame.length != 8 || encoded->length != 8 || encoded->id != row_.frame.id ||
        row_.frame.extended || encoded->fd != row_.frame.fd) {
      problem(fmt::format("encoded as {}, the vector is {}", words(*encoded), words(row_.frame)));
    }
    if (decode_special(*encoded)) {
      problem("encoded as a special frame");
    }
    for (const MitField& field : kMitFields) {
      const std::uint32_t ours = extract(*encoded, field.field);
      const std::uint32_t theirs = extract(row_.frame, field.field);
      if (std::max(ours, theirs) - std::min(ours, theirs) > 1) {
        problem(fmt::format("{} = {} encoded as {:X}, the vector has {:X}", field.key,
                            requested.*field.value, ours, theirs));
      }
    }
    if (!row_.says("encoder must avoid")) {
      check_mit_decoding(requested);
    }
  }

  void check_mit_decoding(const MitCommand& requested) {
    const auto decoded = decode_mit(row_.frame, ranges());
    if (!decoded) {
      problem("was not decoded as an MIT command");
      return;
    }
    const MitCommand high{ranges().position_rad, ranges().velocity_rad_s, mit::kMaxStiffness,
                          mit::kMaxDamping, ranges().torque_nm};
    for (const MitField& field : kMitFields) {
      const double top = high.*field.value;
      const double bottom =
          field.field.first == mit::kStiffness.first || field.field.first == mit::kDamping.first
              ? 0.0
              : -top;
      const double code = (top - bottom) / static_cast<double>((1U << field.field.bits) - 1U);
      const double wanted = std::clamp(requested.*field.value, bottom, top);
      if (!(std::abs((*decoded).*field.value - wanted) <= code * 1.001)) {
        problem(fmt::format("{} decoded as {}, requested was {}", field.key,
                            (*decoded).*field.value, wanted));
      }
      for (const std::string& key :
           {std::string("drive_") + field.key, std::string(field.key) + "_on_wire"}) {
        if (row_.has(key)) {
          expect_near(key.c_str(), (*decoded).*field.value, row_.number(key));
        }
      }
    }
    const auto again = encode_mit(row_.frame.id, row_.frame.fd, *decoded, ranges());
    if (!again || again->data != row_.frame.data) {
      problem("decoded and encoded again, it is another frame");
    }
    expect_words(row_.frame.id, row_.frame.id + 0x10, ranges());
  }

  void check_state() {
    const auto report = decode_report(row_.frame, ranges());
    if (!report) {
      problem("was not decoded as a state");
      return;
    }
    expect_near("status", report->status, row_.number("status"));
    expect_near("motor", report->motor, id() & 0xFU);
    expect_near("position", report->position_rad, row_.number("position"));
    expect_near("velocity", report->velocity_rad_s, row_.number("velocity"));
    expect_near("torque", report->torque_nm, row_.number("torque"));
    expect_near("t_mos", report->mosfet_c, row_.number("t_mos"));
    expect_near("t_rotor", report->rotor_c, row_.number("t_rotor"));
    expect_words(id(), row_.frame.id, ranges());
  }

  void check_operation(const std::string& op) {
    const bool fd = row_.frame.fd;
    const Frame& frame = row_.frame;
    if (op == "enable") {
      check_special(Special::kEnable);
    } else if (op == "disable") {
      check_special(Special::kDisable);
    } else if (op == "zero") {
      check_special(Special::kSetZero);
    } else if (op == "clear_error") {
      check_special(Special::kClearError);
    } else if (op == "refresh") {
      expect_frame(encode_state_request(id(), fd));
    } else if (op == "save") {
      Frame any = frame;
      any.data[3] = 0;  // hosts differ there
      Frame ours = encode_save(id(), fd);
      if (any != ours) {
        expect_frame(ours);
      }
    } else if (op == "pos_vel") {
      const PositionVelocityCommand command{row_.number("p_des"), row_.number("v_limit")};
      expect_frame(encode_position_velocity(id(), fd, command).value_or(Frame{}));
      const auto decoded = decode_position_velocity(frame).value_or(PositionVelocityCommand{});
      expect_near("p_des", decoded.position_rad, command.position_rad);
      expect_near("v_limit", decoded.velocity_limit_rad_s, command.velocity_limit_rad_s);
    } else if (op == "vel") {
      check_velocity();
    } else if (op == "pos_force") {
      check_position_force();
    } else if (op.rfind("read_reg", 0) == 0 || op.rfind("write_reg", 0) == 0) {
      check_register(op);
    } else {
      problem("op=" + op + " is not known");
      return;
    }
    expect_words(id(), row_.command ? id() + 0x10 : frame.id, {12.5, 30.0, 10.0});
  }

  void check_special(Special special) {
    expect_frame(encode_special(id(), row_.frame.fd, special));
    if (decode_special(row_.frame) != special) {
      problem("was decoded as another special frame");
    }
  }

  void check_velocity() {
    Frame encoded = encode_velocity(id(), row_.frame.fd, row_.number("v_des")).value_or(Frame{});
    encoded.length = row_.frame.length == 8 ? std::uint8_t{8} : encoded.length;  // zero tail
    expect_frame(encoded);
    expect_near("v_des", decode_velocity(row_.frame).value_or(NAN), row_.number("v_des"));
  }

  void check_position_force() {
    const PositionForceCommand command{row_.number("p_des"), row_.number("v_limit"),
                                       row_.number("i_limit")};
    const Frame encoded = encode_position_force(id(), row_.frame.fd, command).value_or(Frame{});
    const auto ours = decode_position_force(encoded);
    const auto theirs = decode_position_force(row_.frame);
    if (!ours || !theirs || encoded.id != row_.frame.id || encoded.fd != row_.frame.fd) {
      expect_frame(encoded);
      return;
    }
    const auto check = [this](const char* what, double wanted, double a, double b, double code) {
      if (std::abs(a - b) > 1.001 * code || std::abs(b - wanted) > 1.001 * code) {
        problem(fmt::format("{} = {} encoded as {}, the vector has {}", what, wanted, a, b));
      }
    };
    expect_near("p_des", theirs->position_rad, static_cast<float>(command.position_rad));
    check("p_des", command.position_rad, ours->position_rad, theirs->position_rad, 1e-6);
    check("v_limit", std::clamp(command.velocity_limit_rad_s, 0.0, 100.0),
          ours->velocity_limit_rad_s, theirs->velocity_limit_rad_s, 0.01);
    check("i_limit", std::clamp(command.current_limit, 0.0, 1.0), ours->current_limit,
          theirs->current_limit, 1e-4);
  }

  void check_register(const std::string& op) {
    const auto number = static_cast<std::uint8_t>(row_.number("rid"));
    const RegisterFact* fact = find_register(number);
    if (fact == nullptr) {
      problem(fmt::format("register {} is not known", number));
      return;
    }
    const bool with_value = op != "read_reg";
    const double value = with_value ? row_.number("value") : 0.0;
    const std::uint32_t raw = fact->integer
                                  ? static_cast<std::uint32_t>(value)
                                  : std::bit_cast<std::uint32_t>(static_cast<float>(value));
    if (row_.command) {
      expect_frame(with_value ? encode_write(id(), row_.frame.fd, number, raw)
                              : encode_read(id(), row_.frame.fd, number));
    }
    const auto operation = op.rfind("read", 0) == 0 ? Operation::kRead : Operation::kWrite;
    const RegisterFrame expected{.id = static_cast<std::uint16_t>(id()),
                                 .operation = static_cast<std::uint8_t>(operation),
                                 .number = number,
                                 .raw = raw};
    if (decode_register(row_.frame) != expected) {
      problem("was decoded as another register frame");
    }
  }

  const Row& row_;
  std::vector<std::string> problems_;
};

}  // namespace

std::vector<std::string> check_damiao_row(const Row& row) {
  return Checker(row).run();
}

}  // namespace geodesic::drivers::test
