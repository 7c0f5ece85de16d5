// The middle of the house: one cycle of the real-time thread, from the drives' replies to the
// drives' commands. It composes; what happens is in drivers/ (Arm) and control/ (Controller).
#pragma once

#include <cstdint>

#include "control/controller.hpp"
#include "drivers/arm.hpp"
#include "rt/cyclic_thread.hpp"
#include "rt/ring.hpp"
#include "tools/geodesicd/lifetime.hpp"
#include "tools/geodesicd/phases.hpp"
#include "tools/geodesicd/setup_exchange.hpp"
#include "tools/geodesicd/telemetry.hpp"

namespace geodesic::tools {

struct DaemonOptions {
  std::int64_t period_ns = 1'000'000;
  std::int64_t receive_budget_ns = 800'000;  ///< after it, a missing reply is lost
  LifetimeOptions lifetime;
  bool measure_phases = true;  ///< false in simulated time
};

class Daemon final : public rt::Cyclic {
 public:
  Daemon(drivers::Arm& arm, control::Controller& controller, const DaemonOptions& options);

  /// One cycle. Real-time.
  rt::Next step(const rt::Tick& tick) noexcept override;

  /// Hands an operator's request to the next cycle. Service thread only.
  /// @return false if the last ones have not been taken yet.
  bool request(const control::Request& request) noexcept { return requests_.push(request); }

  /// The way by which new setups come in. Service thread only, but for what it says itself.
  SetupExchange& setups() noexcept { return setups_; }

  Lifetime& lifetime() noexcept { return lifetime_; }
  Telemetry& telemetry() noexcept { return telemetry_; }
  const Phases& phases() const noexcept { return phases_; }

 private:
  void take_requests() noexcept;
  void take_setup() noexcept;
  Course follow_course() noexcept;

  drivers::Arm& arm_;
  control::Controller& controller_;
  std::int64_t period_ns_;
  std::int64_t receive_budget_ns_;
  control::ArmState state_;
  control::ArmCommand command_;
  Lifetime lifetime_;
  Phases phases_;
  Telemetry telemetry_;
  rt::Ring<control::Request, 16> requests_;
  SetupExchange setups_;
};

}  // namespace geodesic::tools
