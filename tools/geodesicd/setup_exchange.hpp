// Hands a new setup to the real-time thread and takes the old one back, wait-free on both sides.
// Owns every setup but the controller's first: the real-time thread frees nothing, and nothing that
// it uses is ever freed.
#pragma once

#include <memory>
#include <utility>

#include "control/controller.hpp"
#include "rt/ring.hpp"

namespace geodesic::tools {

class SetupExchange {
 public:
  enum class Verdict : std::uint8_t {
    kNone,     ///< nothing came back
    kTaken,    ///< the one offered counts now; what counted before is freed
    kRefused,  ///< the arm is beyond its limits: what counted before still does
  };

  /// One is on its way. Service thread, as all but follow().
  bool busy() const noexcept { return offered_ != nullptr; }

  /// Hands it over; the next cycle takes it. Only if not busy().
  void offer(std::unique_ptr<const control::Setup> setup) {
    offered_ = std::move(setup);
    there_.push(offered_.get());  // empty as long as nothing is on its way: cannot fail
  }

  /// What has become of the one offered.
  Verdict collect() {
    const control::Setup* back = nullptr;
    if (!back_.pop(back)) return Verdict::kNone;
    if (back == offered_.get()) {
      offered_.reset();
      return Verdict::kRefused;
    }
    in_use_ = std::move(offered_);  // frees what came back
    return Verdict::kTaken;
  }

  /// Real-time thread, between two updates. @return the setup that counts from now on, if it is
  /// another than before; it stays valid until the next call.
  const control::Setup* follow(control::Controller& controller) noexcept {
    const control::Setup* next = nullptr;
    if (!there_.pop(next)) return nullptr;
    const control::Setup* before = controller.exchange(next);
    back_.push(before);
    return before == next ? nullptr : next;
  }

 private:
  std::unique_ptr<const control::Setup> in_use_;   ///< null: the controller's first
  std::unique_ptr<const control::Setup> offered_;  ///< on its way
  rt::Ring<const control::Setup*, 2> there_;
  rt::Ring<const control::Setup*, 2> back_;
};

}  // namespace geodesic::tools
