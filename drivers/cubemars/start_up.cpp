// How a CubeMars drive is brought to report steadily; see start_up.hpp. Sources: README.md.
#include "drivers/cubemars/start_up.hpp"

#include <algorithm>
#include <limits>

namespace geodesic::drivers::cubemars {

StartUp::StartUp(const DriveOptions& options)
    : id_(options.id),
      servo_(Facts(options).servo),
      most_gap_ns_(servo_ ? std::min(kMostGapNs, options.watchdog_ns)
                          : std::numeric_limits<std::int64_t>::max()) {}

void StartUp::restart() noexcept {
  reports_ = 0;
  heard_ = false;
  held_by_error_ = false;
  awaiting_ = false;
  begun_ = false;
  complaint_ = {};
}

bool StartUp::transmit(std::int64_t now_ns, Frame& out) noexcept {
  if (!begun_) {
    begun_ = true;
    begun_ns_ = now_ns;
  }
  if (servo_) {
    if (now_ns - begun_ns_ > kPatienceNs && !held_by_error_) {
      complaint_ = {"status reports of the drive (function 0x29): time since one [s]",
                    static_cast<double>(now_ns - (heard_ ? stamp_ns_ : begun_ns_)) * 1e-9,
                    static_cast<double>(most_gap_ns_) * 1e-9,
                    "with the vendor's tool set servo mode and an upload rate of 500 Hz, or "
                    "correct the drive's mode in the robot file"};
    }
    return false;
  }
  if (awaiting_ && now_ns - asked_ns_ < kReplyTimeoutNs) {
    return false;
  }
  // The one frame that is answered and never makes torque: whoever left the drive enabled is out.
  out = encode_special(id_, Special::kExit);
  awaiting_ = true;
  asked_ns_ = now_ns;
  return true;
}

void StartUp::receive(std::uint8_t error, std::int64_t stamp_ns) noexcept {
  const bool steady = reports_ == 0 || stamp_ns - stamp_ns_ <= most_gap_ns_;
  heard_ = true;
  awaiting_ = false;
  stamp_ns_ = stamp_ns;
  held_by_error_ = error != 0;
  if (held_by_error_) {
    reports_ = 0;
    complaint_ = {"error code of the drive", static_cast<double>(error), 0.0,
                  "remove its cause, then power-cycle the drive: it has no command that clears"};
    return;
  }
  reports_ = steady ? reports_ + 1 : 1;
  if (done()) {
    complaint_ = {};
  }
}

}  // namespace geodesic::drivers::cubemars
