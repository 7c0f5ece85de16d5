// Zeroes a CiA 402 drive; see zeroing.hpp. Sources: README.md.
#include "drivers/cia402/zeroing.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <cstdlib>
#include <utility>

#include "drivers/cia402/errors.hpp"
#include "drivers/cia402/settings.hpp"

namespace geodesic::drivers::cia402 {

namespace {

constexpr double kToleranceRad = 1e-3;  ///< at the shaft; never less than two increments

std::int32_t sum(std::int32_t a, std::int32_t b) {
  return static_cast<std::int32_t>(static_cast<std::uint32_t>(a) + static_cast<std::uint32_t>(b));
}

}  // namespace

CanopenZeroing::CanopenZeroing(const DriveOptions& options)
    : node_(options.id), tolerance_(2), rad_per_increment_(Units(options).rad_per_increment) {
  tolerance_ = std::max(
      tolerance_, static_cast<std::int32_t>(std::min(kToleranceRad / rad_per_increment_, 1e6)));
}

bool CanopenZeroing::near_zero(std::int32_t position) const {
  return position >= -tolerance_ && position <= tolerance_;
}

void CanopenZeroing::enter(Step step) {
  step_ = step;
  awaiting_ = false;
  tries_ = 0;
}

void CanopenZeroing::refuse(std::string why) {
  report_ = std::move(why);
  enter(Step::kRefused);
}

void CanopenZeroing::give_back(std::string why) {
  report_ = std::move(why);
  enter(Step::kRestore);
}

Frame CanopenZeroing::request() const {
  const auto offset = [this](std::int32_t value) {
    return encode_write(node_, object::kHomeOffset, static_cast<std::uint32_t>(value));
  };
  switch (step_) {
    case Step::kOldOffset:
      return encode_read(node_, object::kHomeOffset);
    case Step::kTryAdding:
    case Step::kTrySubtracting:
      return offset(new_offset_);
    case Step::kRestore:
      return offset(old_offset_);
    case Step::kStore:
      return encode_write(node_, object::kStoreAll, kSave);
    case Step::kFirstPosition:
    case Step::kSecondPosition:
    case Step::kLookAdded:
    case Step::kLookSubtracted:
    case Step::kReadBack:
      return encode_read(node_, object::kPosition);
    case Step::kState:
    case Step::kDone:
    case Step::kRefused:
      break;
  }
  return encode_read(node_, object::kStatusword);
}

std::optional<Frame> CanopenZeroing::transmit(std::int64_t now_ns) {
  const std::int64_t patience = step_ == Step::kStore ? kStorePatienceNs : kPatienceNs;
  if (step_ == Step::kSecondPosition && !awaiting_ && tries_ == 0) {
    not_before_ns_ = not_before_ns_ == 0 ? now_ns + kStandstillNs : not_before_ns_;
    if (now_ns < not_before_ns_) {
      return std::nullopt;
    }
  }
  if (over() || (awaiting_ && now_ns - asked_ns_ < patience)) {
    return std::nullopt;
  }
  if (tries_++ == kMaxTries) {
    refuse(
        fmt::format("node {} does not answer: is it on this bus, and is its supply on?{}", node_,
                    step_ == Step::kRestore ? " Its home offset (0x607C) may have changed." : ""));
    return std::nullopt;
  }
  awaiting_ = true;
  asked_ns_ = now_ns;
  return request();
}

void CanopenZeroing::receive(const ReceivedFrame& received) {
  const std::optional<Sdo> reply = decode_sdo_reply(received.frame);
  if (!reply || !awaiting_ || over() || received.frame.id != cob::kSdoReply + node_) {
    return;
  }
  const std::optional<Sdo> asked = decode_sdo_request(request());
  if (reply->index != asked->index || reply->sub != asked->sub) {
    return;
  }
  if (reply->kind != Sdo::Kind::kAbort) {
    take(*reply);
    return;
  }
  const char* meaning = abort_meaning(reply->value);
  const std::string what = fmt::format("0x{:04X}:{}: {}", reply->index, reply->sub, meaning);
  switch (step_) {
    case Step::kStore:
      give_back(
          fmt::format("the zero would be lost at power-off, so it was taken back: the drive "
                      "does not store it, {}",
                      what));
      break;
    case Step::kTrySubtracting:
      give_back(what);
      break;
    default:
      refuse(fmt::format("{}. Zero it with the maker's tool (homing method 35 or 37)", what));
      break;
  }
}

void CanopenZeroing::take_state(std::uint16_t statusword) {
  const std::optional<PowerState> state = power_state(statusword);
  if (state == PowerState::kFault || state == PowerState::kFaultReaction) {
    refuse("the drive has an error (0x6041): remove its cause and clear it first");
  } else if (!state || state == PowerState::kEnabled || state == PowerState::kQuickStop) {
    refuse(fmt::format("the drive is enabled (0x6041 is 0x{:04X}): stop what drives it first",
                       statusword));
  } else {
    enter(Step::kFirstPosition);
  }
}

void CanopenZeroing::take(const Sdo& reply) {
  const auto value = static_cast<std::int32_t>(reply.value);
  switch (step_) {
    case Step::kState:
      take_state(static_cast<std::uint16_t>(reply.value));
      break;
    case Step::kFirstPosition:
      position_ = value;
      enter(Step::kSecondPosition);
      break;
    case Step::kSecondPosition:
      if (!near_zero(static_cast<std::int32_t>(static_cast<std::uint32_t>(value) -
                                               static_cast<std::uint32_t>(position_)))) {
        refuse(fmt::format("the joint moves (0x6064 went from {} to {}): hold it still", position_,
                           value));
        break;
      }
      position_ = value;
      before_rad_ = value * rad_per_increment_;
      enter(Step::kOldOffset);
      break;
    case Step::kOldOffset:
      old_offset_ = value;
      new_offset_ = sum(old_offset_, position_);
      enter(near_zero(position_) ? Step::kStore : Step::kTryAdding);
      new_offset_ = near_zero(position_) ? old_offset_ : new_offset_;
      break;
    case Step::kTryAdding:
      enter(Step::kLookAdded);
      break;
    case Step::kLookAdded:
      if (near_zero(value)) {
        enter(Step::kStore);
      } else {
        new_offset_ = sum(old_offset_, -position_);
        enter(Step::kTrySubtracting);
      }
      break;
    case Step::kTrySubtracting:
      enter(Step::kLookSubtracted);
      break;
    case Step::kLookSubtracted:
      if (near_zero(value)) {
        enter(Step::kStore);
      } else {
        give_back(
            "this drive's home offset (0x607C) acts only by homing, for which it would have to be "
            "enabled; nothing was changed. Zero it with the maker's tool (homing method 35 or 37)");
      }
      break;
    case Step::kStore:
      enter(Step::kReadBack);
      break;
    case Step::kReadBack:
      after_rad_ = value * rad_per_increment_;
      if (near_zero(value)) {
        report_ = fmt::format(
            "node {} stood at {} increments ({:.6g} rad) and stands at {} now; its home offset "
            "(0x607C) went from {} to {} and is stored",
            node_, position_, position_ * rad_per_increment_, value, old_offset_, new_offset_);
        enter(Step::kDone);
      } else {
        refuse(fmt::format("after it was stored, 0x6064 reads {}: was the joint moved?", value));
      }
      break;
    case Step::kRestore:
      enter(Step::kRefused);
      break;
    case Step::kDone:
    case Step::kRefused:
      break;
  }
}

}  // namespace geodesic::drivers::cia402
