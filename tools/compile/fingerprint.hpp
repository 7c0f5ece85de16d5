// A short name for all that a mechanism's dynamics depend on. No security: what a file may do is
// decided by who owns it (library.hpp).
#pragma once

#include <string>

#include "control/mechanism/mechanism.hpp"

namespace geodesic::tools::compile {

/// 32 hexadecimal digits over joint names, how bodies hang together, their constants, gravity and
/// rotor inertias, each to the bit: the same on every machine, another for every other mechanism.
std::string fingerprint(const control::Mechanism& mechanism);

/// The same over bytes.
std::string digest(const char* bytes, std::size_t size);

}  // namespace geodesic::tools::compile
