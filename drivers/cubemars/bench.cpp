// CubeMars drives at the bench; see bench.hpp. Sources: README.md.
#include "drivers/cubemars/bench.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <numbers>
#include <utility>

#include "drivers/cubemars/family.hpp"

namespace geodesic::drivers::cubemars {

namespace {

/// A Damiao drive answers an MIT special frame too, and its byte 0 can be its identifier; only it
/// answers a register read on this identifier.
Frame register_read(std::uint32_t id) {
  Frame frame;
  frame.id = 0x7FF;
  frame.length = 8;
  frame.data = {static_cast<std::uint8_t>(id), 0, 0x33, 0x08, 0, 0, 0, 0};
  return frame;
}

bool answers_register_read(const Frame& frame, std::uint32_t id) {
  return frame.length == 8 && frame.data[0] == id && frame.data[1] == 0 && frame.data[2] == 0x33 &&
         frame.data[3] == 0x08;
}

constexpr double kDegree = std::numbers::pi / 180.0;

}  // namespace

std::optional<Frame> BusScanner::transmit(std::int64_t now_ns) {
  if (!begun_) {
    begun_ = true;
    next_ns_ = now_ns + kListenNs;
  }
  if (over_ || now_ns < next_ns_) {
    return std::nullopt;
  }
  next_ns_ = now_ns + kStepNs;
  if (asked_ < kLastId) {
    ++asked_;
    return encode_special(asked_, Special::kExit);
  }
  while (checked_ < kLastId) {
    ++checked_;
    if (heard_[checked_].mit) {
      return register_read(checked_);
    }
  }
  over_ = true;
  return std::nullopt;
}

void BusScanner::receive(const ReceivedFrame& received) {
  const Frame& frame = received.frame;
  if (frame.error || frame.remote || frame.fd) {
    return;
  }
  if (frame.extended) {
    if (frame.id >> 8U == static_cast<std::uint32_t>(Function::kStatus) && frame.length == 8) {
      Heard& heard = heard_[frame.id & 0xFFU];
      heard.servo = true;
      heard.error = frame.data[7];
    }
    return;
  }
  const std::uint32_t motor = frame.data[0];
  if (checked_ > 0 && heard_[motor].mit && frame.id == heard_[motor].reply_id &&
      answers_register_read(frame, motor)) {
    heard_[motor].other_family = true;
    return;
  }
  const bool answer = motor > 0 && motor == asked_ && checked_ == 0;
  if (answer && frame.length >= reply::kShort && frame.length <= reply::kWithError) {
    heard_[motor] = {.reply_id = frame.id,
                     .bytes = frame.length,
                     .error = frame.length == reply::kWithError ? frame.data[7] : std::uint8_t{0},
                     .mit = true};
  }
}

std::vector<FoundDrive> BusScanner::found() const {
  std::vector<FoundDrive> all;
  for (std::uint32_t id = 1; id < heard_.size(); ++id) {
    const Heard& heard = heard_[id];
    if ((!heard.mit && !heard.servo) || heard.other_family) {
      continue;
    }
    FoundDrive drive;
    drive.id = id;
    drive.reply_id = heard.reply_id;
    drive.model = "AK series";
    drive.options = {{"mode", heard.servo ? "\"servo\"" : "\"mit\""},
                     {"gear_ratio", "9.0"},
                     {"velocity_range_rad_s", "50.0"},
                     {"torque_range_nm", "18.0"}};
    if (heard.mit) {
      drive.firmware = fmt::format("replies of {} bytes", heard.bytes);
      drive.options.emplace_back("position_range_rad", "12.5");
    } else {
      drive.options.emplace_back("torque_constant_nm_a", "0.115");
    }
    drive.remarks.emplace_back(
        "it does not tell model, gear or ranges: those given are an AK80-9's; take them from the "
        "manual of this model and firmware");
    drive.remarks.emplace_back(
        "its watchdog (\"CAN interruption\") can be set with the vendor's tool only");
    if (heard.mit && heard.bytes < reply::kWithError) {
      drive.remarks.emplace_back("its replies tell neither temperature nor errors");
    }
    if (heard.error != 0) {
      drive.remarks.push_back(fmt::format("error {}: {}", heard.error, error_name(heard.error)));
    }
    all.push_back(std::move(drive));
  }
  return all;
}

ZeroSetter::ZeroSetter(const DriveOptions& options)
    : options_(options),
      facts_(options),
      ranges_{options.position_range_rad, options.velocity_range_rad_s, options.torque_range_nm} {
  if (facts_.servo && !facts_.output_encoder) {
    end(false,
        "in servo mode a drive with one encoder forgets its zero at power-off: nothing was set "
        "(encoder = \"output\" if it has two; MIT mode keeps the zero of the motor)");
  }
}

void ZeroSetter::end(bool done, std::string report) {
  step_ = Step::kOver;
  done_ = done;
  report_ = std::move(report);
}

std::optional<Frame> ZeroSetter::ask() const {
  if (facts_.servo) {
    return std::nullopt;  // it reports without being asked
  }
  return encode_special(options_.id, Special::kExit);
}

std::optional<Frame> ZeroSetter::transmit(std::int64_t now_ns) {
  if (over()) {
    return std::nullopt;
  }
  if (!begun_) {
    begun_ = true;
    since_ns_ = now_ns;
  }
  if (step_ == Step::kSet) {
    step_ = Step::kDeaf;
    set_ns_ = now_ns;
    return facts_.servo ? encode_servo(options_.id, {Function::kOrigin, 1.0})
                        : encode_special(options_.id, Special::kSetZero);
  }
  if (step_ == Step::kDeaf) {
    if (now_ns - set_ns_ < kDeafNs) {
      return std::nullopt;
    }
    step_ = Step::kReadBack;
    since_ns_ = now_ns;
  }
  if (now_ns - since_ns_ > kPatienceNs) {
    end(false, step_ == Step::kWatch
                   ? "the drive does not report: nothing was set"
                   : "the drive does not report any more: whether its zero was set is not known");
    return std::nullopt;
  }
  if (now_ns - last_ask_ns_ < 10'000'000) {
    return std::nullopt;
  }
  last_ask_ns_ = now_ns;
  return ask();
}

void ZeroSetter::receive(const ReceivedFrame& received) {
  const Frame& frame = received.frame;
  double position_rad = 0.0;
  double velocity_rad_s = 0.0;
  double torque_nm = 0.0;
  std::uint8_t error = 0;
  if (over() || !begun_ || frame.error || frame.remote) {
    return;
  }
  if (facts_.servo) {
    const auto status = decode_status(frame);
    if (!status || !frame.extended || frame.id != servo_id(Function::kStatus, options_.id)) {
      return;
    }
    position_rad = status->position_deg * facts_.radians_per_degree;
    velocity_rad_s = status->speed_erpm * facts_.rad_s_per_erpm;
    torque_nm = status->current_a * facts_.torque_per_ampere_nm;
    error = status->error;
  } else {
    const auto reply = decode_reply(frame, ranges_);
    if (!reply || frame.extended || frame.id != options_.reply_id || reply->motor != options_.id) {
      return;
    }
    position_rad = reply->position_rad;
    velocity_rad_s = reply->velocity_rad_s;
    torque_nm = reply->torque_nm;
    error = reply->error;
  }
  if (step_ == Step::kWatch) {
    if (!heard_) {
      heard_ = true;
      since_ns_ = received.stamp_ns;
      before_rad_ = least_rad_ = most_rad_ = position_rad;
    }
    least_rad_ = std::min(least_rad_, position_rad);
    most_rad_ = std::max(most_rad_, position_rad);
    if (error != 0) {
      end(false, fmt::format("the drive reports error {} ({}): nothing was set", error,
                             error_name(error)));
    } else if (most_rad_ - least_rad_ > kRestRad ||
               std::abs(velocity_rad_s) > 0.01 * options_.velocity_range_rad_s) {
      end(false, fmt::format("the drive moves ({:.3g} rad/s): nothing was set", velocity_rad_s));
    } else if (facts_.servo && std::abs(torque_nm) > 0.02 * options_.torque_range_nm) {
      end(false, fmt::format("the drive makes torque ({:.3g} N·m): nothing was set", torque_nm));
    } else if (received.stamp_ns - since_ns_ >= kWatchNs) {
      step_ = Step::kSet;
    }
  } else if (step_ == Step::kReadBack) {
    after_rad_ = position_rad;
    const double resolution = facts_.servo ? 0.1 * kDegree : 2.0 * ranges_.position_rad / 65535.0;
    const bool zero = std::abs(position_rad) <= 2.0 * resolution + 1e-3;
    end(zero, fmt::format("it stood at {:.5f} rad before, and tells {:.5f} rad now{}", before_rad_,
                          after_rad_, zero ? "" : ": it did not take the zero"));
  }
}

}  // namespace geodesic::drivers::cubemars
