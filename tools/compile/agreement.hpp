// Does a compiled model compute what control/mechanism does? A thousand states say.
#pragma once

#include <Eigen/Core>
#include <memory>
#include <string>

#include "control/mechanism/compiled_model.hpp"
#include "control/mechanism/mechanism.hpp"
#include "tools/compile/library.hpp"

namespace geodesic::tools::compile {

inline constexpr int kAgreementStates = 1000;
inline constexpr double kAgreement = 1e-12;

/// The worst of all states.
struct Agreement {
  /// Largest difference of an entry over the largest entry of the same result; results smaller than
  /// a thousandth of the function's largest are measured by that (an arm that hangs straight down).
  double worst = 0.0;
  std::string function;  ///< whose
  Eigen::VectorXd q;     ///< where
  Eigen::VectorXd v;
  int states = 0;
  /// A number that is not finite went in and a finite torque came out: where. Empty: never.
  std::string hides;

  bool holds() const noexcept { return worst <= kAgreement && hides.empty(); }
};

/// In words, with the state.
std::string to_string(const Agreement& agreement);

/// At zero, at quarter turns and unit speeds of one joint at a time, and at random: angles over the
/// joint's range and a fifth more (two turns either way where there are no limits). The same states
/// every time. Takes some milliseconds. Sizes must fit.
Agreement compare(const geodesic_compiled& model, const control::Mechanism& mechanism);

/// A library that was found to agree with one mechanism. It lives as long as its functions are
/// used.
class VerifiedModel {
 public:
  /// @throws CompiledModelError if the file is not whole, was made for another mechanism, or
  ///   disagrees: with figure and state. @param robot  the robot's file, for the command to rebuild
  VerifiedModel(const std::filesystem::path& file, const control::Mechanism& mechanism,
                const std::filesystem::path& robot);

  /// Null if the mechanism is another than the one it agrees with.
  const control::CompiledModel* functions_for(const control::Mechanism& mechanism) const;
  const std::string& fingerprint() const noexcept { return fingerprint_; }
  const Agreement& agreement() const noexcept { return agreement_; }

 private:
  Library library_;
  control::CompiledModel functions_;
  std::string fingerprint_;
  Agreement agreement_;
};

}  // namespace geodesic::tools::compile
