// Looking for moteus drives; see scanner.hpp for what it promises.
#include "drivers/moteus/scanner.hpp"

#include <fmt/format.h>

#include <array>
#include <string>
#include <utility>

#include "drivers/moteus/family.hpp"
#include "drivers/moteus/start_up.hpp"

namespace geodesic::drivers::moteus {

std::optional<Frame> Scanner::transmit(std::int64_t now_ns) {
  if (over_ || (probed_ > 0 && now_ns - asked_ns_ < kProbeNs)) {
    return std::nullopt;
  }
  again_ = !answered_ && !again_;  // one frame may have been lost
  probed_ += again_ ? 0 : 1;
  if (probed_ > kLastId) {
    over_ = true;
    return std::nullopt;
  }
  asked_ns_ = now_ns;
  answered_ = false;
  Link link;
  link.drive = probed_;
  Frame frame = make_frame(link.command());
  constexpr std::array kAsked = {Item{Register::kMode, Resolution::kInt8},
                                 Item{Register::kHomeState, Resolution::kInt8},
                                 Item{Register::kVoltage, Resolution::kInt8},
                                 Item{Register::kTemperature, Resolution::kInt8},
                                 Item{Register::kFault, Resolution::kInt8},
                                 Item{Register::kModel, Resolution::kInt32},
                                 Item{Register::kFirmware, Resolution::kInt32},
                                 Item{Register::kRegisterMap, Resolution::kInt32}};
  append_reads(frame, kAsked);
  pad(frame);
  return frame;
}

void Scanner::receive(const ReceivedFrame& received) {
  Link link;
  link.drive = probed_;
  if (probed_ == 0 || over_ || received.frame.error || received.frame.remote ||
      received.frame.id != to_id(link.reply())) {
    return;
  }
  if (answered_) {
    found_.back().remarks.emplace_back(
        "answered twice: two drives have this identifier; give each its own (conf set id.id)");
    return;
  }
  std::optional<std::int32_t> map;
  std::optional<std::int32_t> home;
  FoundDrive drive;
  drive.id = probed_;
  drive.model = "moteus";
  Reader reader(received.frame);
  for (Entry entry; reader.next(entry);) {
    if (entry.kind != opcode::kReply) {
      continue;
    }
    const auto number = static_cast<Register>(entry.number);
    const auto code = static_cast<std::uint32_t>(entry.code);
    if (number == Register::kRegisterMap) {
      map = entry.code;
    } else if (number == Register::kHomeState) {
      home = entry.code;
    } else if (number == Register::kModel && code != 0) {
      drive.model = fmt::format("moteus 0x{:X}", code);
    } else if (number == Register::kFirmware) {
      drive.firmware =
          fmt::format("{}.{}.{}", code >> 16U & 0xFFU, code >> 8U & 0xFFU, code & 0xFFU);
    }
  }
  if (!map && !home) {
    return;  // somebody else's frame
  }
  answered_ = true;
  const StateReport report = decode_report(received.frame);
  const auto remark = [&drive](std::string text) { drive.remarks.push_back(std::move(text)); };
  drive.options = {{"velocity_range_rad_s", "50"}, {"torque_range_nm", "1"}};
  remark(
      "no register tells torque and speed: set torque_range_nm and velocity_range_rad_s to the "
      "most this joint is ever to have");
  if (map != kRegisterMapVersion) {
    remark(fmt::format("register map version (0x102) is {}, this driver knows {}: flash the drive",
                       map.value_or(-1), kRegisterMapVersion));
  }
  if (home == static_cast<std::int32_t>(Home::kRotor)) {
    drive.options.emplace_back("home", "\"rotor\"");
    drive.options.emplace_back("rotor_to_output_ratio", "1.0");
    remark("referenced to a turn of its rotor: give rotor_to_output_ratio as the drive has it");
  } else if (home == static_cast<std::int32_t>(Home::kRelative)) {
    remark("its position is referenced to nothing (home state 0): it will be refused");
  }
  if (is_error(report.mode.value_or(0))) {
    remark(fmt::format("is in error: {}",
                       error_name(error_of(*report.mode, report.fault.value_or(0)))));
  } else if (is_running(report.mode.value_or(0))) {
    remark("is running: somebody else commands it");
  }
  found_.push_back(std::move(drive));
}

}  // namespace geodesic::drivers::moteus
