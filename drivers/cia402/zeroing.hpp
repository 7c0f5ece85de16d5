// Makes where a CiA 402 drive stands its zero: by its home offset (0x607C), whose sense differs
// between makers and is found by trying, stored (0x1010) and read back. A drive whose offset acts
// only by homing, which needs it enabled, is left as it was and refused. Not real-time.
#pragma once

#include <cstdint>
#include <limits>
#include <optional>
#include <string>

#include "drivers/bench_dialogue.hpp"
#include "drivers/cia402/codec.hpp"
#include "drivers/drive.hpp"

namespace geodesic::drivers::cia402 {

class CanopenZeroing final : public Zeroing {
 public:
  static constexpr std::int64_t kPatienceNs = 200'000'000;
  static constexpr std::int64_t kStorePatienceNs = 5'000'000'000;
  static constexpr std::int64_t kStandstillNs = 300'000'000;  ///< between two looks
  static constexpr int kMaxTries = 5;

  explicit CanopenZeroing(const DriveOptions& options);

  std::optional<Frame> transmit(std::int64_t now_ns) override;
  void receive(const ReceivedFrame& received) override;
  bool over() const override { return step_ == Step::kDone || step_ == Step::kRefused; }
  bool done() const override { return step_ == Step::kDone; }
  std::string report() const override { return report_; }
  double before_rad() const override { return before_rad_; }
  double after_rad() const override { return after_rad_; }

 private:
  enum class Step : std::uint8_t {
    kState,
    kFirstPosition,
    kSecondPosition,
    kOldOffset,
    kTryAdding,
    kLookAdded,
    kTrySubtracting,
    kLookSubtracted,
    kStore,
    kReadBack,
    kRestore,  ///< the old offset, then refused
    kDone,
    kRefused,
  };

  Frame request() const;
  void enter(Step step);
  void refuse(std::string why);
  /// As refuse(), after the drive has got its old offset back.
  void give_back(std::string why);
  void take(const Sdo& reply);
  void take_state(std::uint16_t statusword);
  bool near_zero(std::int32_t position) const;

  std::uint32_t node_;
  std::int32_t tolerance_;  ///< [increments]
  double rad_per_increment_;
  Step step_ = Step::kState;
  bool awaiting_ = false;
  int tries_ = 0;
  std::int64_t asked_ns_ = 0;
  std::int64_t not_before_ns_ = 0;
  std::int32_t position_ = 0;
  std::int32_t old_offset_ = 0;
  std::int32_t new_offset_ = 0;
  double before_rad_ = std::numeric_limits<double>::quiet_NaN();
  double after_rad_ = std::numeric_limits<double>::quiet_NaN();
  std::string report_;
};

}  // namespace geodesic::drivers::cia402
