// CubeMars drives at the bench: who answers on a bus, and setting a drive's zero. Not real-time.
#pragma once

#include <array>
#include <limits>
#include <optional>
#include <string>
#include <vector>

#include "drivers/bench_dialogue.hpp"
#include "drivers/cubemars/codec.hpp"
#include "drivers/cubemars/settings.hpp"
#include "drivers/drive.hpp"

namespace geodesic::drivers::cubemars {

/// Listens for the status reports of servo mode, then sends "leave MIT control" to one identifier
/// after the other: the only frame that is answered and commands nothing but rest.
class BusScanner final : public Scanner {
 public:
  static constexpr std::uint32_t kLastId = 0x7F;
  static constexpr std::int64_t kListenNs = 100'000'000;
  static constexpr std::int64_t kStepNs = 3'000'000;  ///< from one identifier to the next

  std::optional<Frame> transmit(std::int64_t now_ns) override;
  void receive(const ReceivedFrame& received) override;
  bool over() const override { return over_; }
  std::vector<FoundDrive> found() const override;

 private:
  struct Heard {
    std::uint32_t reply_id = 0;
    std::uint8_t bytes = 0;
    std::uint8_t error = 0;
    bool mit = false;
    bool servo = false;
    bool other_family = false;
  };

  std::array<Heard, 256> heard_{};
  std::uint32_t asked_ = 0;    ///< identifiers up to this one
  std::uint32_t checked_ = 0;  ///< and held against the other family with such replies
  std::int64_t next_ns_ = 0;
  bool begun_ = false;
  bool over_ = false;
};

class ZeroSetter final : public Zeroing {
 public:
  static constexpr std::int64_t kWatchNs = 300'000'000;   ///< to see that it rests
  static constexpr std::int64_t kDeafNs = 1'600'000'000;  ///< it may not answer for so long
  static constexpr std::int64_t kPatienceNs = 2'000'000'000;
  static constexpr double kRestRad = 0.01;  ///< it may move by no more while watched

  /// @param options must pass check().
  explicit ZeroSetter(const DriveOptions& options);

  std::optional<Frame> transmit(std::int64_t now_ns) override;
  void receive(const ReceivedFrame& received) override;
  bool over() const override { return step_ == Step::kOver; }
  bool done() const override { return done_; }
  std::string report() const override { return report_; }
  double before_rad() const override { return before_rad_; }
  double after_rad() const override { return after_rad_; }

 private:
  enum class Step : std::uint8_t { kWatch, kSet, kDeaf, kReadBack, kOver };

  void end(bool done, std::string report);
  std::optional<Frame> ask() const;

  DriveOptions options_;
  Facts facts_;
  Ranges ranges_;
  Step step_ = Step::kWatch;
  bool begun_ = false;
  bool done_ = false;
  bool heard_ = false;
  std::int64_t since_ns_ = 0;
  std::int64_t set_ns_ = 0;
  std::int64_t last_ask_ns_ = 0;
  double least_rad_ = 0.0;
  double most_rad_ = 0.0;
  double before_rad_ = std::numeric_limits<double>::quiet_NaN();
  double after_rad_ = std::numeric_limits<double>::quiet_NaN();
  std::string report_;
};

}  // namespace geodesic::drivers::cubemars
