// Which of the positions that a drive's reading can mean is the joint's: a drive that forgets whole
// turns when it is switched off leaves them to the band in which the joint may then stand.
#pragma once

#include <cmath>

namespace geodesic::drivers {

/// In joint units, rad or m. Real-time throughout.
class TurnResolver {
 public:
  enum class Verdict : unsigned char {
    kUnique,
    kOutside,    ///< no whole number of turns brings the reading into the band
    kAmbiguous,  ///< more than one does
  };

  /// @param period  what is lost by whole multiples; 0: nothing is, and any reading is taken,
  ///                as it is without a band
  constexpr TurnResolver(double period, double lower, double upper) noexcept
      : period_(period), lower_(lower), upper_(upper) {}

  /// What is to be added to a reading that the drive gave first after power-on.
  Verdict resolve(double reading) noexcept {
    shift_ = 0.0;
    if (!(period_ > 0.0) || !std::isfinite(lower_) || !std::isfinite(upper_)) {
      return Verdict::kUnique;
    }
    const double first = std::ceil((lower_ - reading) / period_);
    const double last = std::floor((upper_ - reading) / period_);
    if (!(first <= last)) {
      return Verdict::kOutside;
    }
    shift_ = first * period_;
    return first < last ? Verdict::kAmbiguous : Verdict::kUnique;
  }

  /// The drive has kept its turns: with the shift found before, the reading is less than half of
  /// what would have been lost away from the last known position.
  bool continues(double reading, double last) const noexcept {
    return std::abs(reading + shift_ - last) < 0.5 * period_;
  }

  double shift() const noexcept { return shift_; }

 private:
  double period_;
  double lower_;
  double upper_;
  double shift_ = 0.0;
};

}  // namespace geodesic::drivers
