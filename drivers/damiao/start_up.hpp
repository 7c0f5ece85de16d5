// The dialogue that turns a Damiao drive of unknown state into one that is disabled, free of error,
// checked against the configuration and set for MIT commands. What follows is driver.hpp's.
#pragma once

#include <array>
#include <cstddef>
#include <cstdint>

#include "drivers/damiao/codec.hpp"
#include "drivers/drive.hpp"

namespace geodesic::drivers::damiao {

/// One request at a time: the next leaves when the answer has come or its time-out has passed.
/// Real-time throughout.
class StartUp {
 public:
  static constexpr std::int64_t kReplyTimeoutNs = 20'000'000;
  /// An answer later than this is not one of ours any more.
  static constexpr std::int64_t kLateAnswerNs = 200'000'000;
  static constexpr int kMaxTries = 25;   ///< of a register that a living drive does not answer for
  static constexpr int kMaxClears = 10;  ///< of one error

  explicit StartUp(const DriveOptions& options);

  /// Begins again; nothing that was read before counts.
  void restart() noexcept;

  /// This cycle's request. @return false: an answer is still awaited, or there is nothing to ask.
  bool transmit(std::int64_t now_ns, Frame& out) noexcept;

  /// Takes the answer to the register request under way, and late answers to earlier ones. State
  /// reports and register answers share an identifier and can look alike, so a frame counts as an
  /// answer only if id, operation and register are those asked for.
  /// @return true: the frame was an answer to a register request and no state report.
  bool receive_register(const ReceivedFrame& received) noexcept;

  /// Takes the status nibble of a state report.
  void receive_status(std::uint8_t status) noexcept;

  bool done() const noexcept { return step_ == Step::kDone; }
  bool refused() const noexcept { return step_ == Step::kRefused; }
  /// The drive's own scaling has been read and is as configured: reports mean what we take them
  /// for.
  bool ranges_verified() const noexcept { return ranges_verified_; }
  /// The drive has answered since the dialogue began.
  bool heard() const noexcept { return heard_; }
  /// The drive is in error and is not, or no longer, cleared.
  bool held_by_error() const noexcept { return held_by_error_; }
  const DriveComplaint& complaint() const noexcept { return complaint_; }
  /// Register sw_ver, as read; 0 before that.
  std::uint32_t firmware() const noexcept { return firmware_; }

 private:
  enum class Step : std::uint8_t {
    kDisable,     ///< ask for the status; disable whoever left the drive enabled
    kRead,        ///< read and compare register read_ of the table
    kClearError,  ///< see that there is no error, or clear it
    kWrite,       ///< write setting write_
    kReadBack,    ///< and read it back
    kConfirm,     ///< a last status: disabled, no error
    kDone,
    kRefused,
  };
  static constexpr std::size_t kSettings = 2;
  struct Setting {
    Register number;
    std::uint32_t wanted;
    std::uint32_t found;
  };

  void enter(Step step) noexcept;
  void refuse(const DriveComplaint& complaint) noexcept;
  Frame request() const noexcept;
  std::uint8_t awaited_register() const noexcept;
  bool awaits_register() const noexcept;
  void take_value(const RegisterFrame& answer) noexcept;
  void next_setting() noexcept;

  DriveOptions options_;
  Step step_ = Step::kDisable;
  std::size_t read_ = 0;
  std::size_t write_ = 0;
  std::array<Setting, kSettings> settings_{};
  std::uint32_t firmware_ = 0;
  std::uint8_t status_ = 0;
  bool awaiting_ = false;
  bool heard_ = false;
  bool ranges_verified_ = false;
  bool held_by_error_ = false;
  int tries_ = 0;
  int clears_ = 0;
  std::int64_t asked_ns_ = 0;
  std::int64_t register_asked_ns_ = 0;
  bool register_asked_ = false;
  DriveComplaint complaint_;
};

}  // namespace geodesic::drivers::damiao
