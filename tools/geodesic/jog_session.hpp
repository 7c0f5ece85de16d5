// One joint being jogged on its bus: cycles of the arm's drives, of which one may get torque. Who
// asks for it is jog_input's, how much is jog_law's, showing it is jog's.
#pragma once

#include <atomic>
#include <csignal>
#include <cstdint>
#include <string>

#include "config/robot.hpp"
#include "drivers/arm.hpp"
#include "tools/geodesic/jog_law.hpp"

namespace geodesic::tools {

/// The joint's whole bus is served, so that every other drive on it is seen and held disabled.
/// Other buses are not touched.
class JogSession {
 public:
  /// @throws BusError naming a daemon that commands the bus, std::invalid_argument
  JogSession(const config::Robot& robot, std::size_t joint);
  /// Whatever happens: the drive is disabled.
  ~JogSession();
  JogSession(const JogSession&) = delete;
  JogSession& operator=(const JogSession&) = delete;

  /// Until the drive is configured, disabled and reports. @return why not; empty: it is.
  std::string connect(const std::atomic<bool>& stop, const sigset_t& waiting_mask);

  /// Begins from where the joint stands now.
  void begin(const JogOptions& options);
  /// One cycle with what is asked for, and a wait for the next one.
  void cycle(const JogRequest& request, const sigset_t& waiting_mask);
  /// Zero torque, disabled: waits until the drive says so, at most half a second. @return it does.
  bool let_go();

  const control::JointState& joint() const { return state_.joint[index_]; }
  const JogLaw& law() const { return law_; }
  std::int64_t now_ns() const { return tick_ns_; }
  std::int64_t period_ns() const { return period_ns_; }
  double peak_torque() const { return peak_torque_; }

 private:
  void exchange(const control::JointCommand& command, const sigset_t* waiting_mask);
  void look_around();

  static constexpr std::int64_t kConnectNs = 3'000'000'000;
  static constexpr std::int64_t kLetGoNs = 500'000'000;

  drivers::ArmOptions options_;
  std::size_t index_ = 0;
  std::int64_t period_ns_;
  drivers::Arm arm_;
  control::ArmCommand command_;
  control::ArmState state_;
  JogLaw law_{JogOptions{}};
  bool active_ = false;  ///< the drive may be enabled
  std::int64_t tick_ns_ = 0;
  double peak_torque_ = 0.0;
};

/// What is wrong with a joint's drive in words; empty: it is ready.
std::string trouble_of(const control::JointState& joint, const drivers::DriveComplaint& complaint,
                       const drivers::JointOptions& options);

}  // namespace geodesic::tools
