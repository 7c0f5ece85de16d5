// Payloads: what the arm carries becomes part of the link that holds it. Checked in payloads.cpp.
#pragma once

#include "config/robot.hpp"
#include "control/mechanism/tree.hpp"

namespace geodesic::config {

/// The tree with the payload's mass as part of its link. Without payload it is the same to the bit.
control::TreeDescription with_payload(control::TreeDescription tree, const Payload& payload);

}  // namespace geodesic::config
