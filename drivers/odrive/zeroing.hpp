// Makes where an ODrive stands its zero: Set_Absolute_Position, read back, saved, and read back
// again after the restart that saving brings.
#pragma once

#include <limits>
#include <optional>
#include <string>

#include "drivers/bench_dialogue.hpp"
#include "drivers/drive.hpp"
#include "drivers/odrive/settings.hpp"
#include "drivers/odrive/status.hpp"

namespace geodesic::drivers::odrive {

/// Contracts as drivers::Zeroing. Firmware 0.5 is refused: it has no way to save over CAN.
class OdriveZeroing final : public Zeroing {
 public:
  static constexpr std::int64_t kAskNs = 20'000'000;
  static constexpr std::int64_t kTimeoutNs = 3'000'000'000;  ///< of each step
  static constexpr std::int64_t kRebootNs = 10'000'000'000;
  static constexpr double kStillRevS = 0.01;
  static constexpr double kToleranceRev = 1e-3;

  explicit OdriveZeroing(const DriveOptions& options);

  std::optional<Frame> transmit(std::int64_t now_ns) override;
  void receive(const ReceivedFrame& received) override;
  bool over() const override { return step_ == Step::kOver; }
  bool done() const override { return done_; }
  std::string report() const override { return report_; }
  double before_rad() const override { return before_rev_ * kTurn; }
  double after_rad() const override { return after_rev_ * kTurn; }

 private:
  enum class Step : std::uint8_t {
    kLook,     ///< version, errors, state, position and speed
    kSet,      ///< Set_Absolute_Position(0)
    kCheck,    ///< it tells 0
    kSave,     ///< Reboot with save
    kReturn,   ///< the first heartbeats after it
    kConfirm,  ///< it still tells 0
    kOver,
  };

  void enter(Step step, std::int64_t now_ns);
  void refuse(std::string why);
  void look(std::int64_t now_ns);
  void check(std::int64_t now_ns, Step next);
  const char* waited_for() const;

  std::uint32_t node_;
  Firmware firmware_;
  Status status_;
  Step step_ = Step::kLook;
  std::int64_t entered_ns_ = -1;
  std::int64_t next_ns_ = 0;
  int asks_ = 0;
  int estimates_ = 0;
  std::int64_t estimate_ns_ = 0;
  double position_rev_ = 0.0;
  double velocity_rev_s_ = 0.0;
  double before_rev_ = std::numeric_limits<double>::quiet_NaN();
  double after_rev_ = std::numeric_limits<double>::quiet_NaN();
  bool done_ = false;
  std::string report_;
};

}  // namespace geodesic::drivers::odrive
