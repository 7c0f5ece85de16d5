// Makes where a RobStride or CyberGear drive stands its zero (type 6), keeps it (type 22), and
// reads it back. Asking people first, and the record, are the tools'.
#pragma once

#include <cstdint>
#include <limits>
#include <optional>
#include <string>

#include "drivers/bench_dialogue.hpp"
#include "drivers/drive.hpp"
#include "drivers/robstride/codec.hpp"

namespace geodesic::drivers::robstride {

/// Looks without stopping anything: it reads limit_torque and writes the same value, which is
/// answered with the drive's mode, faults and position. At rest and stopped, it sets zero_sta to 1
/// (not CyberGear, which has none) and the zero, saves both, and looks again.
class Zeroing final : public drivers::Zeroing {
 public:
  static constexpr std::int64_t kReplyNs = 20'000'000;
  static constexpr std::int64_t kBetweenNs = 20'000'000;  ///< two looks at whether it moves
  static constexpr int kTries = 10;                       ///< of a request that is not answered
  static constexpr int kLooks = 5;
  static constexpr double kRestRad = 0.005;   ///< more than this between two looks is motion
  static constexpr double kZeroRad = 0.0015;  ///< read back as 0 within this: 4 codes

  /// @param options  must pass check().
  explicit Zeroing(const DriveOptions& options);

  std::optional<Frame> transmit(std::int64_t now_ns) override;
  void receive(const ReceivedFrame& received) override;
  bool over() const override { return step_ == Step::kDone || step_ == Step::kRefused; }
  bool done() const override { return step_ == Step::kDone; }
  std::string report() const override { return report_; }
  double before_rad() const override { return before_rad_; }
  double after_rad() const override { return after_rad_; }

 private:
  enum class Step : std::uint8_t {
    kLimit,
    kBefore,
    kZeroState,
    kZero,
    kSave,
    kAfter,
    kDone,
    kRefused
  };

  void enter(Step step);
  void refuse(std::string why);
  void look(const Feedback& feedback);

  Link link_;
  Ranges ranges_;
  bool cybergear_;
  Step step_ = Step::kLimit;
  std::uint32_t limit_ = 0;  ///< limit_torque, as it is
  bool awaiting_ = false;
  std::int64_t asked_ns_ = 0;
  std::int64_t next_ns_ = 0;
  int tries_ = 0;
  int looks_ = 0;
  double before_rad_ = std::numeric_limits<double>::quiet_NaN();
  double after_rad_ = std::numeric_limits<double>::quiet_NaN();
  std::string report_ = "not finished";
};

}  // namespace geodesic::drivers::robstride
