// A drive that takes {mode, torque} on its id and answers with {mode, echo of its setting,
// position} on its id + 0x80; floats as they are in memory.
#include "tests/eighth/dummy/family.hpp"

#include <algorithm>
#include <array>
#include <cmath>
#include <cstring>
#include <memory>

namespace geodesic::drivers::dummy {

namespace {

using control::DriveCondition;
using control::DriveMode;

constexpr std::uint32_t kReplyOffset = 0x80;
constexpr std::array<std::string_view, 2> kColours{"red", "green"};
constexpr std::array kSettings = {
    DriveSetting{.key = "colour",
                 .doc = "What the drive is painted with; it tells.",
                 .unit = "",
                 .required = true,
                 .choices = kColours},
};

float float_at(const Frame& frame, std::size_t at) {
  float value = 0.0F;
  std::memcpy(&value, frame.data.data() + at, sizeof value);
  return value;
}

void put_float(Frame& frame, std::size_t at, double value) {
  const auto single = static_cast<float>(value);
  std::memcpy(frame.data.data() + at, &single, sizeof single);
}

Frame make_frame(std::uint32_t id, bool enabled) {
  Frame frame;
  frame.id = id;
  frame.length = 8;
  frame.data[0] = enabled ? 1 : 0;
  return frame;
}

std::uint8_t colour_of(const DriveOptions& options) {
  return static_cast<std::uint8_t>(options.settings.get(kSettings, 0));
}

class Driver final : public Drive {
 public:
  explicit Driver(const DriveOptions& options) : options_(options) {}

  std::size_t transmit(const DriveCommand& command, std::int64_t /*now_ns*/,
                       std::span<Frame> out) noexcept override {
    const bool enable = command.mode == DriveMode::kEnable && allowed();
    out[0] = make_frame(options_.id, enable);
    put_float(out[0], 4, enable && std::isfinite(command.torque_nm) ? command.torque_nm : 0.0);
    return 1;
  }

  bool receive(const ReceivedFrame& received) noexcept override {
    if (state_.condition == DriveCondition::kRefused) {
      return false;
    }
    state_.condition =
        received.frame.data[0] != 0 ? DriveCondition::kEnabled : DriveCondition::kDisabled;
    if (received.frame.data[1] != colour_of(options_)) {
      complaint_ = {"colour", static_cast<double>(received.frame.data[1]),
                    static_cast<double>(colour_of(options_)), "paint it"};
      state_.condition = DriveCondition::kRefused;
      return false;
    }
    state_.position_rad = static_cast<double>(float_at(received.frame, 4));
    state_.stamp_ns = received.stamp_ns;
    return true;
  }

  const DriveState& state() const noexcept override { return state_; }
  const DriveComplaint& complaint() const noexcept override { return complaint_; }
  void restart() noexcept override {
    state_.condition = DriveCondition::kUnknown;
    complaint_ = {};
  }
  std::vector<IdFilter> reply_ids() const override { return {{options_.id + kReplyOffset}}; }
  std::vector<IdFilter> command_ids() const override { return {{options_.id}}; }

 private:
  bool allowed() const {
    return state_.condition == DriveCondition::kDisabled ||
           state_.condition == DriveCondition::kEnabled;
  }

  DriveOptions options_;
  DriveState state_;
  DriveComplaint complaint_;
};

class Simulated final : public SimulatedDrive {
 public:
  explicit Simulated(const DriveOptions& options) : options_(options) {}

  std::size_t receive(const Frame& frame, std::int64_t now_ns, std::span<Frame> out) override {
    if (frame.id != options_.id || frame.length != 8) {
      return 0;
    }
    enabled_ = frame.data[0] != 0;
    wanted_nm_ = static_cast<double>(float_at(frame, 4));
    last_ns_ = now_ns;
    out[0] = make_frame(options_.id + kReplyOffset, enabled_);
    out[0].data[1] = colour_of(options_);
    put_float(out[0], 4, position_rad_);
    return 1;
  }

  void set_shaft(double position_rad, double /*velocity_rad_s*/) override {
    position_rad_ = position_rad;
  }
  double torque_nm(std::int64_t now_ns) override {
    enabled_ = enabled_ && now_ns - last_ns_ <= options_.watchdog_ns;
    return enabled_ ? std::clamp(wanted_nm_, -options_.torque_range_nm, options_.torque_range_nm)
                    : 0.0;
  }
  bool enabled() const override { return enabled_; }
  void set_temperature(double /*celsius*/) override {}
  void inject_error(std::uint8_t /*code*/) override { enabled_ = false; }
  void power_cycle() override { enabled_ = false; }

 private:
  DriveOptions options_;
  bool enabled_ = false;
  double wanted_nm_ = 0.0;
  double position_rad_ = 0.0;
  std::int64_t last_ns_ = 0;
};

}  // namespace

Family family() {
  return {
      .name = "dummy",
      .summary = "a drive that does not exist",
      .make_drive = [](const DriveOptions& options) -> std::unique_ptr<Drive> {
        return std::make_unique<Driver>(options);
      },
      .make_simulated = [](const DriveOptions& options) -> std::unique_ptr<SimulatedDrive> {
        return std::make_unique<Simulated>(options);
      },
      .decode = [](const Frame& frame, const DriveOptions& options) -> std::optional<DecodedFrame> {
        return frame.id == options.id ? std::optional(DecodedFrame{"dummy command", {}})
                                      : std::nullopt;
      },
      .check = [](const DriveOptions& options) -> std::vector<std::string> {
        return options.id < kReplyOffset ? std::vector<std::string>{}
                                         : std::vector<std::string>{"the dummy's id is too large"};
      },
      .error_name = [](std::uint8_t) { return "unknown error"; },
      .settings = kSettings,
      .cyclic_frames = [](const DriveOptions& options, double) -> std::vector<CyclicFrame> {
        return {{.what = "torque", .id = options.id},
                {.what = "state", .id = options.id + kReplyOffset, .reply = true}};
      },
      .position_period_rad = [](const DriveOptions&) { return 0.0; },
      .make_scanner = [](bool) -> std::unique_ptr<Scanner> { return nullptr; },
      .make_zeroing = [](const DriveOptions&) -> std::unique_ptr<Zeroing> { return nullptr; },
  };
}

}  // namespace geodesic::drivers::dummy
