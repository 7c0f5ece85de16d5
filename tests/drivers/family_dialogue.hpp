// Any family's driver and simulated drive on a bus that exists in memory only, stepped by hand, for
// tests that hold for every family.
#pragma once

#include <array>
#include <cstdint>
#include <functional>
#include <memory>
#include <span>
#include <string>
#include <vector>

#include "drivers/families.hpp"

namespace geodesic::drivers::test {

class FamilyDialogue {
 public:
  static constexpr std::int64_t kPeriodNs = 1'000'000;
  static constexpr int kPatience = 5000;  ///< cycles

  FamilyDialogue(const Family& family, const DriveOptions& options)
      : FamilyDialogue(family, options, options) {}

  /// @param other  what the drive has, where that differs from what its host was told.
  FamilyDialogue(const Family& family, const DriveOptions& options, const DriveOptions& other)
      : family_(family),
        drive_(family.make_drive(options)),
        simulated_(family.make_simulated(other)),
        replies_(drive_->reply_ids()) {}

  Drive& drive() { return *drive_; }
  SimulatedDrive& simulated() { return *simulated_; }
  control::DriveCondition condition() const { return drive_->state().condition; }
  double torque_nm() { return simulated_->torque_nm(now_ns + 400'000); }
  void shaft(double position_rad, double velocity_rad_s) {
    simulated_->set_shaft(position_rad, velocity_rad_s);
  }
  /// Another drive in place of that one, switched on at its zero.
  void exchange(const DriveOptions& options) { simulated_ = family_.make_simulated(options); }

  void cycle(const DriveCommand& command) {
    now_ns += kPeriodNs;
    reported = false;
    std::array<Frame, Drive::kMaxFramesPerCycle> out;
    frames = drive_->transmit(command, now_ns, out);
    std::array<Frame, SimulatedDrive::kMaxReplies> said;
    for (std::size_t i = 0; i < frames; ++i) {
      tell(witness, out[i]);
      tell(witness_sent, out[i]);
      const std::size_t count = cut ? 0 : simulated_->receive(out[i], now_ns + 100'000, said);
      hear(std::span(said).first(count), 200'000);
    }
    const std::size_t unasked = simulated_->speak(now_ns + 300'000, said);
    hear(std::span(said).first(cut ? 0 : unasked), 300'000);
  }

  void run(int cycles, const DriveCommand& command = {}) {
    for (int i = 0; i < cycles; ++i) {
      cycle(command);
    }
  }

  bool run_until(control::DriveCondition wanted, const DriveCommand& command) {
    for (int i = 0; i < kPatience; ++i) {
      cycle(command);
      if (condition() == wanted) {
        return true;
      }
    }
    return false;
  }

  /// A dialogue of the bench with the drive, a request a millisecond at most.
  void hold(BenchDialogue& dialogue, int milliseconds) {
    for (int i = 0; i < milliseconds && !dialogue.over(); ++i) {
      now_ns += kPeriodNs;
      std::array<Frame, SimulatedDrive::kMaxReplies> said;
      std::size_t count = 0;
      if (const std::optional<Frame> frame = dialogue.transmit(now_ns)) {
        count = simulated_->receive(*frame, now_ns + 100'000, said);
        for (std::size_t k = 0; k < count; ++k) {
          dialogue.receive({said[k], now_ns + 200'000});
        }
      }
      count = simulated_->speak(now_ns + 300'000, said);
      for (std::size_t k = 0; k < count; ++k) {
        dialogue.receive({said[k], now_ns + 300'000});
      }
    }
  }

  /// What a person would be told of the drive.
  std::string why() const {
    std::string text = "condition ";
    text.append(std::to_string(static_cast<int>(condition())));
    if (const char* quantity = drive_->complaint().quantity) {
      text.append(", ").append(quantity).append(": ");
      text.append(std::to_string(drive_->complaint().found)).append(" instead of ");
      text.append(std::to_string(drive_->complaint().expected));
    }
    return text;
  }

  std::int64_t now_ns = 1'000'000'000;
  bool cut = false;   ///< nothing reaches anybody
  bool deaf = false;  ///< nothing reaches the driver
  std::size_t frames = 0;
  bool reported = false;
  std::function<void(const Frame&)> witness;       ///< sees every frame
  std::function<void(const Frame&)> witness_sent;  ///< sees the driver's

 private:
  static void tell(const std::function<void(const Frame&)>& whom, const Frame& frame) {
    if (whom) {
      whom(frame);
    }
  }

  void hear(std::span<const Frame> said, std::int64_t after_ns) {
    for (const Frame& frame : said) {
      tell(witness, frame);
      bool ours = false;
      for (const IdFilter& filter : replies_) {
        ours = ours || filter.matches(frame.id, frame.extended);
      }
      if (ours && !deaf && drive_->claims(frame)) {
        reported = drive_->receive({frame, now_ns + after_ns}) || reported;
      }
    }
  }

  const Family& family_;
  std::unique_ptr<Drive> drive_;
  std::unique_ptr<SimulatedDrive> simulated_;
  std::vector<IdFilter> replies_;
};

}  // namespace geodesic::drivers::test
