// Holds rows of golden vectors against the RobStride codec, both ways; see vectors.hpp.
#include "tests/drivers/robstride/vectors.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <bit>
#include <cmath>
#include <limits>

#include "drivers/robstride/codec.hpp"
#include "drivers/robstride/family.hpp"
#include "drivers/robstride/mit.hpp"
#include "drivers/robstride/settings.hpp"

namespace geodesic::drivers::test {

namespace {

using namespace robstride;  // NOLINT(google-build-using-namespace): the codec under test

struct Number {
  const char* key;
  double ControlCommand::*value;
  double Ranges::*range;
  bool both_ways;
};

constexpr std::array kNumbers = {
    Number{"p_des", &ControlCommand::position_rad, &Ranges::position_rad, true},
    Number{"v_des", &ControlCommand::velocity_rad_s, &Ranges::velocity_rad_s, true},
    Number{"kp", &ControlCommand::stiffness_nm_rad, &Ranges::stiffness_nm_rad, false},
    Number{"kd", &ControlCommand::damping_nm_s_rad, &Ranges::damping_nm_s_rad, false},
    Number{"t_ff", &ControlCommand::torque_nm, &Ranges::torque_nm, true},
};

class Checker {
 public:
  explicit Checker(const Row& row) : row_(row) {}

  std::vector<std::string> run() {
    if (row_.description.rfind("DISAGREEMENT", 0) == 0) {
      return {};  // what somebody else sends: documentation
    }
    if (row_.text("protocol") == "mit") {
      row_.command ? check_control(true) : check_mit_reply();
      return problems_;
    }
    if (!row_.frame.extended || row_.frame.fd || row_.frame.length != 8) {
      problem("no frame of the private protocol: 29 bits of identifier, classic, 8 bytes");
      return problems_;
    }
    row_.command ? check_command() : check_feedback();
    if (!row_.says("must refuse") && !words()) {
      problem("cannot be told in words");
    }
    return problems_;
  }

 private:
  void problem(std::string text) { problems_.push_back(std::move(text)); }

  /// @param range  of what was computed in float32: near its middle that is all that is left of
  ///               the digits, 0.004 of a code.
  void expect_near(const char* what, double decoded, double expected, double range = 0.0) {
    const double rounding = range * static_cast<double>(std::numeric_limits<float>::epsilon());
    if (!(std::abs(decoded - expected) <= 1e-6 * std::abs(expected) + rounding + 1e-12)) {
      problem(fmt::format("{} decoded as {:.9g}, the vector says {:.9g}", what, decoded, expected));
    }
  }

  void expect_frame(const Frame& encoded) {
    if (encoded != row_.frame) {
      problem(fmt::format("encoded as {:08X}#{:02X}, the vector is {:08X}#{:02X}", encoded.id,
                          fmt::join(encoded.payload(), ""), row_.frame.id,
                          fmt::join(row_.frame.payload(), "")));
    }
  }

  double number_or(const char* key, double otherwise) const {
    return row_.has(key) ? row_.number(key) : otherwise;
  }

  Ranges ranges() const {
    return {number_or("pmax", 12.5), number_or("vmax", 30.0), number_or("tmax", 12.0),
            number_or("kpmax", 500.0), number_or("kdmax", 5.0)};
  }

  Link link() const {
    return {.motor = static_cast<std::uint8_t>(row_.number("motor_id")),
            .host = static_cast<std::uint8_t>(number_or("host_id", 253.0))};
  }

  bool words() const {
    DriveOptions options;
    options.id = link().motor;
    options.settings.values[kHostId] = link().host;
    const Ranges all = ranges();
    options.position_range_rad = all.position_rad;
    options.velocity_range_rad_s = all.velocity_rad_s;
    options.torque_range_nm = all.torque_nm;
    options.settings.values[kStiffnessRange] = all.stiffness_nm_rad;
    options.settings.values[kDampingRange] = all.damping_nm_s_rad;
    const auto told = decode(row_.frame, options);
    return told && !told->kind.empty();
  }

  void check_control(bool mit) {
    ControlCommand requested;
    for (const Number& number : kNumbers) {
      requested.*number.value = row_.number(number.key);
    }
    const auto encoded = mit ? encode_mit(link().motor, requested, ranges())
                             : encode_control(link().motor, requested, ranges());
    if (row_.says("must refuse")) {
      if (encoded) {
        problem("a number that is not finite was encoded");
      }
      return;
    }
    if (!encoded) {
      problem("was refused");
      return;
    }
    const auto decode_either = [&](const Frame& frame) {
      return mit ? decode_mit(frame, ranges()) : decode_control(frame, ranges());
    };
    const auto ours = decode_either(*encoded);
    const auto theirs = decode_either(row_.frame);
    if (!ours || !theirs || (encoded->id ^ row_.frame.id) % 256U != 0 ||
        encoded->extended != row_.frame.extended || encoded->length != row_.frame.length) {
      expect_frame(*encoded);
      return;
    }
    for (const Number& number : kNumbers) {
      const double top = ranges().*number.range;
      const double bottom = number.both_ways ? -top : 0.0;
      const bool wide = !mit || number.value == &ControlCommand::position_rad;
      const double code = (top - bottom) / (wide ? 65535.0 : 4095.0);
      const double wanted = std::clamp(requested.*number.value, bottom, top);
      const double mine = (*ours).*number.value;
      const double other = (*theirs).*number.value;
      if (!(std::abs(mine - other) <= 1.001 * code && std::abs(mine - wanted) <= 0.501 * code &&
            std::abs(other - wanted) <= 1.001 * code)) {
        problem(fmt::format("{} = {} encoded as {}, the vector has {}", number.key, wanted, mine,
                            other));
      }
    }
    const auto again = mit ? encode_mit(link().motor, *theirs, ranges())
                           : encode_control(link().motor, *theirs, ranges());
    expect_frame(again.value_or(Frame{}));
  }

