// Looking for Damiao drives; see scanner.hpp for what it promises.
#include "drivers/damiao/scanner.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <bit>
#include <cmath>
#include <string>

#include "drivers/damiao/family.hpp"

namespace geodesic::drivers::damiao {

namespace {

/// Factory ranges (VMAX, TMAX) by type: a drive does not tell its type, and anybody may write its
/// ranges, so this is a hint and nothing else. Source: README.md, openarm_can's table.
struct FactoryRanges {
  double velocity_rad_s;
  double torque_nm;
  const char* type;
};
constexpr std::array kTypes = {
    FactoryRanges{50, 5, "DM3507"},
    FactoryRanges{30, 10, "DM4310"},
    FactoryRanges{50, 10, "DM4310P"},
    FactoryRanges{8, 28, "DM4340"},
    FactoryRanges{10, 28, "DM4340"},
    FactoryRanges{45, 20, "DM6006"},
    FactoryRanges{45, 40, "DM8006"},
    FactoryRanges{45, 54, "DM8009"},
    FactoryRanges{20, 120, "DM6248P"},
    FactoryRanges{25, 200, "DM10010L"},
    FactoryRanges{20, 200, "DM10010"},
    FactoryRanges{280, 1, "DMH3510"},
    FactoryRanges{45, 10, "DMH6215 or DMG6220"},
};

double real(std::uint32_t raw) {
  return static_cast<double>(std::bit_cast<float>(raw));
}

const char* type_by_ranges(double velocity_rad_s, double torque_nm) {
  for (const FactoryRanges& type : kTypes) {
    if (std::abs(type.velocity_rad_s - velocity_rad_s) < 0.01 &&
        std::abs(type.torque_nm - torque_nm) < 0.01) {
      return type.type;
    }
  }
  return nullptr;
}

}  // namespace

std::optional<Frame> Scanner::transmit(std::int64_t now_ns) {
  const bool probing = probed_ <= kLastId;
  const std::int64_t patience_ns = !probing ? kDetailNs : probed_ < kLastId ? kProbeNs : kLateNs;
  if (over_ || (awaiting_ && now_ns - asked_ns_ < patience_ns)) {
    return std::nullopt;
  }
  asked_ns_ = now_ns;
  if (probing) {
    awaiting_ = ++probed_ <= kLastId;
    if (awaiting_) {
      return encode_read(probed_, fd_, static_cast<std::uint8_t>(Register::kId));
    }
  } else if (awaiting_ && ++tries_ == kTries) {
    next_detail();
  }
  if (drive_ == drives_.size()) {
    over_ = true;
    return std::nullopt;
  }
  awaiting_ = true;
  const std::uint32_t id = drives_[drive_].id;
  return detail_ == kDetails.size()
             ? encode_state_request(id, fd_)
             : encode_read(id, fd_, static_cast<std::uint8_t>(kDetails[detail_]));
}

void Scanner::next_detail() {
  awaiting_ = false;
  tries_ = 0;
  if (++detail_ > kDetails.size()) {
    detail_ = 0;
    ++drive_;
  }
}

void Scanner::receive(const ReceivedFrame& received) {
  const Frame& frame = received.frame;
  if (!awaiting_ || frame.error || frame.extended || frame.remote || frame.fd != fd_) {
    return;
  }
  const std::optional<RegisterFrame> answer = decode_register(frame);
  const bool read = answer && answer->operation == static_cast<std::uint8_t>(Operation::kRead);
  if (probed_ <= kLastId) {
    // Each identifier is asked once, so an answer is to that question however late it comes: a busy
    // host reads it when the next one has been asked.
    if (!read || answer->id == 0 || answer->id > probed_ || answer->raw != answer->id ||
        answer->number != static_cast<std::uint8_t>(Register::kId)) {
      return;
    }
    const std::uint32_t id = answer->id;
    const auto known = std::find_if(drives_.begin(), drives_.end(),
                                    [id](const Answering& drive) { return drive.id == id; });
    if (known != drives_.end()) {
      known->twice = true;
    } else {
      drives_.push_back(
          {.id = id, .reply_id = frame.id, .twice = false, .registers = {}, .status = {}});
    }
    return;
  }
  Answering& drive = drives_[drive_];
  if (frame.id != drive.reply_id) {
    return;
  }
  if (detail_ == kDetails.size()) {
    const std::optional<StateReport> report = decode_report(frame, {1.0, 1.0, 1.0});
    if (report && report->motor == (drive.id & 0xFU)) {
      drive.status = report->status;
      next_detail();
    }
  } else if (read && answer->id == drive.id &&
             answer->number == static_cast<std::uint8_t>(kDetails[detail_])) {
    drive.registers[kDetails[detail_]] = answer->raw;
    next_detail();
  }
}

FoundDrive Scanner::describe(const Answering& drive) const {
  FoundDrive found{.id = drive.id,
                   .reply_id = drive.reply_id,
                   .model = {},
                   .firmware = {},
                   .options = {},
                   .remarks = {}};
  const auto raw = [&drive](Register number) -> std::optional<std::uint32_t> {
    const auto place = drive.registers.find(number);
    return place == drive.registers.end() ? std::nullopt : std::optional(place->second);
  };
  const auto remark = [&found](std::string text) { found.remarks.push_back(std::move(text)); };
  const auto range = [&](Register number, const char* key) {
    const std::optional<std::uint32_t> value = raw(number);
    if (value && std::isfinite(real(*value)) && real(*value) > 0.0) {
      found.options.emplace_back(key, fmt::format("{}", std::bit_cast<float>(*value)));
      return real(*value);
    }
    remark(fmt::format("register {} ({}) {}", static_cast<int>(number),
                       find_register(static_cast<std::uint8_t>(number))->name,
                       value ? fmt::format("is {}: no range a drive can work with", real(*value))
                             : std::string("was not told: update the drive's firmware")));
    return 0.0;
  };
  range(Register::kPositionRange, "position_range_rad");
  const double velocity = range(Register::kVelocityRange, "velocity_range_rad_s");
  const double torque = range(Register::kTorqueRange, "torque_range_nm");
  if (const char* const type = type_by_ranges(velocity, torque)) {
    found.model = fmt::format("{} by its ranges", type);
  }
  if (const auto version = raw(Register::kFirmware)) {
    const auto sub = raw(Register::kSubVersion);
    found.firmware =
        sub && *sub != 0 ? fmt::format("{}.{}", *version, *sub) : fmt::format("{}", *version);
  }
  if (drive.twice) {
    remark(
        "two drives answer to this id: give each its own (register 8) and save, one drive on "
        "the bus at a time");
  }
  if (drive.reply_id == 0) {
    remark(
        "answers on 0x000 (MST_ID, register 7), the factory setting: several such drives destroy "
        "each other's frames; write 7 (usual: id + 0x10) and save");
  }
  for (const Answering& other : drives_) {
    if (other.id == drive.id) continue;
    if (other.reply_id == drive.reply_id) {
      remark(
          fmt::format("answers on 0x{:X}, as drive 0x{:X} does: give each its own MST_ID "
                      "(register 7) and save",
                      drive.reply_id, other.id));
    } else if (other.id == drive.reply_id) {
      remark(
          fmt::format("answers on 0x{:X}, where drive 0x{:X} listens: its reports command that "
                      "one; write another MST_ID (register 7) and save",
                      drive.reply_id, other.id));
    }
  }
  if (raw(Register::kTimeout) == 0U) {
    remark("its watchdog is off (TIMEOUT, register 9, is 0); the daemon sets it at every start");
  }
  if (const auto mode = raw(Register::kControlMode);
      mode && *mode != static_cast<std::uint32_t>(ControlMode::kMit)) {
    remark(fmt::format("its CTRL_MODE (register 10) is {}; the daemon sets 1 (MIT) at every start",
                       *mode));
  }
  if (!drive.status) {
    remark("does not answer a state request");
  } else if (*drive.status == static_cast<std::uint8_t>(Status::kEnabled)) {
    remark("is enabled: somebody has left it so, or commands it");
  } else if (*drive.status != static_cast<std::uint8_t>(Status::kDisabled)) {
    remark(fmt::format("reports error 0x{:X}: {}", *drive.status, error_name(*drive.status)));
  }
  return found;
}

std::vector<FoundDrive> Scanner::found() const {
  std::vector<FoundDrive> all;
  for (const Answering& drive : drives_) {
    all.push_back(describe(drive));
  }
  return all;
}

}  // namespace geodesic::drivers::damiao
