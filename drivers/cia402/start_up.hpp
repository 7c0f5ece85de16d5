// The dialogue that turns a CiA 402 drive of unknown state into one that is checked against the
// configuration, set up, in cyclic synchronous torque and operational (NMT). What follows, the
// power state machine, is driver.hpp's.
#pragma once

#include <cstddef>
#include <cstdint>
#include <optional>

#include "drivers/cia402/codec.hpp"
#include "drivers/cia402/plan.hpp"
#include "drivers/drive.hpp"

namespace geodesic::drivers::cia402 {

/// One request at a time: the next leaves when the answer has come or its time-out has passed.
/// Real-time throughout.
class StartUp {
 public:
  static constexpr std::int64_t kReplyTimeoutNs = 50'000'000;
  /// A drive that has been reset boots; it is not reset again before this.
  static constexpr std::int64_t kBootTimeoutNs = 2'000'000'000;
  static constexpr std::int64_t kStartTimeoutNs = 200'000'000;
  static constexpr std::int64_t kPollNs = 10'000'000;  ///< between two looks at what is awaited
  static constexpr int kMaxTries = 10;                 ///< of a transfer
  static constexpr int kMaxLooks = 50;                 ///< at what is awaited

  StartUp(const DriveOptions& options, const Units& units) noexcept;

  /// Begins again; nothing that was read before counts.
  void restart() noexcept;

  /// This cycle's request. @return false: an answer is still awaited, or there is nothing to ask.
  bool transmit(std::int64_t now_ns, Frame& out) noexcept;
  /// The last transmit() asked for something that is answered.
  bool asked() const noexcept { return step_ == Step::kTransfer && awaiting_; }

  void receive_sdo(const Sdo& reply) noexcept;
  /// A boot-up message or a heartbeat.
  void receive_state(NmtState state) noexcept;
  /// A PDO of the drive: it is operational.
  void receive_process_data() noexcept;

  bool done() const noexcept { return step_ == Step::kDone; }
  bool refused() const noexcept { return step_ == Step::kRefused; }
  /// The drive's own figures have been read and are as configured.
  bool figures_verified() const noexcept { return at_ >= plan_.figures_end; }
  /// The drive has been heard since the dialogue began.
  bool heard() const noexcept { return heard_; }
  /// Of the drive, 0x1018:3; 0 before that.
  std::uint32_t revision() const noexcept { return revision_; }
  const DriveComplaint& complaint() const noexcept { return complaint_; }

 private:
  enum class Step : std::uint8_t {
    kReset,     ///< NMT: reset, or enter pre-operational
    kTransfer,  ///< transfer at_ of the plan
    kStart,     ///< NMT: start
    kDone,
    kRefused,
  };

  void enter(Step step) noexcept;
  void next(std::size_t count) noexcept;
  void refuse(const DriveComplaint& complaint) noexcept;
  void take_value(std::uint32_t raw) noexcept;
  void take_abort(std::uint32_t code) noexcept;
  Frame request() const noexcept;

  std::uint8_t node_;
  Reset reset_;
  Plan plan_;
  Step step_ = Step::kReset;
  std::size_t at_ = 0;
  std::uint32_t revision_ = 0;
  bool awaiting_ = false;
  bool heard_ = false;
  int tries_ = 0;
  int looks_ = 0;
  std::int64_t asked_ns_ = 0;
  std::int64_t patience_ns_ = 0;
  DriveComplaint complaint_;
};

}  // namespace geodesic::drivers::cia402
