// Compares settings by path and trees by name; see difference.hpp.
#include "config/difference.hpp"

#include <fmt/format.h>

#include <map>
#include <string_view>

#include "config/options/options.hpp"

namespace geodesic::config {
namespace {

using control::JointDescription;
using control::LinkDescription;

constexpr const char* kAbsent = "-";

std::string shown(const Setting& setting) {
  if (!setting.value.empty()) return setting.value;
  return setting.fallback.empty() ? kAbsent : "(" + setting.fallback + ")";
}

std::map<std::string_view, const Setting*> by_path(const std::vector<Setting>& settings) {
  std::map<std::string_view, const Setting*> map;
  for (const Setting& setting : settings) map[setting.path] = &setting;
  return map;
}

/// Whether the setting belongs to an element (a joint, a payload) that `others` does not have.
bool in_absent_element(const Setting& setting,
                       const std::map<std::string_view, const Setting*>& own,
                       const std::map<std::string_view, const Setting*>& others) {
  if (setting.element || setting.steps.size() < 3) return false;
  const std::string element = setting.steps[0] + "." + setting.steps[1];
  const auto found = own.find(element);
  return found != own.end() && found->second->element && !others.contains(element);
}

class TreeDifference {
 public:
  TreeDifference(const Robot& from, const Robot& to, std::vector<Change>& changes)
      : from_(from), to_(to), changes_(changes) {}

  void run() {
    compare("urdf", "root", from_.tree.root_link, to_.tree.root_link, Live::kNo);
    each(from_.tree.links, to_.tree.links, "urdf.link.",
         [this](const std::string& path, const LinkDescription& a, const LinkDescription& b) {
           link(path, a, b);
         });
    each(from_.tree.joints, to_.tree.joints, "urdf.joint.",
         [this](const std::string& path, const JointDescription& a, const JointDescription& b) {
           joint(path, a, b);
         });
  }

 private:
  template <class T, class Compare>
  void each(const std::vector<T>& from, const std::vector<T>& to, const std::string& prefix,
            Compare compare_one) {
    std::map<std::string_view, const T*> before;
    for (const T& one : from) before[one.name] = &one;
    for (const T& one : to) {
      const auto found = before.find(one.name);
      if (found == before.end()) {
        add(prefix + one.name, kAbsent, "there", "", Live::kNo);
        continue;
      }
      compare_one(prefix + one.name, *found->second, one);
      before.erase(found);
    }
    for (const auto& [name, gone] : before) {
      add(prefix + std::string(name), "there", kAbsent, "", Live::kNo);
    }
  }

  void link(const std::string& path, const LinkDescription& a, const LinkDescription& b) {
    compare(path, "mass", number(a.inertia.mass_kg), number(b.inertia.mass_kg), Live::kYes, "kg");
    compare(path, "com", numbers(a.inertia.com_m), numbers(b.inertia.com_m), Live::kYes, "m");
    compare(path, "inertia", inertia(a), inertia(b), Live::kYes, "kg·m²");
  }

  void joint(const std::string& path, const JointDescription& a, const JointDescription& b) {
    const bool slides = b.kind == control::JointKind::kPrismatic;
    compare(path, "type", kind(a), kind(b), Live::kNo);
    compare(path, "parent", a.parent_link, b.parent_link, Live::kNo);
    compare(path, "child", a.child_link, b.child_link, Live::kNo);
    compare(path, "origin", pose(a), pose(b), Live::kNo);
    compare(path, "axis", numbers(a.axis), numbers(b.axis), Live::kNo);
    compare(path, "mimic", mimic(a), mimic(b), Live::kNo);
    compare(path, "lower", number(a.lower), number(b.lower), Live::kYes, slides ? "m" : "rad");
    compare(path, "upper", number(a.upper), number(b.upper), Live::kYes, slides ? "m" : "rad");
    compare(path, "effort", number(a.effort), number(b.effort), Live::kYes, slides ? "N" : "N·m");
    compare(path, "velocity", number(a.velocity), number(b.velocity), Live::kYes,
            slides ? "m/s" : "rad/s");
  }

  static std::string number(double value) { return fmt::format("{}", value); }
  static std::string numbers(const Eigen::Vector3d& v) {
    return fmt::format("[{}, {}, {}]", v[0], v[1], v[2]);
  }
  static std::string inertia(const LinkDescription& link) {
    const Eigen::Matrix3d& i = link.inertia.inertia_kg_m2;
    return fmt::format("[{}, {}, {}; {}, {}, {}]", i(0, 0), i(1, 1), i(2, 2), i(0, 1), i(0, 2),
                       i(1, 2));
  }
  static std::string kind(const JointDescription& joint) { return control::kind_name(joint.kind); }
  static std::string pose(const JointDescription& joint) {
    const Eigen::Matrix3d r = joint.parent_from_joint.linear();
    return fmt::format("{} {} {} {}", numbers(joint.parent_from_joint.translation()),
                       numbers(r.row(0)), numbers(r.row(1)), numbers(r.row(2)));
  }
  static std::string mimic(const JointDescription& joint) {
    if (!joint.mimic) return "none";
    return fmt::format("{} * {} + {}", joint.mimic->joint, joint.mimic->multiplier,
                       joint.mimic->offset);
  }

  void compare(const std::string& path, const char* what, const std::string& a,
               const std::string& b, Live live, const char* unit = "") {
    if (a != b) add(path + "." + what, a, b, unit, live);
  }
  void add(std::string path, std::string a, std::string b, const char* unit, Live live) {
    changes_.push_back(
        {std::move(path), std::move(a), std::move(b), unit, live, Place{to_.urdf, 0, 0}});
  }

  const Robot& from_;
  const Robot& to_;
  std::vector<Change>& changes_;
};

}  // namespace

std::string to_string(const Change& change) {
  return fmt::format("{}: {} -> {}{}{}", change.path, change.from, change.to,
                     change.unit.empty() ? "" : " ", change.unit);
}

std::vector<Change> difference(const Robot& from, const Robot& to) {
  std::vector<Change> changes;
  const auto before = by_path(from.settings);
  const auto after = by_path(to.settings);
  for (const Setting& now : to.settings) {
    if (in_absent_element(now, after, before)) continue;
    const auto found = before.find(now.path);
    const std::string was = found == before.end() ? kAbsent : shown(*found->second);
    if (found != before.end() && found->second->value == now.value) continue;
    changes.push_back({now.path, was, shown(now), now.unit, now.live, now.place});
  }
  for (const Setting& gone : from.settings) {
    if (after.contains(gone.path) || in_absent_element(gone, before, after)) continue;
    changes.push_back({gone.path, shown(gone), kAbsent, gone.unit, gone.live, {}});
  }
  TreeDifference(from, to, changes).run();
  return changes;
}

}  // namespace geodesic::config
