// What may be configured together: checks of an arm's options, and the filters its buses get.
// Reading and sending is in arm.cpp.
#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <stdexcept>

#include "drivers/arm.hpp"
#include "drivers/families.hpp"
#include "drivers/lockstep_tick.hpp"

namespace geodesic::drivers {

namespace {

bool holds(const std::vector<IdFilter>& ids, const IdFilter& id) {
  return std::any_of(ids.begin(), ids.end(), [&](const IdFilter& one) { return overlap(one, id); });
}

/// As holds(), but for identifiers that drives may have in common.
bool taken(const std::vector<IdFilter>& ids, const IdFilter& id) {
  return std::any_of(ids.begin(), ids.end(), [&](const IdFilter& one) {
    return overlap(one, id) && !(one.shared && id.shared);
  });
}

[[noreturn]] void refuse(const JointOptions& joint, const std::string& why) {
  throw std::invalid_argument(fmt::format("joint '{}': {}", joint.name, why));
}

void check_joint(const JointOptions& joint, const ArmOptions& options) {
  if (joint.bus >= options.buses.size()) {
    refuse(joint, fmt::format("its bus has index {}; there are {} buses", joint.bus,
                              options.buses.size()));
  }
  if (std::abs(joint.direction) != 1.0) {
    refuse(joint, fmt::format("its direction is {}; it must be 1 or -1", joint.direction));
  }
  if (!std::isfinite(joint.ratio) || joint.ratio <= 0.0) {
    refuse(joint, fmt::format("its ratio is {}; it must be above 0 (a reversed drive has direction "
                              "-1)",
                              joint.ratio));
  }
  if (!std::isfinite(joint.offset)) {
    refuse(joint, fmt::format("its offset is {}; it must be a finite number", joint.offset));
  }
  const Family* family = find_family(joint.drive.family);
  if (family == nullptr) {
    std::string known;
    for (const Family& one : families()) {
      known += (known.empty() ? "" : ", ") + std::string(one.name);
    }
    refuse(joint,
           fmt::format("there is no drive family '{}'; known: {}", joint.drive.family, known));
  }
  const std::vector<std::string> wrong = family->check(joint.drive);
  if (!wrong.empty()) {
    refuse(joint, wrong.front());
  }
  if (joint.drive.fd && !options.buses[joint.bus].fd) {
    refuse(joint, fmt::format("its drive speaks CAN FD, but bus '{}' is classic CAN",
                              options.buses[joint.bus].name));
  }
}

}  // namespace

std::vector<BusOptions> filtered_buses(const ArmOptions& options) {
  if (options.joints.empty() || options.joints.size() > control::kMaxJoints) {
    throw std::invalid_argument(fmt::format("the arm has {} joints; it must have 1 to {}",
                                            options.joints.size(), control::kMaxJoints));
  }
  if (options.buses.empty() || options.buses.size() > control::kMaxBuses) {
    throw std::invalid_argument(fmt::format("the arm has {} buses; it must have 1 to {}",
                                            options.buses.size(), control::kMaxBuses));
  }
  std::vector<BusOptions> buses = options.buses;
  for (BusOptions& bus : buses) {
    bus.receive.clear();
    bus.transmit.clear();
  }
  for (std::size_t i = 0; i < options.joints.size(); ++i) {
    const JointOptions& joint = options.joints[i];
    check_joint(joint, options);
    for (std::size_t j = 0; j < i; ++j) {
      const JointOptions& other = options.joints[j];
      if (other.bus == joint.bus && other.drive.id == joint.drive.id &&
          other.drive.family == joint.drive.family) {
        refuse(joint,
               fmt::format("its drive's id 0x{:X} is also that of joint '{}' on the same bus",
                           joint.drive.id, other.name));
      }
    }
    const std::unique_ptr<Drive> drive = find_family(joint.drive.family)->make_drive(joint.drive);
    BusOptions& bus = buses[joint.bus];
    for (const IdFilter& reply : drive->reply_ids()) {
      if (taken(bus.receive, reply)) {
        refuse(joint, fmt::format("its drive answers on 0x{:X}, as another drive on bus '{}' does",
                                  reply.id, bus.name));
      }
      bus.receive.push_back(reply);
    }
    for (const IdFilter& command : drive->command_ids()) {
      const auto same = [&](const IdFilter& one) {
        return one.id == command.id && one.extended == command.extended && one.mask == command.mask;
      };
      if (std::none_of(bus.transmit.begin(), bus.transmit.end(), same)) {
        bus.transmit.push_back(command);
      }
    }
  }
  for (const JointOptions& joint : options.joints) {
    const BusOptions& bus = buses[joint.bus];
    for (const IdFilter& reply :
         find_family(joint.drive.family)->make_drive(joint.drive)->reply_ids()) {
      if (holds(bus.transmit, reply)) {
        refuse(joint, fmt::format("its drive answers on 0x{:X}, which commands a drive on bus '{}'",
                                  reply.id, bus.name));
      }
    }
  }
  for (BusOptions& bus : buses) {
    if (options.simulated_time) {
      bus.receive.push_back({.id = kTickId, .extended = true});
    }
  }
  return buses;
}

}  // namespace geodesic::drivers
