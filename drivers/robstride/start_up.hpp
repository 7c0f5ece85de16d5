// The dialogue that turns a RobStride or CyberGear drive of unknown state into one that is stopped,
// free of faults, checked against the configuration and set for operation control. What follows is
// driver.hpp's.
#pragma once

#include <array>
#include <cstddef>
#include <cstdint>
#include <span>

#include "drivers/drive.hpp"
#include "drivers/robstride/codec.hpp"

namespace geodesic::drivers::robstride {

/// One request at a time: the next leaves when the answer has come or its time-out has passed.
/// Real-time throughout.
class StartUp {
 public:
  static constexpr std::int64_t kReplyTimeoutNs = 20'000'000;
  /// An answer to a version query looks like a far position: none comes later than this.
  static constexpr std::int64_t kLateAnswerNs = 200'000'000;
  static constexpr int kMaxTries = 25;   ///< of a parameter a living drive does not answer for
  static constexpr int kMaxWrites = 3;   ///< of a setting that is not kept
  static constexpr int kMaxLooks = 5;    ///< at a position that is told in two ways
  static constexpr int kMaxClears = 10;  ///< of one fault
  /// What feedback and mechPos may differ by [rad]: a few milliseconds of a hand's motion.
  static constexpr double kPositionTolerance = 0.05;

  explicit StartUp(const DriveOptions& options);

  /// Begins again; nothing that was read before counts.
  void restart() noexcept;

  /// This cycle's requests. @return how many of `out`, which has room for two.
  std::size_t transmit(std::int64_t now_ns, std::span<Frame> out) noexcept;
  /// Of the `frames` last transmitted; a request for silence has no answer.
  std::size_t answers_due(std::size_t frames) const noexcept;

  void receive_parameter(const ParameterAnswer& answer) noexcept;
  /// @return true: it was the answer to the version query, and no state.
  bool receive_version(const ReceivedFrame& received) noexcept;
  void receive_feedback(const Feedback& feedback) noexcept;
  /// The drive has been switched on since.
  void receive_identity() noexcept;

  bool done() const noexcept { return step_ == Step::kDone; }
  bool refused() const noexcept { return step_ == Step::kRefused; }
  /// Positions are as configured, so that feedback means what we take it for.
  bool ranges_verified() const noexcept { return ranges_verified_; }
  /// The drive has answered since the dialogue began.
  bool heard() const noexcept { return heard_; }
  /// The drive has a fault that is not, or no longer, cleared.
  bool held_by_error() const noexcept { return held_by_error_; }
  const DriveComplaint& complaint() const noexcept { return complaint_; }
  /// As told, see decode_version(); 0 before that, or from a drive that does not tell.
  std::uint32_t firmware() const noexcept { return firmware_; }

 private:
  enum class Step : std::uint8_t {
    kSilence,     ///< no reports by the drive's own timer; goes with a first stop
    kStop,        ///< whoever left it running
    kVersion,     ///< ask for the firmware's version
    kCompare,     ///< the position as feedback and as a parameter
    kRead,        ///< read and compare setting read_ of the table
    kClearError,  ///< see that there is no fault, or clear it
    kWrite,       ///< write setting write_
    kReadBack,    ///< and read it back
    kConfirm,     ///< a last feedback: stopped, no fault
    kDone,
    kRefused,
  };
  static constexpr std::size_t kSettingCount = 4;
  struct Wanted {
    std::uint16_t index = 0;
    const char* quantity = nullptr;
    const char* fix = nullptr;
    std::uint32_t raw = 0;
    bool real = false;   ///< float32; else an integer
    bool fixed = false;  ///< compared, never written
    bool kept = false;   ///< the drive has it
  };

  void enter(Step step) noexcept;
  void begin_again() noexcept;
  void refuse(const DriveComplaint& complaint) noexcept;
  bool awaits_parameter() const noexcept;
  const char* awaited_quantity() const noexcept;
  std::uint16_t awaited_index() const noexcept;
  std::size_t request(std::span<Frame> out) noexcept;
  void compare(double position_rad) noexcept;
  void take_value(const ParameterAnswer& answer) noexcept;
  void next_setting() noexcept;
  static double value_of(const Wanted& wanted, std::uint32_t raw) noexcept;

  DriveOptions options_;
  Link link_;
  bool cybergear_;
  double least_firmware_;
  Step step_ = Step::kSilence;
  std::size_t count_ = 0;  ///< of wanted_
  std::size_t read_ = 0;
  std::size_t write_ = 0;
  std::array<Wanted, kSettingCount> wanted_{};
  std::uint32_t firmware_ = 0;
  Feedback feedback_;
  bool awaiting_ = false;
  bool heard_ = false;
  bool seen_ = false;  ///< kCompare: feedback_ came in answer to the request
  bool ranges_verified_ = false;
  bool held_by_error_ = false;
  bool silent_ = false;  ///< one of what was last sent has no answer
  int tries_ = 0;
  int writes_ = 0;
  int looks_ = 0;
  int clears_ = 0;
  std::int64_t asked_ns_ = 0;
  std::int64_t version_asked_ns_ = 0;
  bool version_asked_ = false;
  DriveComplaint complaint_;
};

}  // namespace geodesic::drivers::robstride
