// One-off dialogues for people at the bench, alike for all families: who answers on this bus, and
// setting a drive's zero. Not real-time. Who sends and shows the frames: tools/geodesic.
#pragma once

#include <cstdint>
#include <limits>
#include <optional>
#include <string>
#include <utility>
#include <vector>

#include "drivers/bus/frame.hpp"

namespace geodesic::drivers {

/// Asks one thing after the other; a time-out of its own ends what is not answered.
class BenchDialogue {
 public:
  virtual ~BenchDialogue() = default;

  /// The next request; nothing: an answer is awaited, or it is over. Asked every millisecond or so.
  virtual std::optional<Frame> transmit(std::int64_t now_ns) = 0;
  virtual void receive(const ReceivedFrame& received) = 0;
  virtual bool over() const = 0;

 protected:
  BenchDialogue() = default;
  BenchDialogue(const BenchDialogue&) = default;
  BenchDialogue& operator=(const BenchDialogue&) = default;
};

struct FoundDrive {
  std::uint32_t id = 0;        ///< as DriveOptions::id
  std::uint32_t reply_id = 0;  ///< as DriveOptions::reply_id; 0: the family needs none
  std::string model;           ///< as far as it tells
  std::string firmware;
  /// More for [joint.drive]: key and TOML value, as read from the drive.
  std::vector<std::pair<std::string, std::string>> options;
  std::vector<std::string> remarks;  ///< what a person should know: an error, a missing watchdog
};

/// Which drives of a family answer. Never moves or enables one, never changes what one stores.
class Scanner : public BenchDialogue {
 public:
  virtual std::vector<FoundDrive> found() const = 0;
};

/// Makes where the drive stands its zero, keeps it over power-off, and reads it back. Refuses a
/// drive that is enabled, moves or has an error.
class Zeroing : public BenchDialogue {
 public:
  /// Over, and the drive told a position of 0 within its resolution.
  virtual bool done() const = 0;
  /// What was found before and read back after, or why it was refused: a sentence.
  virtual std::string report() const = 0;
  /// The drive's position as it told it before, and read back after [rad, its own]; NaN: it did not
  /// tell. For the record of who has set which zero.
  virtual double before_rad() const { return std::numeric_limits<double>::quiet_NaN(); }
  virtual double after_rad() const { return std::numeric_limits<double>::quiet_NaN(); }
};

}  // namespace geodesic::drivers
