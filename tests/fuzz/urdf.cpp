// Fuzz target: the URDF as text, and the mechanism that is made of what was accepted.
#include "config/urdf.hpp"

#include <cmath>

#include "control/mechanism/configuration.hpp"
#include "control/mechanism/gravity.hpp"
#include "control/mechanism/kinematics.hpp"
#include "control/mechanism/mechanism.hpp"
#include "control/mechanism/metric.hpp"
#include "control/mechanism/workspace.hpp"
#include "rt/heap_counter.hpp"
#include "tests/fuzz/fuzz.hpp"
#include "tests/fuzz/messages.hpp"

namespace geodesic::fuzz {
namespace {

void check_mechanism(const control::TreeDescription& tree, bool physical) {
  const control::Mechanism mechanism(tree, {0.0, 0.0, -9.81});
  if (mechanism.dof() == 0) return;
  control::Workspace workspace(mechanism);
  const Eigen::VectorXd q = control::neutral(mechanism);
  const std::uint64_t calls = rt::heap_calls();
  const Eigen::VectorXd& gravity = control::gravity(mechanism, workspace, q);
  const Eigen::MatrixXd& metric = control::metric(mechanism, workspace, q);
  expect(rt::heap_calls() == calls, "the mechanism's algorithms never touch the heap");
  expect(gravity.allFinite(), "gravity's torques are numbers");
  expect(metric.allFinite() && metric == metric.transpose(), "the metric is finite and symmetric");
  for (Eigen::Index i = 0; i < metric.rows(); ++i) {
    expect(!physical || metric(i, i) >= 0.0, "no motion has negative energy");
  }
}

}  // namespace

void urdf(Bytes bytes) {
  Input input(bytes);
  const bool strict = input.byte() == '!';
  const std::filesystem::path file =
      write_scratch("robot.urdf", as_text(strict ? input.rest() : bytes));
  const config::UrdfResult result = config::load_urdf(file, strict);
  check_messages(result.messages, result.ok);
  if (!result.ok) return;
  for (const control::JointDescription& joint : result.tree.joints) {
    expect(joint.parent_from_joint.matrix().allFinite() && joint.axis.allFinite(),
           "frames and axes are finite");
    expect(std::abs(joint.axis.norm() - 1.0) < 1e-9 || joint.kind == control::JointKind::kFixed,
           "an axis has length 1");
  }
  check_mechanism(result.tree, result.messages.empty());
}

}  // namespace geodesic::fuzz
