// The start-up dialogue of a moteus drive, step by step; see start_up.hpp. Sources: README.md.
#include "drivers/moteus/start_up.hpp"

#include <cmath>
#include <optional>

#include "drivers/moteus/settings.hpp"

namespace geodesic::drivers::moteus {

namespace {

constexpr double kTolerance = 1e-3;  ///< relative: float32 and rounded figures in files
constexpr const char* kNoAnswer =
    "the drive reports its state but does not answer this: update its firmware";
constexpr const char* kHomeFix =
    "the position is not referenced as configured: give the drive an output encoder "
    "(motor_position.output), or say home = \"rotor\" and its rotor_to_output_ratio";
constexpr const char* kMapFix =
    "other registers than this driver knows: update the drive's firmware (moteus_tool --flash)";
constexpr const char* kSettingFix =
    "correct this figure in the robot file, or the drive's by conf set and conf write";

}  // namespace

StartUp::StartUp(const DriveOptions& options, const Link& link, const Formats& formats)
    : link_(link),
      formats_(formats),
      clear_errors_(options.clear_errors),
      least_home_(
          static_cast<double>(setting(options, kHome) == 0.0 ? Home::kOutput : Home::kRotor)) {
  const auto want = [this](std::string_view line, const char* quantity, double value) {
    wanted_[wanted_count_++] = {line, quantity, value};
  };
  if (setting(options, kHome) != 0.0 || !std::isnan(options.settings.values[kRatio])) {
    want("conf get motor_position.rotor_to_output_ratio\n",
         "motor_position.rotor_to_output_ratio (conf get)", setting(options, kRatio));
  }
  if (setting(options, kKp) > 0.0) {
    want("conf get servo.pid_position.kp\n", "servo.pid_position.kp (conf get) [N·m/rev]",
         setting(options, kKp));
  }
  if (setting(options, kKd) > 0.0) {
    want("conf get servo.pid_position.kd\n", "servo.pid_position.kd (conf get) [N·m·s/rev]",
         setting(options, kKd));
  }
  restart();
}

void StartUp::restart() noexcept {
  enter(Step::kLook);
  asked_ = 0;
  firmware_ = 0;
  mode_ = 0;
  heard_ = false;
  verified_ = false;
  held_by_error_ = false;
  clears_ = 0;
  complaint_ = {};
}

void StartUp::enter(Step step) noexcept {
  step_ = step;
  awaiting_ = false;
  tries_ = 0;
}

void StartUp::refuse(const DriveComplaint& complaint) noexcept {
  complaint_ = complaint;
  enter(Step::kRefused);
}

Frame StartUp::request() noexcept {
  switch (step_) {
    case Step::kLook:
      return is_running(mode_) ? encode_stop(link_, formats_) : encode_query(link_, formats_);
    case Step::kRead: {
      Frame frame = make_frame(link_.command());
      constexpr std::array kAsked = {Item{Register::kModel, Resolution::kInt32},
                                     Item{Register::kFirmware, Resolution::kInt32},
                                     Item{Register::kRegisterMap, Resolution::kInt32},
                                     Item{Register::kHomeState, Resolution::kInt8}};
      append_reads(frame, kAsked);
      pad(frame);
      return frame;
    }
    case Step::kAsk:
      return console_.request(link_);
    case Step::kClearError:
      if (is_error(mode_) && clear_errors_ && clears_ < kMaxClears) {
        ++clears_;
        return encode_stop(link_, formats_);
      }
      break;
    case Step::kConfirm:
    case Step::kDone:
    case Step::kRefused:
      break;
  }
  return encode_query(link_, formats_);
}

bool StartUp::transmit(std::int64_t now_ns, Frame& out) noexcept {
  if (done() || refused() || (awaiting_ && now_ns - asked_ns_ < kReplyTimeoutNs)) {
    return false;
  }
  const bool question = step_ == Step::kRead || step_ == Step::kAsk;
  if (question && heard_ && ++tries_ > kMaxTries) {
    refuse({step_ == Step::kRead ? "register map version and home state (0x102, 0x00C)"
                                 : wanted_[asked_].quantity,
            std::nan(""), std::nan(""), kNoAnswer});
    return false;
  }
  out = request();
  awaiting_ = true;
  asked_ns_ = now_ns;
  return true;
}

void StartUp::receive(const Frame& reply, const StateReport& report) noexcept {
  heard_ = true;
  if (step_ == Step::kRead) {
    take_registers(reply);
  } else if (step_ == Step::kAsk) {
    take_answer(reply);
  } else if (report.mode && awaiting_) {
    take_mode(*report.mode, report.fault.value_or(0));
  }
}

void StartUp::take_registers(const Frame& reply) noexcept {
  std::optional<double> map;
  std::optional<double> home;
  Reader reader(reply);
  for (Entry entry; reader.next(entry);) {
    const auto number = static_cast<Register>(entry.number);
    if (entry.kind == opcode::kReadError &&
        (number == Register::kModel || number == Register::kFirmware ||
         number == Register::kRegisterMap || number == Register::kHomeState)) {
      refuse({"register that the drive does not know", static_cast<double>(entry.number),
              std::nan(""), kMapFix});
      return;
    }
    if (entry.kind != opcode::kReply) {
      continue;
    }
    if (number == Register::kRegisterMap) {
      map = entry.value;
    } else if (number == Register::kHomeState) {
      home = entry.value;
    } else if (number == Register::kFirmware && entry.resolution == Resolution::kInt32) {
      firmware_ = static_cast<std::uint32_t>(entry.code);
    }
  }
  if (!map || !home) {
    return;  // an answer to something else
  }
  // Written so that a NaN from the drive is a mismatch.
  if (!(*map == static_cast<double>(kRegisterMapVersion))) {
    refuse({"register map version (register 0x102)", *map, static_cast<double>(kRegisterMapVersion),
            kMapFix});
  } else if (!(*home >= least_home_)) {
    refuse({"home state (register 0x00C: 0 relative, 1 rotor, 2 output)", *home, least_home_,
            kHomeFix});
  } else {
    asked_ = 0;
    next_question();
  }
}

void StartUp::next_question() noexcept {
  if (asked_ < wanted_count_) {
    enter(Step::kAsk);
    console_.ask(wanted_[asked_].line);
  } else {
    verified_ = true;
    enter(Step::kClearError);
  }
}

void StartUp::take_answer(const Frame& reply) noexcept {
  if (!awaiting_ || !console_.take(reply)) {
    return;
  }
  awaiting_ = false;
  if (!console_.answered()) {
    return;
  }
  const Wanted& wanted = wanted_[asked_];
  const double found = console_.number().value_or(std::nan(""));
  if (!(std::abs(found - wanted.value) <= kTolerance * std::abs(wanted.value))) {
    refuse({wanted.quantity, found, wanted.value, kSettingFix});
    return;
  }
  ++asked_;
  next_question();
}

void StartUp::take_mode(std::uint8_t mode, std::uint8_t fault) noexcept {
  mode_ = mode;
  switch (step_) {
    case Step::kLook:
      enter(is_running(mode) ? Step::kLook : Step::kRead);
      break;
    case Step::kClearError:
      held_by_error_ = is_error(mode) && (!clear_errors_ || clears_ >= kMaxClears);
      complaint_ = {};
      if (held_by_error_) {
        complaint_ = {"fault of the drive (register 0x00F, or mode 11)",
                      static_cast<double>(error_of(mode, fault)), 0.0,
                      "remove its cause; then power-cycle the drive, or let clear_errors clear it"};
      }
      enter(is_error(mode) ? Step::kClearError : (is_running(mode) ? Step::kLook : Step::kConfirm));
      break;
    case Step::kConfirm:
      enter(is_error(mode) ? Step::kClearError : (is_running(mode) ? Step::kLook : Step::kDone));
      break;
    case Step::kRead:
    case Step::kAsk:
    case Step::kDone:
    case Step::kRefused:
      break;
  }
}

}  // namespace geodesic::drivers::moteus
