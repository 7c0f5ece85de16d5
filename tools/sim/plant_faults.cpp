// Scripted faults carried out on the plant's drives and buses. What they are is in script.hpp.
#include <algorithm>
#include <cmath>
#include <limits>

#include "tools/sim/plant.hpp"

namespace geodesic::tools {
namespace {

std::int64_t to_ns(double seconds) {
  return std::llround(seconds * 1e9);
}

// Without a duration it lasts for good.
std::int64_t end_ns(std::int64_t begin_ns, double duration_s) {
  return duration_s > 0.0 ? begin_ns + to_ns(duration_s) : std::numeric_limits<std::int64_t>::max();
}

}  // namespace

std::optional<std::int64_t> Plant::begin_of(FaultBase base) const {
  switch (base) {
    case FaultBase::kStart:
      return options_.start_ns;
    case FaultBase::kEnabled:
      return report_.enabled_s ? std::optional(options_.start_ns + to_ns(*report_.enabled_s))
                               : std::nullopt;
    case FaultBase::kRelease:
      break;
  }
  return released() ? std::optional(release_ns_) : std::nullopt;
}

void Plant::act_out_faults() {
  for (std::size_t i = 0; i < fault_done_.size(); ++i) {
    if (fault_done_[i]) continue;
    const ScriptedFault& fault = options_.script.faults[i];
    const std::optional<std::int64_t> from = begin_of(fault.base);
    if (!from || now_ns_ < *from + to_ns(fault.at_s)) continue;
    fault_done_[i] = true;
    act_out(fault);
    report_.injections.push_back({fault.joint, fault.kind, elapsed_s(), now_ns_});
  }
}

void Plant::act_out(const ScriptedFault& fault) {
  PlantDrive& drive = drives_[fault.joint];
  const std::size_t bus = drive.options->bus;
  const double position = physics_.position(fault.joint) + drive.encoder_offset;
  switch (fault.kind) {
    case FaultKind::kSilent:
      drive.silent_until_ns = end_ns(now_ns_, fault.value);
      break;
    case FaultKind::kError:
      drive.simulated->inject_error(fault.code);
      break;
    case FaultKind::kPowerCycle:
      drive.simulated->power_cycle();
      break;
    case FaultKind::kTemperature:
      drive.simulated->set_temperature(fault.value);
      break;
    case FaultKind::kEncoderJump:
      drive.encoder_offset += fault.value;
      break;
    case FaultKind::kEncoderStuck:
      drive.stuck_position = position;
      break;
    case FaultKind::kDouble:
      set_shaft(*drive.twin, *drive.options, position + fault.value, 0.0);
      drive.twin_answers = true;
      break;
    case FaultKind::kBabble:
      babbling_until_ns_[bus] = end_ns(now_ns_, fault.value);
      break;
    case FaultKind::kHoldBus:
      held_until_ns_[bus] = end_ns(now_ns_, fault.value);
      break;
  }
}

void Plant::set_shaft(drivers::SimulatedDrive& drive, const drivers::JointOptions& joint,
                      double position, double velocity) {
  const double gear = joint.direction * joint.ratio;
  drive.set_shaft((position - joint.offset) / gear, velocity / gear);
}

bool Plant::silent(std::size_t joint) const noexcept {
  return now_ns_ < drives_[joint].silent_until_ns || babbling(drives_[joint].options->bus);
}

}  // namespace geodesic::tools
