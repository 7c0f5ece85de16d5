// MyActuator drives at the bench: who answers on a bus, and setting a drive's zero. Not real-time.
#pragma once

#include <array>
#include <limits>
#include <optional>
#include <string>
#include <vector>

#include "drivers/bench_dialogue.hpp"
#include "drivers/drive.hpp"
#include "drivers/myactuator/codec.hpp"
#include "drivers/myactuator/settings.hpp"

namespace geodesic::drivers::myactuator {

/// Reads status, version and model of every identifier in turn. Commands nothing.
class BusScanner final : public Scanner {
 public:
  static constexpr std::int64_t kStepNs = 3'000'000;

  std::optional<Frame> transmit(std::int64_t now_ns) override;
  void receive(const ReceivedFrame& received) override;
  bool over() const override { return over_; }
  std::vector<FoundDrive> found() const override;

 private:
  struct Heard {
    bool answered = false;
    std::optional<Status1> status;
    std::uint32_t version = 0;
    std::string model;
  };

  std::array<Heard, kLastMotor + 1> heard_{};
  std::uint32_t searched_ = 0;  ///< identifiers up to this one
  std::uint32_t motor_ = 1;     ///< of those that answered, asked for more
  std::size_t question_ = 0;
  std::int64_t next_ns_ = 0;
  bool over_ = false;
};

/// 0x64, a restart, and the angle read back.
class ZeroSetter final : public Zeroing {
 public:
  static constexpr std::int64_t kWatchNs = 300'000'000;
  static constexpr std::int64_t kRestartNs = 2'000'000'000;
  static constexpr std::int64_t kPatienceNs = 2'000'000'000;
  static constexpr std::int64_t kStepNs = 5'000'000;
  static constexpr std::int64_t kRepeatNs = 500'000'000;  ///< of what is written to ROM
  static constexpr double kRestRad = 0.01;

  explicit ZeroSetter(const DriveOptions& options) : options_(options), facts_(options) {}

  std::optional<Frame> transmit(std::int64_t now_ns) override;
  void receive(const ReceivedFrame& received) override;
  bool over() const override { return step_ == Step::kOver; }
  bool done() const override { return done_; }
  std::string report() const override { return report_; }
  double before_rad() const override { return before_rad_; }
  double after_rad() const override { return after_rad_; }

 private:
  enum class Step : std::uint8_t { kWatch, kSet, kReset, kRestarting, kReadBack, kOver };

  void end(bool done, std::string report);
  void take_status(const Frame& frame);
  void take_angle(const Frame& frame, std::int64_t stamp_ns);

  DriveOptions options_;
  Facts facts_;
  Step step_ = Step::kWatch;
  bool begun_ = false;
  bool done_ = false;
  bool sound_ = false;     ///< status 1 was read, and there is no error
  bool at_rest_ = false;   ///< status 2 was read, and it neither moves nor makes torque
  bool answered_ = false;  ///< the zero was taken
  unsigned turn_ = 0;
  std::int64_t since_ns_ = 0;
  std::int64_t watched_ns_ = 0;
  std::int64_t next_ns_ = 0;
  double least_rad_ = 0.0;
  double most_rad_ = 0.0;
  double before_rad_ = std::numeric_limits<double>::quiet_NaN();
  double after_rad_ = std::numeric_limits<double>::quiet_NaN();
  std::string report_;
};

}  // namespace geodesic::drivers::myactuator
