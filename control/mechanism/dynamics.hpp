// Everything that can be asked of a mechanism, in one include. README.md says which file computes
// what, and from which source.
#pragma once

// IWYU pragma: begin_exports
#include "control/mechanism/articulated_body.hpp"
#include "control/mechanism/christoffel.hpp"
#include "control/mechanism/configuration.hpp"
#include "control/mechanism/connection.hpp"
#include "control/mechanism/coriolis.hpp"
#include "control/mechanism/curvature.hpp"
#include "control/mechanism/energy.hpp"
#include "control/mechanism/external_wrench.hpp"
#include "control/mechanism/forward_dynamics.hpp"
#include "control/mechanism/gravity.hpp"
#include "control/mechanism/inertial_parameters.hpp"
#include "control/mechanism/jacobian_rate.hpp"
#include "control/mechanism/kinematics.hpp"
#include "control/mechanism/link_frame.hpp"
#include "control/mechanism/mechanism.hpp"
#include "control/mechanism/metric.hpp"
#include "control/mechanism/momentum.hpp"
#include "control/mechanism/momentum_map.hpp"
#include "control/mechanism/momentum_matrix.hpp"
#include "control/mechanism/musical.hpp"
#include "control/mechanism/newton_euler.hpp"
#include "control/mechanism/regressor.hpp"
#include "control/mechanism/workspace.hpp"
// IWYU pragma: end_exports
