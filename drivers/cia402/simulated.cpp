// A CiA 402 drive as the bus sees it; see simulated.hpp. Sources and what is assumed: README.md.
#include "drivers/cia402/simulated.hpp"

#include <algorithm>
#include <cmath>
#include <numbers>

#include "drivers/cia402/errors.hpp"
#include "drivers/cia402/settings.hpp"

namespace geodesic::drivers::cia402 {

namespace {

constexpr double kOverTemperature = 100.0;
constexpr std::uint16_t kCommunication = 0x8100;
constexpr std::int64_t kMillisecond = 1'000'000;
constexpr std::uint32_t kModes = 1U << 5 | 1U << 7 | kCyclicTorqueBit;  // homing, position, torque
constexpr std::uint32_t kVendorOfTheSimulated = 0x47454F;
constexpr double kTurn = 2.0 * std::numbers::pi;

/// Byte by byte, unlike the codec.
void put_little(Frame& frame, std::size_t at, std::size_t bytes, std::uint32_t value) {
  for (std::size_t i = 0; i < bytes; ++i, value /= 256U) {
    frame.data[at + i] = static_cast<std::uint8_t>(value % 256U);
  }
}

}  // namespace

Simulated::Simulated(const DriveOptions& options) : node_(options.id) {
  const double gear = number(options, Setting::kGearMotor) / number(options, Setting::kGearShaft);
  const bool encoder_at_motor = choice<Side>(options, Setting::kEncoderAt) == Side::kMotor;
  const double encoder_turns = encoder_at_motor ? gear : 1.0;
  turn_rad_ = kTurn / encoder_turns;
  increments_per_rad_ = encoder_turns * number(options, Setting::kEncoderIncrements) /
                        (kTurn * number(options, Setting::kEncoderRevolutions));
  keeps_turns_ = choice<Turns>(options, Setting::kEncoderTurns) == Turns::kKept;
  const double rpm = encoder_turns * 60.0 / kTurn;
  switch (choice<VelocityUnit>(options, Setting::kVelocityUnit)) {
    case VelocityUnit::kFromPosition:
    case VelocityUnit::kIncrementsPerSecond:
      velocity_per_rad_s_ = increments_per_rad_;
      break;
    case VelocityUnit::kRpm:
      velocity_per_rad_s_ = rpm;
      break;
    case VelocityUnit::kTenthRpm:
      velocity_per_rad_s_ = rpm * 10.0;
      break;
    case VelocityUnit::kMilliRpm:
      velocity_per_rad_s_ = rpm * 1000.0;
      break;
  }
  rated_nm_ = number(options, Setting::kRatedTorque) / 1000.0;
  if (choice<Side>(options, Setting::kRatedTorqueAt) == Side::kMotor) {
    rated_nm_ *= gear;
  }
  fill_dictionary(options);
}

void Simulated::fill_dictionary(const DriveOptions& options) {
  using Access = Dictionary::Access;
  Dictionary& d = dictionary_;
  d.add(object::kDeviceType, Access::kConstant, 0x00020000U | kDeviceProfile);
  d.add(object::kErrorRegister, Access::kReadOnly, 0);
  d.add({0x1010, 0, 1}, Access::kConstant, 1);
  d.add(object::kStoreAll, Access::kReadWrite, 1);
  d.add({0x1016, 0, 1}, Access::kConstant, 1);
  d.add(object::kConsumerHeartbeat, Access::kReadWrite, 0);
  d.add(object::kProducerHeartbeat, Access::kReadWrite, 0);
  d.add({0x1018, 0, 1}, Access::kConstant, 4);
  const auto or_else = [&options](Setting setting, std::uint32_t value) {
    const std::uint32_t wanted = integer(options, setting);
    return wanted == 0 ? value : wanted;
  };
  d.add(object::kVendor, Access::kConstant, or_else(Setting::kVendor, kVendorOfTheSimulated));
  d.add(object::kProduct, Access::kConstant, or_else(Setting::kProduct, 402));
  d.add(object::kRevision, Access::kConstant, or_else(Setting::kLeastRevision, 0x00010002));
  d.add({0x1018, 4, 4}, Access::kConstant, 1000 + options.id);
  d.add({0x1029, 0, 1}, Access::kConstant, 1);
  d.add(object::kErrorBehaviour, Access::kReadWrite, 0);
  d.add(object::kAbortConnection, Access::kReadWrite, 0, true);
  d.add(object::kErrorCode, Access::kReadOnly, 0);
  d.add(object::kControlword, Access::kReadWrite, 0);
  d.add(object::kStatusword, Access::kReadOnly, 0);
  d.add(object::kQuickStop, Access::kReadWrite, 2, true);
  d.add(object::kMode, Access::kReadWrite, 8, true);
  d.add(object::kModeDisplay, Access::kReadOnly, 8);
  d.add(object::kPosition, Access::kReadOnly, 0);
  d.add(object::kVelocity, Access::kReadOnly, 0);
  d.add(object::kTargetTorque, Access::kReadWrite, 0);
  d.add(object::kMaxTorque, Access::kReadWrite, 1000, true);
  d.add(object::kRatedTorque, Access::kReadOnly, integer(options, Setting::kRatedTorque));
  d.add(object::kActualTorque, Access::kReadOnly, 0);
  d.add(object::kHomeOffset, Access::kReadWrite, 0, true);
  d.add(object::kMaxSpeed, Access::kReadWrite,
        static_cast<std::uint32_t>(
            std::clamp(options.velocity_range_rad_s * number(options, Setting::kGearMotor) /
                           number(options, Setting::kGearShaft) * 60.0 / kTurn,
                       1.0, 1e6)),
        true);
  d.add({0x608F, 0, 1}, Access::kConstant, 2);
  d.add(object::kEncoderIncrements, Access::kReadOnly,
        integer(options, Setting::kEncoderIncrements));
  d.add(object::kEncoderRevolutions, Access::kReadOnly,
        integer(options, Setting::kEncoderRevolutions));
  d.add({0x6091, 0, 1}, Access::kConstant, 2);
  d.add(object::kGearMotor, Access::kReadOnly, integer(options, Setting::kGearMotor));
  d.add(object::kGearShaft, Access::kReadOnly, integer(options, Setting::kGearShaft));
  d.add(object::kSupportedModes, Access::kConstant, kModes);
}

void Simulated::power_cycle() {
  dictionary_.power_on();
  power_ = PowerState::kSwitchOnDisabled;
  controlword_ = 0;
  emergencies_due_ = 0;
  find_position();
  boot();
  if (heats()) {
    fall_into_fault(emergency::kDriveTemperature);
  }
}

/// The encoder of a drive without turn counter knows the angle within one revolution.
void Simulated::find_position() {
  turns_rad_ = keeps_turns_ ? 0.0 : -turn_rad_ * std::floor(shaft_rad_ / turn_rad_);
}

void Simulated::boot() {
  nmt_ = NmtState::kBootUp;
  boot_up_due_ = true;
  heartbeat_watched_ = false;
  torque_watched_ = false;
  pending_due_ = false;
}

bool Simulated::heats() const {
  return celsius_ > kOverTemperature;
}

void Simulated::set_shaft(double position_rad, double velocity_rad_s) {
  shaft_rad_ = position_rad;
  shaft_rad_s_ = velocity_rad_s;
}

void Simulated::set_temperature(double celsius) {
  celsius_ = celsius;
  if (heats() && power_ != PowerState::kFault) {
    fall_into_fault(emergency::kDriveTemperature);
  }
}

void Simulated::inject_error(std::uint8_t code) {
  if (code != 0) {
    fall_into_fault(emergency_of(code));
  }
}

void Simulated::fall_into_fault(std::uint16_t code) {
  power_ = PowerState::kFault;
  dictionary_.set(object::kTargetTorque, 0);
  dictionary_.set(object::kErrorCode, code);
  emergency(code);
}

void Simulated::emergency(std::uint16_t code) {
  dictionary_.set(object::kErrorRegister, code == emergency::kNone ? 0 : 1);
  if (emergencies_due_ < kMostEmergencies) {
    emergencies_[emergencies_due_++] = code;
  }
}

void Simulated::watch(std::int64_t now_ns) {
  const std::int64_t heartbeat_ms = dictionary_.value(object::kConsumerHeartbeat) & 0xFFFFU;
  if (heartbeat_watched_ && heartbeat_ms > 0 &&
      now_ns - last_heartbeat_ns_ > heartbeat_ms * kMillisecond) {
    heartbeat_watched_ = false;  // until the host is heard again
    lose_connection(emergency::kHeartbeat);
    if (nmt_ == NmtState::kOperational && dictionary_.value(object::kErrorBehaviour) == 0) {
      nmt_ = NmtState::kPreOperational;
    }
  }
  const std::int64_t torque_ms = dictionary_.value(object::kReceiveTimer);
  if (torque_watched_ && torque_ms > 0 && nmt_ == NmtState::kOperational &&
      now_ns - last_torque_ns_ > torque_ms * kMillisecond) {
    torque_watched_ = false;
    lose_connection(emergency::kReceiveTimeOut);
  }
}

/// 0x6007 says what becomes of a drive in operation; others only complain.
void Simulated::lose_connection(std::uint16_t code) {
  const bool active = power_ == PowerState::kEnabled || power_ == PowerState::kQuickStop;
  const auto reaction = static_cast<Reaction>(dictionary_.value(object::kAbortConnection));
  if (active && reaction == Reaction::kFault) {
    fall_into_fault(code);
    return;
  }
  if (code != kCommunication) {
    emergency(code);
  }
  if (active && reaction == Reaction::kDisableVoltage) {
    power_ = PowerState::kSwitchOnDisabled;
  } else if (active && reaction == Reaction::kQuickStop) {
    quick_stop();
  }
}

void Simulated::leave_operational(NmtState state) {
  if (nmt_ == NmtState::kOperational) {
    lose_connection(kCommunication);
  }
  nmt_ = state;
  pending_due_ = false;
  torque_watched_ = false;
}

double Simulated::torque_nm(std::int64_t now_ns) {
  watch(now_ns);
  if (!enabled() || dictionary_.signed_value(object::kModeDisplay) != kCyclicTorque) {
    return 0.0;
  }
  const auto limit = static_cast<std::int32_t>(dictionary_.value(object::kMaxTorque));
  const std::int32_t wanted = dictionary_.signed_value(object::kTargetTorque);
  return std::clamp(wanted, -limit, limit) * rated_nm_ / 1000.0;
}

Frame Simulated::frame_of(std::uint32_t id, std::uint8_t length) const {
  Frame frame;
  frame.id = id;
  frame.length = length;
  return frame;
}

std::size_t Simulated::speak(std::int64_t now_ns, std::span<Frame> out) {
  watch(now_ns);
  std::size_t count = 0;
  if (boot_up_due_ && count < out.size()) {
    boot_up_due_ = false;
    nmt_ = NmtState::kPreOperational;
    out[count++] = frame_of(cob::kHeartbeat + node_, 1);
    next_heartbeat_ns_ = now_ns;
  }
  if (nmt_ == NmtState::kBootUp) {
    return count;
  }
  while (emergencies_due_ > 0 && count < out.size()) {
    Frame frame = frame_of(cob::kEmergency + node_, 8);
    put_little(frame, 0, 2, emergencies_[0]);
    frame.data[2] = static_cast<std::uint8_t>(dictionary_.value(object::kErrorRegister));
    out[count++] = frame;
    --emergencies_due_;
    std::copy_n(emergencies_.begin() + 1, emergencies_due_, emergencies_.begin());
  }
  const std::int64_t period_ms = dictionary_.value(object::kProducerHeartbeat);
  if (period_ms > 0 && now_ns >= next_heartbeat_ns_ && count < out.size()) {
    next_heartbeat_ns_ = now_ns + period_ms * kMillisecond;
    Frame frame = frame_of(cob::kHeartbeat + node_, 1);
    frame.data[0] = static_cast<std::uint8_t>(nmt_);
    out[count++] = frame;
  }
  return count;
}

std::size_t Simulated::receive(const Frame& frame, std::int64_t now_ns, std::span<Frame> out) {
  if (frame.error || frame.extended || frame.fd || frame.remote || out.empty()) {
    return 0;
  }
  watch(now_ns);
  const std::uint32_t watched = dictionary_.value(object::kConsumerHeartbeat) >> 16U & 0x7FU;
  if (frame.id == cob::kNmt) {
    obey_nmt(frame);
  } else if (frame.id == cob::kHeartbeat + watched && frame.length == 1) {
    heartbeat_watched_ = true;
    last_heartbeat_ns_ = now_ns;
  } else if (frame.id == cob::kSdoRequest + node_ && frame.length == 8 &&
             (nmt_ == NmtState::kPreOperational || nmt_ == NmtState::kOperational) &&
             frame.data[0] != sdo::kAbort) {
    serve_sdo(frame, out[0]);
    return 1;
  } else if (nmt_ == NmtState::kOperational) {
    if (frame.id == cob::kSync) {
      put_in_force();
      return report(out);
    }
    if (frame.id == dictionary_.value(object::kReceiveId)) {
      take_process_data(frame, now_ns);
    }
  }
  return 0;
}

void Simulated::obey_nmt(const Frame& frame) {
  if (frame.length != 2 || (frame.data[1] != 0 && frame.data[1] != node_) || boot_up_due_) {
    return;
  }
  switch (static_cast<NmtCommand>(frame.data[0])) {
    case NmtCommand::kStart:
      nmt_ = NmtState::kOperational;
      break;
    case NmtCommand::kStop:
      leave_operational(NmtState::kStopped);
      break;
    case NmtCommand::kPreOperational:
      leave_operational(NmtState::kPreOperational);
      break;
    case NmtCommand::kResetNode:
      leave_operational(NmtState::kPreOperational);
      power_cycle();
      break;
    case NmtCommand::kResetCommunication:
      leave_operational(NmtState::kPreOperational);
      dictionary_.reset_communication();
      boot();
      break;
  }
}

}  // namespace geodesic::drivers::cia402
