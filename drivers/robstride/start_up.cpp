// The start-up dialogue of a RobStride or CyberGear drive, step by step; see start_up.hpp. Sources:
// README.md.
#include "drivers/robstride/start_up.hpp"

#include <cmath>

#include "drivers/robstride/settings.hpp"

namespace geodesic::drivers::robstride {

namespace {

constexpr double kRelativeTolerance = 1e-3;  ///< float32 and rounded figures in files
/// After power-on limit_torque is what the model can, and we write no more than our torque range: a
/// drive whose torque is scaled by another range shows. EL05's two figures are 9 % apart.
constexpr double kMostLimit = 1.15;
constexpr const char* kStronger =
    "its limit_torque is above the torque range it is said to have: correct torque_range_nm";
constexpr const char* kUnanswered =
    "the drive reports its state but not this parameter: check its firmware";
constexpr const char* kUnknown =
    "the drive says that it has no such parameter: update its firmware, or correct the variant";

constexpr auto kRun = static_cast<std::uint8_t>(Mode::kRun);

}  // namespace

StartUp::StartUp(const DriveOptions& options)
    : options_(options),
      link_(robstride::link_of(options)),
      cybergear_(is_cybergear(options)),
      least_firmware_(options.settings.get(kSettings, kLeastFirmware)) {
  restart();
}

void StartUp::restart() noexcept {
  const auto limit = static_cast<float>(torque_limit_nm(options_));
  count_ = 0;
  if (!cybergear_) {
    wanted_[count_++] = {.index = static_cast<std::uint16_t>(Index::kZeroState),
                         .quantity = "zero_sta (parameter 0x7029)",
                         .fix =
                             "it powers up between 0 and 2 pi, not -pi and pi: write 1 and save "
                             "(`geodesic zero` does)",
                         .raw = 1,
                         .fixed = true};
  }
  wanted_[count_++] = {.index = static_cast<std::uint16_t>(Index::kRunMode),
                       .quantity = "run_mode (parameter 0x7005)",
                       .fix = "the drive does not take operation control: check its firmware",
                       .raw = static_cast<std::uint32_t>(RunMode::kOperation)};
  wanted_[count_++] = {
      .index = static_cast<std::uint16_t>(Index::kTorqueLimit),
      .quantity = "limit_torque (parameter 0x700B) [N·m]",
      .fix = "the drive does not take this limit: correct its torque range, or torque_limit_nm",
      .raw = std::bit_cast<std::uint32_t>(limit),
      .real = true};
  wanted_[count_++] = {.index = static_cast<std::uint16_t>(timeout_index(cybergear_)),
                       .quantity = cybergear_ ? "CAN_TIMEOUT (parameter 0x200C) [50 µs]"
                                              : "canTimeout (parameter 0x7028) [50 µs]",
                       .fix = "the drive does not take the watchdog time: check its firmware",
                       .raw = static_cast<std::uint32_t>(options_.watchdog_ns / kTimeoutUnitNs)};
  begin_again();
  if (!cybergear_) {
    enter(Step::kSilence);
  }
  looks_ = 0;
  clears_ = 0;
  firmware_ = 0;
  feedback_ = {};
  heard_ = false;
  ranges_verified_ = false;
  held_by_error_ = false;
  complaint_ = {};
}

void StartUp::enter(Step step) noexcept {
  step_ = step;
  awaiting_ = false;
  seen_ = false;
  tries_ = 0;
}

/// From the first question on: the drive runs, or may have been off.
void StartUp::begin_again() noexcept {
  read_ = 0;
  write_ = 0;
  writes_ = 0;
  enter(Step::kStop);
}

void StartUp::refuse(const DriveComplaint& complaint) noexcept {
  complaint_ = complaint;
  enter(Step::kRefused);
}

bool StartUp::awaits_parameter() const noexcept {
  return step_ == Step::kCompare || step_ == Step::kRead || step_ == Step::kReadBack;
}

std::uint16_t StartUp::awaited_index() const noexcept {
  return step_ == Step::kCompare ? static_cast<std::uint16_t>(Index::kPosition)
                                 : wanted_[step_ == Step::kRead ? read_ : write_].index;
}

const char* StartUp::awaited_quantity() const noexcept {
  return step_ == Step::kCompare ? "mechPos (parameter 0x7019) [rad]"
                                 : wanted_[step_ == Step::kRead ? read_ : write_].quantity;
}

std::size_t StartUp::request(std::span<Frame> out) noexcept {
  switch (step_) {
    case Step::kSilence:
      out[0] = encode_reports(link_, false);
      out[1] = encode_stop(link_, false);
      return 2;
    case Step::kVersion:
      out[0] = encode_version_query(link_);
      return 1;
    case Step::kCompare:
      out[0] = encode_stop(link_, false);
      out[1] = encode_read(link_, awaited_index());
      return 2;
    case Step::kRead:
    case Step::kReadBack:
      out[0] = encode_read(link_, awaited_index());
      return 1;
    case Step::kClearError: {
      const bool clear = feedback_.faults != 0 && options_.clear_errors && clears_ < kMaxClears;
      clears_ += clear ? 1 : 0;
      out[0] = encode_stop(link_, clear);
      return 1;
    }
    case Step::kWrite:
      out[0] = encode_write(link_, wanted_[write_].index, wanted_[write_].raw);
      return 1;
    case Step::kStop:
    case Step::kConfirm:
    case Step::kDone:
    case Step::kRefused:
      break;
  }
  out[0] = encode_stop(link_, false);
  return 1;
}

std::size_t StartUp::transmit(std::int64_t now_ns, std::span<Frame> out) noexcept {
  if (done() || refused() || out.size() < 2 ||
      (awaiting_ && now_ns - asked_ns_ < kReplyTimeoutNs)) {
    return 0;
  }
  if ((awaits_parameter() || step_ == Step::kWrite) && heard_ && ++tries_ > kMaxTries) {
    const char* quantity = step_ == Step::kWrite ? wanted_[write_].quantity : awaited_quantity();
    refuse({quantity, std::nan(""), std::nan(""), kUnanswered});
    return 0;
  }
  const std::size_t count = request(out);
  silent_ = step_ == Step::kSilence;
  awaiting_ = true;
  asked_ns_ = now_ns;
  if (step_ == Step::kVersion) {
    version_asked_ns_ = now_ns;
    version_asked_ = true;
  }
  if (step_ == Step::kSilence) {
    step_ = Step::kStop;  // the stop that left with it is awaited
  }
  return count;
}

std::size_t StartUp::answers_due(std::size_t frames) const noexcept {
  return silent_ && frames > 0 ? frames - 1 : frames;
}

double StartUp::value_of(const Wanted& wanted, std::uint32_t raw) noexcept {
  return wanted.real ? static_cast<double>(std::bit_cast<float>(raw)) : static_cast<double>(raw);
}

void StartUp::receive_parameter(const ParameterAnswer& answer) noexcept {
  heard_ = true;
  if (!awaiting_ || !awaits_parameter() || answer.index != awaited_index()) {
    return;
  }
  if (answer.failed) {
    refuse({awaited_quantity(), std::nan(""), std::nan(""), kUnknown});
  } else if (step_ == Step::kCompare) {
    compare(answer.real());
  } else {
    take_value(answer);
  }
}

void StartUp::compare(double position_rad) noexcept {
  // Feedback answers the stop that left before this read; one that was lost is asked for again.
  if (!seen_) {
    enter(Step::kCompare);
    return;
  }
  double difference = position_rad - feedback_.position_rad;
  if (wraps(options_.position_range_rad)) {
    difference = std::remainder(difference, kWrapRad);
  }
  // Written so that a NaN from the drive is a mismatch.
  if (std::abs(difference) <= kPositionTolerance) {
    ranges_verified_ = true;
    enter(Step::kRead);
  } else if (++looks_ < kMaxLooks) {
    enter(Step::kCompare);
  } else {
    refuse(
        {"position in feedback against mechPos (parameter 0x7019) [rad]", feedback_.position_rad,
         position_rad,
         "correct the drive's position range in the robot file, or bring the joint back into it"});
  }
}

void StartUp::take_value(const ParameterAnswer& answer) noexcept {
  Wanted& wanted = wanted_[step_ == Step::kRead ? read_ : write_];
  // An integer of one byte leaves the others of the value open.
  const Parameter* fact = find_parameter(answer.index);
  const std::uint32_t raw =
      fact != nullptr && fact->value == Value::kU8 ? answer.raw & 0xFFU : answer.raw;
  const double found = value_of(wanted, raw);
  const double expected = value_of(wanted, wanted.raw);
  const bool kept =
      wanted.real ? std::abs(found - expected) <= kRelativeTolerance * expected : found == expected;
  if (!kept && (wanted.fixed || (step_ == Step::kReadBack && writes_ >= kMaxWrites))) {
    refuse({wanted.quantity, found, expected, wanted.fix});
    return;
  }
  if (step_ == Step::kRead && answer.index == static_cast<std::uint16_t>(Index::kTorqueLimit) &&
      !(found <= kMostLimit * options_.torque_range_nm)) {
    refuse({wanted.quantity, found, options_.torque_range_nm, kStronger});
    return;
  }
  wanted.kept = kept;
  if (step_ == Step::kReadBack) {
    next_setting();
    return;
  }
  ++read_;
  enter(read_ < count_ ? Step::kRead : Step::kClearError);
}

void StartUp::next_setting() noexcept {
  while (write_ < count_ && wanted_[write_].kept) {
    ++write_;
    writes_ = 0;
  }
  enter(write_ < count_ ? Step::kWrite : Step::kConfirm);
}

bool StartUp::receive_version(const ReceivedFrame& received) noexcept {
  if (!version_asked_ || received.stamp_ns - version_asked_ns_ > kLateAnswerNs) {
    return false;
  }
  const std::optional<std::uint32_t> version = decode_version(received.frame);
  if (!version) {
    return false;
  }
  heard_ = true;
  firmware_ = *version;
  if (step_ == Step::kVersion && awaiting_) {
    if (static_cast<double>(firmware_) < least_firmware_) {
      refuse({"firmware (version query; 0.0.2.6 is 206)", static_cast<double>(firmware_),
              least_firmware_, "update the drive's firmware, or correct least_firmware"});
    } else {
      enter(Step::kCompare);
    }
  }
  return true;
}

void StartUp::receive_identity() noexcept {
  if (!refused()) {
    restart();
  }
}

void StartUp::receive_feedback(const Feedback& feedback) noexcept {
  heard_ = true;
  feedback_ = feedback;
  const bool running = feedback.mode == kRun;
  switch (step_) {
    case Step::kStop:
      enter(running ? Step::kStop : Step::kVersion);
      break;
    case Step::kVersion:
      if (awaiting_ && ++tries_ >= kMaxLooks) {  // it answers as to any stop: it knows no query
        if (least_firmware_ > 0.0) {
          refuse({"firmware (version query)", std::nan(""), least_firmware_,
                  "the drive does not tell its version: update its firmware"});
        } else {
          enter(Step::kCompare);
        }
      } else {
        awaiting_ = false;
      }
      break;
    case Step::kCompare:
      seen_ = awaiting_;
      break;
    case Step::kClearError: {
      const bool was_held = held_by_error_;
      held_by_error_ = feedback.faults != 0 && (!options_.clear_errors || clears_ >= kMaxClears);
      complaint_ = {};
      if (held_by_error_) {
        complaint_ = {"fault bits of feedback (identifier bits 16 to 21)",
                      static_cast<double>(feedback.faults), 0.0,
                      "remove their cause; then power-cycle the drive, or let clear_errors clear "
                      "them"};
      }
      if (feedback.faults != 0) {
        enter(Step::kClearError);
      } else if (running || was_held) {
        begin_again();
      } else {
        next_setting();
      }
      break;
    }
    case Step::kWrite:
      if (awaiting_) {
        ++writes_;
        enter(Step::kReadBack);
      }
      break;
    case Step::kConfirm:
      if (running) {
        begin_again();
      } else {
        enter(feedback.faults != 0 ? Step::kClearError : Step::kDone);
      }
      break;
    case Step::kSilence:
    case Step::kRead:
    case Step::kReadBack:
    case Step::kDone:
    case Step::kRefused:
      break;
  }
}

}  // namespace geodesic::drivers::robstride
