// What a difference between measured and modelled torque looks like: a load the model does not
// know, or masses it has wrong. Only the guess; the difference is found in static_check.hpp.
#pragma once

#include <array>
#include <cstdint>

#include "control/joint.hpp"

namespace geodesic::control {

class Mechanism;
struct Workspace;

enum class Suspect : std::uint8_t {
  kNone,       ///< neither of these: the joint is held, or its offset is wrong
  kWrongSign,  ///< the torque acts the other way round
  kWrongMass,  ///< all masses are off by about the same part
  kPayload,    ///< a load at the tool that the model does not know
};

struct Suspicion {
  Suspect what = Suspect::kNone;
  double size = 0.0;  ///< kWrongMass: part of the model's masses; kPayload: [kg]
};

/// What was measured of an arm, in order of v.
struct LoadEvidence {
  const std::array<double, kMaxJoints>& position;
  const std::array<double, kMaxJoints>& velocity;
  const std::array<double, kMaxJoints>& external;  ///< observed external torque
  const std::array<double, kMaxJoints>& drive;     ///< torque of the drives
};

/// Fits the external torques of the joints in `group` by one number each way, least squares, and
/// takes the better fit. Masses off by the part e: -e M(q) a - e b(q, v), that is -e times all
/// torque on the joint; a load of m at the origin of `link`: -m J'(J a - gravity). The acceleration
/// a counts, since what falls weighs nothing; it follows from the torques by the model. Neither, if
/// the better fit leaves more than half of the squares.
/// @param link  index in mechanism.links()    Real-time, O(joints depth).
Suspicion suspect_load(const Mechanism& mechanism, Workspace& workspace,
                       const LoadEvidence& evidence, std::uint32_t group, int link) noexcept;

}  // namespace geodesic::control
