// Writes programs as one file of C++ that a person can read and any GCC or clang can build. What is
// computed was decided before; nothing here knows mechanics.
#pragma once

#include <string>
#include <vector>

#include "tools/compile/recursions.hpp"

namespace geodesic::tools::compile {

/// What stands in the file's head and in its description of itself.
struct Emission {
  std::string robot;
  std::string fingerprint;
  std::string generator;  ///< who wrote it, with version
  std::vector<std::string> joint_names;
  int nq = 0;
  int nv = 0;
  /// Which arm (part that shares nothing with the others) each number of q and of v belongs to.
  std::vector<int> arm_of_q;
  std::vector<int> arm_of_v;
  std::vector<Program> programs;  ///< bias, gravity, metric, inverse_dynamics
};

/// The same emission gives the same text.
std::string emit(const Emission& emission);

/// One function's statements (emit_program.cpp).
std::string emit_function(const Program& program, int nq, int nv);
/// Sine and cosine, checks of the input: the same in every file (emit_preamble.cpp).
std::string emit_preamble();

}  // namespace geodesic::tools::compile
