// Parameters with an endpoint, one after the other; see parameters.hpp. Sources: README.md.
#include "drivers/odrive/parameters.hpp"

#include <algorithm>
#include <array>
#include <cmath>

namespace geodesic::drivers::odrive {

namespace {

struct Fact {
  const char* quantity;
  const char* fix;
  double most;  ///< beyond this, or below 0, the endpoint is not what it is taken for
  bool writable;
};

constexpr double kTolerance = 1e-3;  ///< relative: float32 and rounded figures in files
constexpr const char* kNotTaken = "the drive does not take this value: check its firmware";
constexpr const char* kWrongEndpoint =
    "this is no such value: look the endpoint id up in the flat_endpoints.json of the drive's very "
    "firmware, and correct it in the robot file";
constexpr const char* kNoAnswer =
    "the drive does not answer for this endpoint: look its id up in flat_endpoints.json";

/// In the order of Parameter.
constexpr std::array<Fact, kParameterCount> kFacts = {
    Fact{"axis0.config.watchdog_timeout [s]", kNotTaken, 3600.0, true},
    Fact{"axis0.config.enable_watchdog", kNotTaken, 1.0, true},
    Fact{"axis0.config.can.encoder_msg_rate_ms [ms]", kNotTaken, 65535.0, true},
    Fact{"axis0.config.can torque or iq msg_rate_ms [ms]", kNotTaken, 65535.0, true},
    Fact{"axis0.config.can.heartbeat_msg_rate_ms [ms]", kNotTaken, 65535.0, true},
    Fact{"axis0.config.motor.torque_constant [N·m/A]",
         "correct torque_constant_nm_a in the robot file, or the drive's torque constant", 1e3,
         false},
};

bool equal(double found, double wanted) noexcept {
  return std::abs(found - wanted) <= kTolerance * std::abs(wanted);
}

}  // namespace

ParameterCheck::ParameterCheck(const DriveOptions& options) noexcept
    : node_(options.id),
      watchdog_s_(static_cast<double>(options.watchdog_ns) * 1e-9),
      settings_(options) {
  restart(period_ns_);
}

void ParameterCheck::restart(std::int64_t period_ns) noexcept {
  period_ns_ = std::max<std::int64_t>(period_ns, 1);
  at_ = 0;
  writing_ = false;
  awaiting_ = false;
  settled_ns_ = 0;
  reads_ = 0;
  writes_ = 0;
  complaint_ = {};
  skip_unwanted();
}

bool ParameterCheck::covers_watchdog() const noexcept {
  return wanted(Parameter::kWatchdogTimeout) && wanted(Parameter::kEnableWatchdog);
}

bool ParameterCheck::wanted(Parameter parameter) const noexcept {
  if (settings_.firmware == Firmware::k05 || !settings_.knows(parameter)) {
    return false;
  }
  switch (parameter) {
    case Parameter::kEncoderRate:
      return !settings_.by_request;
    case Parameter::kTorqueRate:
      return settings_.cyclic_torque();
    default:
      return true;
  }
}

double ParameterCheck::target(Parameter parameter) const noexcept {
  switch (parameter) {
    case Parameter::kWatchdogTimeout:
      return watchdog_s_;
    case Parameter::kEnableWatchdog:
      return 1.0;
    case Parameter::kEncoderRate:
    case Parameter::kTorqueRate:
      // Whole milliseconds; a control period of less than one is more than the drive can do.
      return std::max(1.0, std::floor(static_cast<double>(period_ns_) * 1e-6 + 1e-3));
    case Parameter::kHeartbeatRate:
      return kQuickHeartbeatMs;
    case Parameter::kTorqueConstant:
      return settings_.torque_constant_nm_a;
  }
  return 0.0;
}

void ParameterCheck::skip_unwanted() noexcept {
  while (at_ < kParameterCount && !wanted(static_cast<Parameter>(at_))) {
    ++at_;
  }
}

void ParameterCheck::next() noexcept {
  ++at_;
  reads_ = 0;
  writes_ = 0;
  skip_unwanted();
}

void ParameterCheck::refuse(double found, const char* fix) noexcept {
  complaint_ = {kFacts[at_].quantity, found, target(static_cast<Parameter>(at_)), fix};
}

std::optional<Frame> ParameterCheck::request(std::int64_t now_ns) noexcept {
  if (done() || refused() || now_ns < settled_ns_ ||
      (awaiting_ && now_ns - asked_ns_ < kReplyTimeoutNs)) {
    return std::nullopt;
  }
  const auto parameter = static_cast<Parameter>(at_);
  if (writing_) {
    writing_ = false;
    settled_ns_ = now_ns + kSettleNs;
    return encode_sdo_write(node_, settings_.endpoint[at_], kParameterTypes[at_],
                            target(parameter));
  }
  if (++reads_ > kMaxReads) {
    refuse(std::nan(""), kNoAnswer);
    return std::nullopt;
  }
  awaiting_ = true;
  asked_ns_ = now_ns;
  return encode_sdo_read(node_, settings_.endpoint[at_]);
}

void ParameterCheck::receive(const ReceivedFrame& received) noexcept {
  if (done() || !awaiting_ || command_of(received.frame) != Command::kTxSdo) {
    return;
  }
  const std::optional<Sdo> answer = decode_sdo(received.frame);
  if (!answer || answer->endpoint != settings_.endpoint[at_] || answer->bytes == 0) {
    return;
  }
  awaiting_ = false;
  const double found = sdo_value(*answer, kParameterTypes[at_]);
  const Fact& fact = kFacts[at_];
  const double wanted_value = target(static_cast<Parameter>(at_));
  if (!(found >= 0.0 && found <= fact.most)) {  // NaN among them
    refuse(found, kWrongEndpoint);
  } else if (equal(found, wanted_value)) {
    next();
  } else if (!fact.writable || writes_ == kMaxWrites) {
    refuse(found, fact.fix);
  } else {
    ++writes_;
    writing_ = true;
  }
}

}  // namespace geodesic::drivers::odrive
