// A CiA 402 drive as the bus sees it: object dictionary, NMT, PDOs, power state machine, watchdogs.
// It shares the layout table with the codec and nothing else, so that a slip in the codec's
// arithmetic shows.
#pragma once

#include <array>
#include <cstddef>
#include <cstdint>
#include <optional>
#include <span>

#include "drivers/cia402/dictionary.hpp"
#include "drivers/cia402/layout.hpp"
#include "drivers/drive.hpp"

namespace geodesic::drivers::cia402 {

/// Contracts as drivers::SimulatedDrive. What the sources leave open is decided in README.md.
class Simulated final : public SimulatedDrive {
 public:
  /// How 0x607C acts, in which makers differ.
  enum class HomeOffset : std::uint8_t { kSubtracted, kAdded, kOnlyByHoming };

  /// A drive that was set up as `options` say, all watchdogs off as it comes from the maker,
  /// switched on at its zero.
  explicit Simulated(const DriveOptions& options);

  std::size_t receive(const Frame& frame, std::int64_t now_ns, std::span<Frame> out) override;
  std::size_t speak(std::int64_t now_ns, std::span<Frame> out) override;
  void set_shaft(double position_rad, double velocity_rad_s) override;
  double torque_nm(std::int64_t now_ns) override;
  bool enabled() const override { return power_ == PowerState::kEnabled; }
  void set_temperature(double celsius) override;
  void inject_error(std::uint8_t code) override;
  void power_cycle() override;

  /// As a maker's tool would: values, objects it has not got, its kind.
  Dictionary& dictionary() { return dictionary_; }
  void set_home_offset(HomeOffset kind) { home_offset_ = kind; }
  NmtState nmt_state() const { return nmt_; }
  PowerState power_state() const { return power_; }

 private:
  void fill_dictionary(const DriveOptions& options);
  void find_position();
  void boot();
  void watch(std::int64_t now_ns);
  void lose_connection(std::uint16_t code);
  void leave_operational(NmtState state);
  void fall_into_fault(std::uint16_t code);
  void emergency(std::uint16_t code);
  bool heats() const;
  void obey_nmt(const Frame& frame);
  void obey(std::uint16_t controlword);
  void quick_stop();
  void serve_sdo(const Frame& frame, Frame& out);
  std::optional<Abort> write(const Frame& frame, std::uint16_t index, std::uint8_t sub);
  void take_process_data(const Frame& frame, std::int64_t now_ns);
  void put_in_force();
  std::size_t report(std::span<Frame> out);
  void measure();
  std::uint16_t statusword() const;
  Frame frame_of(std::uint32_t id, std::uint8_t length) const;

  static constexpr std::size_t kMostEmergencies = 8;

  std::uint32_t node_ = 0;
  Dictionary dictionary_;
  double increments_per_rad_ = 0;
  double velocity_per_rad_s_ = 0;
  double turn_rad_ = 0;  ///< of the shaft, for one revolution of the encoder
  bool keeps_turns_ = false;
  double rated_nm_ = 0;
  HomeOffset home_offset_ = HomeOffset::kSubtracted;

  NmtState nmt_ = NmtState::kBootUp;
  PowerState power_ = PowerState::kSwitchOnDisabled;
  bool boot_up_due_ = true;
  std::uint16_t controlword_ = 0;
  std::array<std::uint16_t, kMostEmergencies> emergencies_{};
  std::size_t emergencies_due_ = 0;
  std::int64_t next_heartbeat_ns_ = 0;
  bool heartbeat_watched_ = false;
  std::int64_t last_heartbeat_ns_ = 0;
  bool torque_watched_ = false;
  std::int64_t last_torque_ns_ = 0;
  Frame pending_;  ///< RPDO1 that waits for SYNC
  bool pending_due_ = false;
  std::array<unsigned, 2> syncs_{};  ///< since the last TPDO1, TPDO2

  double shaft_rad_ = 0;
  double shaft_rad_s_ = 0;
  double turns_rad_ = 0;  ///< whole revolutions the encoder did not see, since switched on
  double celsius_ = 25.0;
};

}  // namespace geodesic::drivers::cia402
