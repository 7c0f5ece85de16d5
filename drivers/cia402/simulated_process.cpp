// What a simulated CiA 402 drive does with objects and process data: SDO server, mapped PDOs, power
// state machine; see simulated.hpp. Time and NMT are in simulated.cpp.
#include <algorithm>
#include <cmath>

#include "drivers/cia402/simulated.hpp"

namespace geodesic::drivers::cia402 {

namespace {

constexpr std::uint16_t kSwitchOnBit = 0x01;
constexpr std::uint16_t kVoltageBit = 0x02;
constexpr std::uint16_t kNoQuickStopBit = 0x04;
constexpr std::uint16_t kEnableBit = 0x08;
constexpr std::uint32_t kFirstStayingQuickStop = 5;
constexpr std::uint32_t kLastQuickStop = 8;

std::uint32_t gather(const Frame& frame, std::size_t at, std::size_t bytes) {
  std::uint32_t value = 0;
  for (std::size_t i = 0; i < bytes; ++i) {
    value += static_cast<std::uint32_t>(frame.data[at + i]) << 8U * i;
  }
  return value;
}

void scatter(Frame& frame, std::size_t at, std::size_t bytes, std::uint32_t value) {
  for (std::size_t i = 0; i < bytes; ++i) {
    frame.data[at + i] = static_cast<std::uint8_t>(value >> 8U * i & 0xFFU);
  }
}

/// As an int32 counts: around.
std::uint32_t around(double count) {
  constexpr double kSpan = 4294967296.0;
  const double whole = std::floor(count);
  return static_cast<std::uint32_t>(whole - kSpan * std::floor(whole / kSpan));
}

Object mapped(std::uint32_t entry) {
  return {static_cast<std::uint16_t>(entry >> 16U), static_cast<std::uint8_t>(entry >> 8U & 0xFFU),
          static_cast<std::uint8_t>((entry & 0xFFU) / 8U)};
}

}  // namespace

void Simulated::serve_sdo(const Frame& frame, Frame& out) {
  const auto index = static_cast<std::uint16_t>(gather(frame, 1, 2));
  const std::uint8_t sub = frame.data[3];
  out = frame_of(cob::kSdoReply + node_, 8);
  std::copy_n(frame.data.begin() + 1, 3, out.data.begin() + 1);
  std::optional<Abort> why;
  const std::uint8_t command = frame.data[0];
  if (command >> 5U == 2) {
    measure();
    Object found;
    why = dictionary_.read(index, sub, found);
    if (!why) {
      out.data[0] = static_cast<std::uint8_t>(0x43 + 4 * (4 - found.bytes));
      scatter(out, 4, found.bytes, dictionary_.value(found));
    }
  } else if (command >> 5U == 1 && (command & 2U) != 0) {
    why = write(frame, index, sub);
    out.data[0] = sdo::kWriteReply;
  } else {
    why = Abort::kCommand;  // neither segments nor blocks are simulated
  }
  if (why) {
    out.data[0] = sdo::kAbort;
    scatter(out, 4, 4, static_cast<std::uint32_t>(*why));
  }
}

std::optional<Abort> Simulated::write(const Frame& frame, std::uint16_t index, std::uint8_t sub) {
  const bool sized = (frame.data[0] & 1U) != 0;
  const auto bytes = static_cast<std::uint8_t>(sized ? 4U - (frame.data[0] >> 2U & 3U) : 0U);
  const std::uint32_t value = gather(frame, 4, sized ? bytes : 4U);
  Object found;
  if (const std::optional<Abort> why = dictionary_.read(index, sub, found)) {
    return why;
  }
  if (index == object::kMode.index) {
    if (value > 31 || value == 0 ||
        (dictionary_.value(object::kSupportedModes) >> (value - 1) & 1U) == 0) {
      return Abort::kRange;
    }
  }
  if (index == object::kAbortConnection.index && value > 3) {
    return Abort::kRange;
  }
  if (index == object::kQuickStop.index && value > kLastQuickStop) {
    return Abort::kRange;
  }
  if (index == object::kStoreAll.index && sub == object::kStoreAll.sub) {
    if (value != kSave) {
      return Abort::kNotStored;
    }
    if (enabled()) {
      return Abort::kDeviceState;
    }
    dictionary_.store();
    return std::nullopt;
  }
  const std::optional<Abort> why = dictionary_.write(index, sub, bytes, value);
  if (!why && index == object::kMode.index) {
    dictionary_.set(object::kModeDisplay, value);
  }
  if (!why && index == object::kControlword.index) {
    obey(static_cast<std::uint16_t>(value));
  }
  return why;
}

void Simulated::take_process_data(const Frame& frame, std::int64_t now_ns) {
  std::uint32_t bytes = 0;
  for (std::uint32_t i = 1; i <= dictionary_.value(object::kReceiveCount); ++i) {
    bytes +=
        mapped(dictionary_.value({object::kReceiveCount.index, static_cast<std::uint8_t>(i), 4}))
            .bytes;
  }
  if (frame.length < bytes) {
    emergency(emergency::kPdoLength);
    return;
  }
  torque_watched_ = true;
  last_torque_ns_ = now_ns;
  pending_ = frame;
  pending_due_ = true;
  if (dictionary_.value(object::kReceiveType) > kTypeLastCyclic) {
    put_in_force();
  }
}

void Simulated::put_in_force() {
  if (!pending_due_) {
    return;
  }
  pending_due_ = false;
  std::size_t at = 0;
  std::optional<std::uint16_t> controlword;
  for (std::uint32_t i = 1; i <= dictionary_.value(object::kReceiveCount); ++i) {
    const Object object =
        mapped(dictionary_.value({object::kReceiveCount.index, static_cast<std::uint8_t>(i), 4}));
    const std::uint32_t value = gather(pending_, at, object.bytes);
    at += object.bytes;
    dictionary_.set(object, value);
    if (object.index == object::kControlword.index) {
      controlword = static_cast<std::uint16_t>(value);
    }
  }
  if (controlword) {
    obey(*controlword);
  }
}

std::size_t Simulated::report(std::span<Frame> out) {
  measure();
  std::size_t count = 0;
  for (std::uint16_t pdo = 0; pdo < syncs_.size() && count < out.size(); ++pdo) {
    const auto of_pdo = [pdo](Object object, std::uint32_t sub) {
      return Object{static_cast<std::uint16_t>(object.index + pdo), static_cast<std::uint8_t>(sub),
                    object.bytes};
    };
    const std::uint32_t id = dictionary_.value(of_pdo(object::kTransmitId, 1));
    const std::uint32_t type = dictionary_.value(of_pdo(object::kTransmitType, 2));
    if ((id & cob::kInvalid) != 0 || type == 0 || type > kTypeLastCyclic || ++syncs_[pdo] < type) {
      continue;
    }
    syncs_[pdo] = 0;
    Frame frame = frame_of(id & 0x7FFU, 0);
    const std::uint32_t objects = dictionary_.value(of_pdo(object::kTransmitCount, 0));
    for (std::uint32_t i = 1; i <= objects; ++i) {
      const Object object = mapped(dictionary_.value(of_pdo(object::kTransmitCount, i)));
      scatter(frame, frame.length, object.bytes, dictionary_.value(object));
      frame.length = static_cast<std::uint8_t>(frame.length + object.bytes);
    }
    out[count++] = frame;
  }
  return count;
}

void Simulated::measure() {
  double counted = (shaft_rad_ + turns_rad_) * increments_per_rad_;
  const std::int32_t offset = dictionary_.signed_value(object::kHomeOffset);
  if (home_offset_ == HomeOffset::kSubtracted) {
    counted -= offset;
  } else if (home_offset_ == HomeOffset::kAdded) {
    counted += offset;
  }
  // A hair above, so that an angle that is a whole number of increments is not one less.
  dictionary_.set(object::kPosition, around(counted + 1e-6));
  dictionary_.set(object::kVelocity,
                  around(std::trunc(std::clamp(shaft_rad_s_ * velocity_per_rad_s_, -2e9, 2e9))));
  const auto limit = static_cast<std::int32_t>(dictionary_.value(object::kMaxTorque));
  const bool torque = enabled() && dictionary_.signed_value(object::kModeDisplay) == kCyclicTorque;
  const std::int32_t wanted = dictionary_.signed_value(object::kTargetTorque);
  dictionary_.set(object::kActualTorque,
                  static_cast<std::uint32_t>(torque ? std::clamp(wanted, -limit, limit) : 0));
  dictionary_.set(object::kStatusword, statusword());
}

std::uint16_t Simulated::statusword() const {
  unsigned word = kRemote | kVoltageEnabled;
  switch (power_) {
    case PowerState::kNotReady:
      break;
    case PowerState::kSwitchOnDisabled:
      word |= 0x40U;
      break;
    case PowerState::kReady:
      word |= 0x21U;
      break;
    case PowerState::kSwitchedOn:
      word |= 0x23U;
      break;
    case PowerState::kEnabled:
      word |= 0x27U | kFollows;
      break;
    case PowerState::kQuickStop:
      word |= 0x07U;
      break;
    case PowerState::kFaultReaction:
      word |= 0x0FU;
      break;
    case PowerState::kFault:
      word |= 0x08U;
      break;
  }
  const std::uint32_t wanted =
      static_cast<std::uint32_t>(std::abs(dictionary_.signed_value(object::kTargetTorque)));
  if (power_ == PowerState::kEnabled && wanted > dictionary_.value(object::kMaxTorque)) {
    word |= kInternalLimit;
  }
  return static_cast<std::uint16_t>(word);
}

void Simulated::quick_stop() {
  const bool stays = dictionary_.value(object::kQuickStop) >= kFirstStayingQuickStop;
  power_ = stays ? PowerState::kQuickStop : PowerState::kSwitchOnDisabled;
}

/// One transition for one controlword.
void Simulated::obey(std::uint16_t controlword) {
  const bool reset =
      (controlword & ~controlword_ & control_word::kFaultReset) != 0;  // its rising edge
  controlword_ = controlword;
  const bool on = (controlword & kSwitchOnBit) != 0;
  const bool enable = on && (controlword & kEnableBit) != 0;
  if (power_ == PowerState::kFault || power_ == PowerState::kFaultReaction) {
    if (reset && !heats()) {
      power_ = PowerState::kSwitchOnDisabled;
      dictionary_.set(object::kErrorCode, emergency::kNone);
      emergency(emergency::kNone);
    }
  } else if ((controlword & kVoltageBit) == 0) {
    power_ = PowerState::kSwitchOnDisabled;
  } else if ((controlword & kNoQuickStopBit) == 0) {
    if (power_ == PowerState::kEnabled) {
      quick_stop();
    } else if (power_ != PowerState::kQuickStop) {
      power_ = PowerState::kSwitchOnDisabled;
    }
  } else if (!on) {
    power_ = power_ == PowerState::kQuickStop ? power_ : PowerState::kReady;
  } else if (!enable) {
    if (power_ == PowerState::kReady || power_ == PowerState::kEnabled) {
      power_ = PowerState::kSwitchedOn;
    }
  } else if (power_ == PowerState::kSwitchedOn || power_ == PowerState::kQuickStop) {
    power_ = PowerState::kEnabled;
  }
}

}  // namespace geodesic::drivers::cia402
