// The start-up dialogue of a Damiao drive, step by step; see start_up.hpp. Sources: README.md.
#include "drivers/damiao/start_up.hpp"

#include <cmath>
#include <optional>

namespace geodesic::drivers::damiao {

namespace {

/// A register that is read at start-up, and what it must be.
struct Reading {
  Register number;
  const char* quantity;
  const char* fix;
};

constexpr std::array kReadings = {
    Reading{Register::kPositionRange, "PMAX (register 21) [rad]",
            "correct the drive's position range in the robot file, or write register 21 and save"},
    Reading{Register::kVelocityRange, "VMAX (register 22) [rad/s]",
            "correct the drive's velocity range in the robot file, or write register 22 and save"},
    Reading{Register::kTorqueRange, "TMAX (register 23) [N·m]",
            "correct the drive's torque range in the robot file, or write register 23 and save"},
    Reading{Register::kReplyId, "MST_ID (register 7)",
            "correct the drive's reply id in the robot file, or write register 7 and save"},
    Reading{Register::kId, "ESC_ID (register 8)",
            "correct the drive's id in the robot file, or write register 8 and save"},
    Reading{Register::kTimeout, "TIMEOUT (register 9) [50 µs]",
            "the drive does not take the watchdog time: check its firmware"},
    Reading{Register::kControlMode, "CTRL_MODE (register 10)",
            "the drive does not take MIT mode: check its firmware"},
    Reading{Register::kFirmware, "sw_ver (register 14)", "check the drive's firmware"},
};
constexpr double kRangeTolerance = 1e-3;  ///< relative: float32 and rounded figures in files
constexpr const char* kNoAnswer = "the drive reports its state but not this register: update it";

const Reading& reading_of(Register number) noexcept {
  for (const Reading& reading : kReadings) {
    if (reading.number == number) {
      return reading;
    }
  }
  return kReadings.front();
}

/// What the configuration wants of a register that is only compared; nothing: any value will do.
std::optional<double> expected_of(Register number, const DriveOptions& options) noexcept {
  switch (number) {
    case Register::kPositionRange:
      return options.position_range_rad;
    case Register::kVelocityRange:
      return options.velocity_range_rad_s;
    case Register::kTorqueRange:
      return options.torque_range_nm;
    case Register::kReplyId:
      return options.reply_id;
    case Register::kId:
      return options.id;
    default:
      return std::nullopt;
  }
}

bool is_error(std::uint8_t status) noexcept {
  return status != static_cast<std::uint8_t>(Status::kDisabled) &&
         status != static_cast<std::uint8_t>(Status::kEnabled);
}

}  // namespace

StartUp::StartUp(const DriveOptions& options) : options_(options) {
  restart();
}

void StartUp::restart() noexcept {
  enter(Step::kDisable);
  read_ = 0;
  write_ = 0;
  settings_ = {Setting{Register::kControlMode, static_cast<std::uint32_t>(ControlMode::kMit), 0},
               Setting{Register::kTimeout,
                       static_cast<std::uint32_t>(options_.watchdog_ns / kTimeoutUnitNs), 0}};
  firmware_ = 0;
  status_ = 0;
  heard_ = false;
  ranges_verified_ = false;
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

bool StartUp::awaits_register() const noexcept {
  return step_ == Step::kRead || step_ == Step::kWrite || step_ == Step::kReadBack;
}

std::uint8_t StartUp::awaited_register() const noexcept {
  return static_cast<std::uint8_t>(step_ == Step::kRead ? kReadings[read_].number
                                                        : settings_[write_].number);
}

Frame StartUp::request() const noexcept {
  switch (step_) {
    case Step::kDisable:
      return status_ == static_cast<std::uint8_t>(Status::kEnabled)
                 ? encode_special(options_.id, options_.fd, Special::kDisable)
                 : encode_state_request(options_.id, options_.fd);
    case Step::kClearError:
      return is_error(status_) && options_.clear_errors && clears_ < kMaxClears
                 ? encode_special(options_.id, options_.fd, Special::kClearError)
                 : encode_state_request(options_.id, options_.fd);
    case Step::kWrite:
      return encode_write(options_.id, options_.fd, awaited_register(), settings_[write_].wanted);
    case Step::kRead:
    case Step::kReadBack:
      return encode_read(options_.id, options_.fd, awaited_register());
    case Step::kConfirm:
    case Step::kDone:
    case Step::kRefused:
      break;
  }
  return encode_state_request(options_.id, options_.fd);
}

bool StartUp::transmit(std::int64_t now_ns, Frame& out) noexcept {
  if (done() || refused() || (awaiting_ && now_ns - asked_ns_ < kReplyTimeoutNs)) {
    return false;
  }
  if (awaits_register() && heard_ && ++tries_ > kMaxTries) {
    refuse({reading_of(static_cast<Register>(awaited_register())).quantity, std::nan(""),
            std::nan(""), kNoAnswer});
    return false;
  }
  out = request();
  awaiting_ = true;
  asked_ns_ = now_ns;
  if (awaits_register()) {
    register_asked_ns_ = now_ns;
    register_asked_ = true;
  }
  if (decode_special(out) == Special::kClearError) {
    ++clears_;
  }
  return true;
}

bool StartUp::receive_register(const ReceivedFrame& received) noexcept {
  if (!register_asked_ || received.stamp_ns - register_asked_ns_ > kLateAnswerNs) {
    return false;
  }
  const std::optional<RegisterFrame> answer = decode_register(received.frame);
  if (!answer || answer->id != options_.id) {
    return false;
  }
  const auto expected =
      static_cast<std::uint8_t>(step_ == Step::kWrite ? Operation::kWrite : Operation::kRead);
  if (awaiting_ && awaits_register() && answer->operation == expected &&
      answer->number == awaited_register()) {
    heard_ = true;
    take_value(*answer);
    return true;
  }
  // A second answer to a request that was repeated; as a state report it would be a far position.
  const bool ours = answer->operation == static_cast<std::uint8_t>(Operation::kRead) ||
                    answer->operation == static_cast<std::uint8_t>(Operation::kWrite);
  for (const Reading& reading : kReadings) {
    if (ours && answer->number == static_cast<std::uint8_t>(reading.number)) {
      return true;
    }
  }
  return false;
}

void StartUp::take_value(const RegisterFrame& answer) noexcept {
  if (step_ == Step::kWrite) {
    enter(Step::kReadBack);
    return;
  }
  const Reading& reading = reading_of(static_cast<Register>(answer.number));
  if (step_ == Step::kReadBack) {
    Setting& setting = settings_[write_];
    setting.found = answer.raw;
    if (setting.found != setting.wanted) {
      refuse({reading.quantity, static_cast<double>(setting.found),
              static_cast<double>(setting.wanted), reading.fix});
      return;
    }
    next_setting();
    return;
  }
  const RegisterFact* fact = find_register(answer.number);
  const double found =
      fact != nullptr && fact->integer ? static_cast<double>(answer.raw) : answer.real();
  const std::optional<double> expected = expected_of(reading.number, options_);
  // Written so that a NaN from the drive is a mismatch.
  if (expected && !(std::abs(found - *expected) <= kRangeTolerance * *expected &&
                    (fact == nullptr || !fact->integer || found == *expected))) {
    refuse({reading.quantity, found, *expected, reading.fix});
    return;
  }
  for (Setting& setting : settings_) {
    setting.found = setting.number == reading.number ? answer.raw : setting.found;
  }
  firmware_ = reading.number == Register::kFirmware ? answer.raw : firmware_;
  ++read_;
  if (read_ == kReadings.size()) {
    ranges_verified_ = true;
    enter(Step::kClearError);
  } else {
    enter(Step::kRead);
  }
}

void StartUp::next_setting() noexcept {
  while (write_ < kSettings && settings_[write_].found == settings_[write_].wanted) {
    ++write_;
  }
  enter(write_ < kSettings ? Step::kWrite : Step::kConfirm);
}

void StartUp::receive_status(std::uint8_t status) noexcept {
  heard_ = true;
  status_ = status;
  const bool enabled = status == static_cast<std::uint8_t>(Status::kEnabled);
  switch (step_) {
    case Step::kDisable:
      enter(enabled ? Step::kDisable : Step::kRead);
      break;
    case Step::kClearError:
      held_by_error_ = is_error(status) && (!options_.clear_errors || clears_ >= kMaxClears);
      complaint_ = {};
      if (held_by_error_) {
        complaint_ = {"status of the drive (an error)", static_cast<double>(status), 0.0,
                      "remove its cause; then power-cycle the drive, or let clear_errors clear it"};
        enter(Step::kClearError);
      } else if (is_error(status)) {
        enter(Step::kClearError);
      } else if (enabled) {
        enter(Step::kDisable);
        read_ = 0;
      } else {
        next_setting();
      }
      break;
    case Step::kConfirm:
      enter(is_error(status) ? Step::kClearError : (enabled ? Step::kDisable : Step::kDone));
      read_ = enabled ? 0 : read_;
      break;
    case Step::kRead:
    case Step::kWrite:
    case Step::kReadBack:
    case Step::kDone:
    case Step::kRefused:
      break;
  }
}

}  // namespace geodesic::drivers::damiao
