// Makes where a Damiao drive stands its zero (0xFE, which the drive keeps by itself), and reads it
// back. Asking people first, and the record, are the tools'.
#pragma once

#include <cstdint>
#include <limits>
#include <optional>
#include <string>

#include "drivers/bench_dialogue.hpp"
#include "drivers/damiao/codec.hpp"
#include "drivers/drive.hpp"

namespace geodesic::drivers::damiao {

/// Reads PMAX (a wrong one would make every position wrong by a factor), then states until the
/// drive is seen disabled and at rest, sets the zero, and reads states until they agree.
class Zeroing final : public drivers::Zeroing {
 public:
  static constexpr std::int64_t kReplyNs = 20'000'000;
  static constexpr std::int64_t kBetweenNs = 20'000'000;  ///< two looks at whether it moves
  static constexpr int kTries = 10;                       ///< of a request that is not answered
  static constexpr int kLooks = 5;                        ///< states in a row that must agree
  static constexpr int kZeros = 3;  ///< attempts: hosts report that one is not always taken
  static constexpr double kRestRad = 0.005;  ///< more than this between two looks is motion
  static constexpr double kCodes = 3.0;      ///< read back as 0 within so many codes of position

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
  enum class Step : std::uint8_t { kRange, kBefore, kZero, kAfter, kDone, kRefused };

  void enter(Step step);
  void refuse(std::string why);
  void look(const StateReport& report);

  DriveOptions options_;
  Ranges ranges_;
  Step step_ = Step::kRange;
  bool awaiting_ = false;
  std::int64_t asked_ns_ = 0;
  std::int64_t next_ns_ = 0;
  int tries_ = 0;
  int looks_ = 0;
  int bad_looks_ = 0;
  int zeros_ = 0;
  double before_rad_ = std::numeric_limits<double>::quiet_NaN();
  double after_rad_ = std::numeric_limits<double>::quiet_NaN();
  std::string report_ = "not finished";
};

}  // namespace geodesic::drivers::damiao
