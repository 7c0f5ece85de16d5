// The dialogue that turns a moteus drive of unknown state into one that is stopped, free of faults
// and checked against the configuration. What follows is driver.hpp's.
#pragma once

#include <array>
#include <cstddef>
#include <cstdint>
#include <string_view>

#include "drivers/drive.hpp"
#include "drivers/moteus/codec.hpp"
#include "drivers/moteus/console.hpp"

namespace geodesic::drivers::moteus {

/// A mode that may make torque and is none of the drive's own refusals.
constexpr bool is_running(std::uint8_t mode) noexcept {
  return mode != static_cast<std::uint8_t>(Mode::kStopped) &&
         mode != static_cast<std::uint8_t>(Mode::kFault) &&
         mode != static_cast<std::uint8_t>(Mode::kPositionTimeout);
}
constexpr bool is_error(std::uint8_t mode) noexcept {
  return mode == static_cast<std::uint8_t>(Mode::kFault) ||
         mode == static_cast<std::uint8_t>(Mode::kPositionTimeout);
}
/// What DriveState::error says: the fault, or the mode where that is the position time-out.
constexpr std::uint8_t error_of(std::uint8_t mode, std::uint8_t fault) noexcept {
  return mode == static_cast<std::uint8_t>(Mode::kFault) && fault != 0 ? fault : mode;
}

/// One request at a time: the next leaves when the answer has come or its time-out has passed.
/// Real-time throughout.
class StartUp {
 public:
  static constexpr std::int64_t kReplyTimeoutNs = 20'000'000;
  static constexpr int kMaxTries = 25;   ///< of a question that a living drive does not answer
  static constexpr int kMaxClears = 10;  ///< of one fault

  StartUp(const DriveOptions& options, const Link& link, const Formats& formats);

  /// Begins again; nothing that was read before counts.
  void restart() noexcept;

  /// This cycle's request. @return false: an answer is still awaited, or there is nothing to ask.
  bool transmit(std::int64_t now_ns, Frame& out) noexcept;

  /// Takes any reply of the drive and what it says of its state.
  void receive(const Frame& reply, const StateReport& report) noexcept;

  bool done() const noexcept { return step_ == Step::kDone; }
  bool refused() const noexcept { return step_ == Step::kRefused; }
  /// Registers, reference and settings are as configured: positions mean what we take them for.
  bool verified() const noexcept { return verified_; }
  /// The drive has answered since the dialogue began.
  bool heard() const noexcept { return heard_; }
  /// The drive is in fault or position time-out and is not, or no longer, cleared.
  bool held_by_error() const noexcept { return held_by_error_; }
  const DriveComplaint& complaint() const noexcept { return complaint_; }
  /// Register 0x101 as read, major.minor.micro a byte each; 0 before that.
  std::uint32_t firmware() const noexcept { return firmware_; }

 private:
  enum class Step : std::uint8_t {
    kLook,        ///< ask for the mode; stop whoever left the drive running
    kRead,        ///< versions and reference
    kAsk,         ///< setting asked_ of the drive's console
    kClearError,  ///< see that there is no fault, or clear it
    kConfirm,     ///< a last look: stopped, no fault
    kDone,
    kRefused,
  };
  struct Wanted {
    std::string_view line;
    const char* quantity = nullptr;
    double value = 0.0;
  };

  void enter(Step step) noexcept;
  void refuse(const DriveComplaint& complaint) noexcept;
  Frame request() noexcept;
  void take_registers(const Frame& reply) noexcept;
  void take_answer(const Frame& reply) noexcept;
  void take_mode(std::uint8_t mode, std::uint8_t fault) noexcept;
  void next_question() noexcept;

  Link link_;
  Formats formats_;
  bool clear_errors_;
  double least_home_;
  std::array<Wanted, 3> wanted_{};
  std::size_t wanted_count_ = 0;
  Step step_ = Step::kLook;
  std::size_t asked_ = 0;
  Console console_;
  std::uint32_t firmware_ = 0;
  std::uint8_t mode_ = 0;
  bool awaiting_ = false;
  bool heard_ = false;
  bool verified_ = false;
  bool held_by_error_ = false;
  int tries_ = 0;
  int clears_ = 0;
  std::int64_t asked_ns_ = 0;
  DriveComplaint complaint_;
};

}  // namespace geodesic::drivers::moteus
