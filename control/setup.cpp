// What a running controller cannot take over, found by comparison.
#include "control/setup.hpp"

#include <algorithm>

namespace geodesic::control {
namespace {

class Differences {
 public:
  template <class T>
  void same(const T& from, const T& to, const std::string& what) {
    if (!(from == to)) {
      found_.push_back(what + " cannot change while the arm runs; start the daemon anew");
    }
  }
  void complain(const std::string& text) { found_.push_back(text); }
  bool any() const { return !found_.empty(); }
  std::vector<std::string> take() { return std::move(found_); }

 private:
  std::vector<std::string> found_;
};

std::string list(const std::vector<std::string>& names) {
  std::string text;
  for (const std::string& name : names) {
    text += (text.empty() ? "" : ", ") + name;
  }
  return text;
}

std::vector<std::string> names_of(const ControllerOptions& options) {
  std::vector<std::string> names;
  names.reserve(options.joints.size());
  for (const JointTuning& joint : options.joints) {
    names.push_back(joint.name);
  }
  return names;
}

std::string arms_in_words(const ControllerOptions& options) {
  std::string words;
  for (const ArmGroup& arm : options.arms) {
    words += arm.name + " " + std::to_string(arm.joints) + " ";
  }
  return words;
}

/// How the bodies hang on each other; their inertias are free.
void compare(const Mechanism& from, const Mechanism& to, Differences& differences) {
  differences.same(from.floating(), to.floating(), "whether the base floats");
  differences.same(from.joint_kinds(), to.joint_kinds(), "the kinds of the joints");
  if (from.bodies().size() != to.bodies().size()) {
    differences.complain("the number of moving bodies was " + std::to_string(from.bodies().size()) +
                         " and would be " + std::to_string(to.bodies().size()) +
                         "; start the daemon anew");
    return;
  }
  for (std::size_t i = 0; i < from.bodies().size(); ++i) {
    const Body& a = from.bodies()[i];
    const Body& b = to.bodies()[i];
    const auto dof = static_cast<std::size_t>(a.dof - from.first_joint_v());
    const std::string joint =
        dof < from.joint_names().size() ? "joint '" + from.joint_names()[dof] + "'" : "the base";
    differences.same(a.parent == b.parent && a.motion == b.motion && a.dof == b.dof, true,
                     joint + ": what it hangs on");
    differences.same(a.ratio == b.ratio && a.offset == b.offset, true, joint + ": what mimics it");
    differences.same(a.parent_from_joint.rotation == b.parent_from_joint.rotation &&
                         a.parent_from_joint.translation == b.parent_from_joint.translation,
                     true, joint + ": its place and axis");
  }
}

}  // namespace

std::vector<std::string> unexchangeable(const Setup& from, const Setup& to) {
  Differences differences;
  const std::vector<std::string> names = names_of(from.options);
  if (names != names_of(to.options)) {
    differences.complain("the joints are " + list(names) + " and would be " +
                         list(names_of(to.options)) + "; start the daemon anew");
  }
  differences.same(from.mechanism.joint_names(), to.mechanism.joint_names(),
                   "the joints of the mechanism");
  compare(from.mechanism, to.mechanism, differences);
  differences.same(arms_in_words(from.options), arms_in_words(to.options), "the arms");
  differences.same(from.options.law, to.options.law, "the law at start");
  differences.same(from.options.start_active, to.options.start_active, "start_active");
  differences.same(from.options.allow_zero_law, to.options.allow_zero_law, "allow_zero_law");
  for (const std::string& complaint : check(to.options)) {
    differences.complain(complaint);
  }
  return differences.take();
}

}  // namespace geodesic::control
