// Looking for RobStride and CyberGear drives; see scanner.hpp for what it promises.
#include "drivers/robstride/scanner.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <string>
#include <utility>

namespace geodesic::drivers::robstride {

namespace {

constexpr std::uint8_t kScanningHost = 0xFD;

/// Scaling by model, after the manuals: a drive tells neither, but after power-on its limit_torque
/// is the model's torque range. A hint for people and nothing else. Source: README.md.
struct ModelScaling {
  double torque_nm;
  double position_rad;
  double velocity_rad_s;
  double stiffness_nm_rad;
  double damping_nm_s_rad;
  const char* model;
};
constexpr std::array kModels = {
    ModelScaling{5.5, 12.57, 50, 500, 5, "RS05 or EL05"},
    ModelScaling{6, 12.57, 50, 500, 5, "EL05"},
    ModelScaling{12, 12.5, 30, 500, 5, "CyberGear"},
    ModelScaling{14, 12.57, 33, 500, 5, "RS00"},
    ModelScaling{17, 12.57, 44, 500, 5, "RS01 or RS02"},
    ModelScaling{36, 12.57, 50, 5000, 100, "RS06"},
    ModelScaling{60, 12.57, 20, 5000, 100, "RS03"},
    ModelScaling{120, 12.57, 15, 5000, 100, "RS04"},
};

std::optional<ParameterAnswer> value_of(const std::map<Index, ParameterAnswer>& parameters,
                                        Index index) {
  const auto found = parameters.find(index);
  return found == parameters.end() || found->second.failed ? std::nullopt
                                                           : std::optional(found->second);
}

}  // namespace

std::optional<Frame> Scanner::transmit(std::int64_t now_ns) {
  if (over_) {
    return std::nullopt;
  }
  if (asked_ < kRounds * kLastMotor) {
    asked_ns_ = now_ns;
    const auto motor = static_cast<std::uint8_t>(asked_++ % kLastMotor + 1U);
    return encode_get_id({.motor = motor, .host = kScanningHost});
  }
  if (!settled_) {
    if (now_ns - asked_ns_ < kSettleNs) {
      return std::nullopt;
    }
    settled_ = true;
    drive_ = drives_.begin();
  } else if (awaiting_) {
    if (now_ns - asked_ns_ < kDetailNs) {
      return std::nullopt;
    }
    if (++tries_ == kTries) {
      next_detail();
    }
  }
  if (drive_ == drives_.end()) {
    over_ = true;
    return std::nullopt;
  }
  awaiting_ = true;
  asked_ns_ = now_ns;
  return encode_read({.motor = drive_->first, .host = kScanningHost},
                     static_cast<std::uint16_t>(kDetails[detail_]));
}

void Scanner::next_detail() {
  awaiting_ = false;
  tries_ = 0;
  if (++detail_ == kDetails.size()) {
    detail_ = 0;
    ++drive_;
  }
}

void Scanner::receive(const ReceivedFrame& received) {
  const Frame& frame = received.frame;
  if (!settled_) {
    const std::optional<std::uint8_t> motor = decode_identity(frame);
    if (motor && *motor >= 1 && asked_ > 0) {
      std::array<std::uint8_t, 8> mcu{};
      std::copy_n(frame.data.begin(), mcu.size(), mcu.begin());
      const auto [place, fresh] = drives_.try_emplace(*motor);
      place->second.twice = place->second.twice || (!fresh && place->second.mcu != mcu);
      place->second.mcu = mcu;
    }
    return;
  }
  const std::optional<ParameterAnswer> answer = decode_parameter(frame);
  if (awaiting_ && answer && drive_ != drives_.end() && answer->link.motor == drive_->first &&
      answer->index == static_cast<std::uint16_t>(kDetails[detail_])) {
    drive_->second.parameters[kDetails[detail_]] = *answer;
    next_detail();
  }
}

FoundDrive Scanner::describe(std::uint8_t id, const Answering& drive) {
  FoundDrive found;
  found.id = id;
  const auto remark = [&found](std::string text) { found.remarks.push_back(std::move(text)); };
  const auto add = [&found](const char* key, std::string value) {
    found.options.emplace_back(key, std::move(value));
  };
  const bool cybergear = !value_of(drive.parameters, Index::kTimeout) &&
                         value_of(drive.parameters, Index::kCyberGearTimeout);
  add("variant", cybergear ? "\"cybergear\"" : "\"robstride\"");
  const auto limit = value_of(drive.parameters, Index::kTorqueLimit);
  const ModelScaling* scaling = nullptr;
  for (const ModelScaling& model : kModels) {
    const bool same = limit && std::abs(limit->real() - model.torque_nm) < 0.01;
    scaling = same ? &model : scaling;
  }
  if (scaling != nullptr) {
    found.model = fmt::format("{} by its limit_torque", scaling->model);
    add("position_range_rad", fmt::format("{}", scaling->position_rad));
    add("velocity_range_rad_s", fmt::format("{}", scaling->velocity_rad_s));
    add("torque_range_nm", fmt::format("{}", scaling->torque_nm));
    add("stiffness_range_nm_rad", fmt::format("{}", scaling->stiffness_nm_rad));
    add("damping_range_nm_s_rad", fmt::format("{}", scaling->damping_nm_s_rad));
    remark(
        "its ranges are those of the manual for this limit_torque; no drive tells its own: compare "
        "them with the label (firmware before 0.0.2.6 has a position range of 12.5)");
  } else {
    found.model = cybergear ? "CyberGear" : "RobStride";
    remark(
        fmt::format("its limit_torque (parameter 0x700B) is {}, no model's torque range: "
                    "switch it off and on and scan again, or take the ranges from its manual",
                    limit ? fmt::format("{:.6g} N·m", limit->real()) : "not told"));
  }
  if (drive.twice) {
    remark("two drives answer to this id: give each its own, one drive on the bus at a time");
  }
  const auto timeout =
      value_of(drive.parameters, cybergear ? Index::kCyberGearTimeout : Index::kTimeout);
  if (!timeout) {
    remark("it does not tell its watchdog (canTimeout): update its firmware");
  } else if (timeout->raw == 0) {
    remark("its watchdog is off (canTimeout is 0); the daemon sets it at every start");
  }
  if (const auto zero = value_of(drive.parameters, Index::kZeroState);
      zero && (zero->raw & 0xFFU) == 0) {
    remark(
        "it powers up between 0 and 2 pi (zero_sta, parameter 0x7029, is 0): `geodesic zero` "
        "writes 1 and saves it");
  }
  return found;
}

std::vector<FoundDrive> Scanner::found() const {
  std::vector<FoundDrive> all;
  for (const auto& [id, drive] : drives_) {
    all.push_back(describe(id, drive));
  }
  return all;
}

}  // namespace geodesic::drivers::robstride
