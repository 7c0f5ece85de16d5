// Makes where a moteus drive stands its zero, by its console (registers 0x130 and 0x131 do so until
// power-off only), and reads it back. Asking people first, and the record, are the tools'.
#pragma once

#include <cstdint>
#include <limits>
#include <optional>
#include <string>

#include "drivers/bench_dialogue.hpp"
#include "drivers/drive.hpp"
#include "drivers/moteus/console.hpp"

namespace geodesic::drivers::moteus {

/// Reads states until the drive is seen stopped, referenced and at rest; then `d cfg-set-output 0`
/// and `conf write`, each confirmed; then states until they agree on 0.
class Zeroing final : public drivers::Zeroing {
 public:
  static constexpr std::int64_t kReplyNs = 20'000'000;
  static constexpr std::int64_t kBetweenNs = 20'000'000;   ///< two looks at whether it moves
  static constexpr std::int64_t kWriteNs = 2'000'000'000;  ///< flash takes its time
  static constexpr int kTries = 10;                        ///< of a request that is not answered
  static constexpr int kLooks = 5;                         ///< states in a row that must agree
  static constexpr double kRestRad = 0.005;  ///< more than this between two looks is motion
  static constexpr double kZeroRad = 0.005;  ///< read back as 0 within this

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
  enum class Step : std::uint8_t { kBefore, kSet, kWrite, kAfter, kDone, kRefused };

  void enter(Step step);
  void refuse(std::string why);
  void look(const Frame& reply);
  void hear(const Frame& reply);

  Link link_;
  Step step_ = Step::kBefore;
  Console console_;
  bool awaiting_ = false;
  std::int64_t asked_ns_ = 0;
  std::int64_t next_ns_ = 0;
  std::int64_t since_ns_ = 0;  ///< of this step
  int tries_ = 0;
  int looks_ = 0;
  double before_rad_ = std::numeric_limits<double>::quiet_NaN();
  double after_rad_ = std::numeric_limits<double>::quiet_NaN();
  std::string report_ = "not finished";
};

}  // namespace geodesic::drivers::moteus