  void check_command() {
    const auto type = static_cast<Type>(row_.frame.id >> kTypeShift);
    switch (type) {
      case Type::kControl:
        check_control(false);
        break;
      case Type::kGetId:
        expect_frame(encode_get_id(link()));
        break;
      case Type::kEnable:
        expect_frame(encode_enable(link()));
        break;
      case Type::kStop:
        expect_frame(encode_stop(link(), number_or("clear_fault", 0.0) != 0.0));
        break;
      case Type::kZero:
        expect_frame(encode_zero(link()));
        break;
      case Type::kSetId:
        expect_frame(encode_set_id(link(), static_cast<std::uint8_t>(row_.number("new_id"))));
        break;
      case Type::kRead:
        expect_frame(encode_read(link(), index()));
        break;
      case Type::kWrite:
        expect_frame(encode_write(link(), index(), raw()));
        break;
      case Type::kSave:
        expect_frame(encode_save(link()));
        break;
      case Type::kReport:
        expect_frame(encode_reports(link(), row_.number("enable") != 0.0));
        break;
      default:
        problem(fmt::format("type {} is not known", static_cast<int>(type)));
        break;
    }
  }

  std::uint16_t index() const { return static_cast<std::uint16_t>(row_.number("index")); }

  bool is_float() {
    const Parameter* fact = find_parameter(index());
    if (fact == nullptr) {
      problem(fmt::format("parameter 0x{:04X} is not known", index()));
    }
    return fact != nullptr && fact->value == Value::kFloat;
  }

  std::uint32_t raw() {
    const double value = row_.number("value");
    return is_float() ? std::bit_cast<std::uint32_t>(static_cast<float>(value))
                      : static_cast<std::uint32_t>(value);
  }

  void expect_link(const Link& told) {
    expect_near("motor", told.motor, link().motor);
    expect_near("host", told.host, link().host);
  }

  void check_feedback() {
    const auto type = static_cast<Type>(row_.frame.id >> kTypeShift);
    if (type == Type::kFeedback) {
      check_state();
    } else if (type == Type::kRead) {
      const auto answer = decode_parameter(row_.frame);
      if (!answer) {
        problem("was not decoded as an answer to a read");
        return;
      }
      expect_link(answer->link);
      expect_near("index", answer->index, index());
      expect_near("status", answer->failed ? 1.0 : 0.0, row_.number("status"));
      if (!answer->failed) {
        expect_near("value", is_float() ? answer->real() : answer->raw, row_.number("value"));
      }
    } else if (type == Type::kFault) {
      const auto report = decode_fault_report(row_.frame);
      if (!report) {
        problem("was not decoded as a fault report");
        return;
      }
      expect_link(report->link);
      expect_near("fault", report->faults, row_.number("fault"));
      expect_near("warning", report->warnings, row_.number("warning"));
    } else if (type == Type::kGetId) {
      expect_near("motor", decode_identity(row_.frame).value_or(0), link().motor);
    } else {
      problem(fmt::format("a drive does not send type {}", static_cast<int>(type)));
    }
  }

  void check_state() {
    const auto feedback = decode_feedback(row_.frame, ranges());
    if (!feedback) {
      problem("was not decoded as feedback");
      return;
    }
    expect_link(feedback->link);
    expect_near("mode", feedback->mode, row_.number("mode"));
    expect_near("fault_bits", feedback->faults, row_.number("fault_bits"));
    expect_near("position", feedback->position_rad, row_.number("position"), ranges().position_rad);
    expect_near("velocity", feedback->velocity_rad_s, row_.number("velocity"),
                ranges().velocity_rad_s);
    expect_near("torque", feedback->torque_nm, row_.number("torque"), ranges().torque_nm);
    expect_near("temperature", feedback->temperature_c, row_.number("temperature"));
  }

  void check_mit_reply() {
    const auto reply = decode_mit_reply(row_.frame, ranges());
    if (!reply) {
      problem("was not decoded as an answer of the MIT protocol");
      return;
    }
    expect_near("motor", reply->motor, link().motor);
    expect_near("position", reply->position_rad, row_.number("position"), ranges().position_rad);
    expect_near("velocity", reply->velocity_rad_s, row_.number("velocity"),
                ranges().velocity_rad_s);
    expect_near("torque", reply->torque_nm, row_.number("torque"), ranges().torque_nm);
    expect_near("temperature", reply->temperature_c, row_.number("temperature"));
  }

  const Row& row_;
  std::vector<std::string> problems_;
};

}  // namespace

std::vector<std::string> check_robstride_row(const Row& row) {
  return Checker(row).run();
}

}  // namespace geodesic::drivers::test
