// The model lint; see urdf_lint.hpp.
#include "config/urdf_lint.hpp"

#include <fmt/format.h>

#include <set>

#include "control/mechanism/inertia_check.hpp"

namespace geodesic::config {
namespace {

using control::JointDescription;
using control::JointKind;
using control::LinkDescription;

class Lint {
 public:
  Lint(const UrdfResult& result, const UrdfDocument& document, const UrdfIndex& index, bool strict,
       Findings& findings)
      : tree_(result.tree),
        document_(document),
        index_(index),
        strict_(strict),
        findings_(findings) {
    for (const JointDescription& joint : tree_.joints) {
      children_[joint.parent_link].push_back(&joint);
    }
    for (const LinkDescription& link : tree_.links) mass_[link.name] = link.inertia.mass_kg;
  }

  void run() {
    for (const LinkDescription& link : tree_.links) inertia(link);
    // Everything that a joint moves, root first; a list in place of recursion, since files may be
    // as deep as they like.
    std::vector<std::pair<std::string, bool>> open = {{tree_.root_link, false}};
    std::vector<std::string> order;
    while (!open.empty()) {
      const auto [link, moves] = open.back();
      open.pop_back();
      order.push_back(link);
      if (moves) moving_.insert(link);
      for (const JointDescription* joint : children_[link]) {
        open.emplace_back(joint->child_link, moves || joint->kind != JointKind::kFixed);
      }
    }
    for (auto link = order.rbegin(); link != order.rend(); ++link) {
      for (const JointDescription* joint : children_[*link]) {
        carried_[*link] += carried_[joint->child_link];
      }
      carried_[*link] += mass_[*link];
    }
    for (const LinkDescription& link : tree_.links) {
      if (moving_.count(link.name) > 0) moving_link(link);
    }
    for (const JointDescription& joint : tree_.joints) {
      if (joint.kind != JointKind::kFixed) moving_joint(joint);
    }
  }

 private:
  void odd(const Place& place, std::string text) {
    findings_.add({strict_ ? Message::Severity::kError : Message::Severity::kWarning, place,
                   std::move(text)});
  }

  Place in_link(const std::string& name, std::initializer_list<const char*> path) const {
    const tinyxml2::XMLElement* at = index_.links.at(name);
    for (const char* step : path) {
      if (at->FirstChildElement(step) != nullptr) at = at->FirstChildElement(step);
    }
    return document_.place(*at);
  }

  void inertia(const LinkDescription& link) {
    const control::InertiaVerdict verdict = control::check_inertia(link.inertia);
    if (verdict.physical) return;
    const Place place = in_link(link.name, {"inertial", "inertia"});
    if (link.inertia.mass_kg <= 0.0) {
      return odd(place, fmt::format("link {} has inertia but no mass; expected both or neither",
                                    quote(link.name)));
    }
    const Eigen::Vector3d& p = verdict.principal;
    const Eigen::Matrix3d& n = verdict.nearest.inertia_kg_m2;
    odd(place,
        fmt::format(
            "link {}: no body can have this inertia: {} (principal moments {:.4g}, {:.4g}, "
            "{:.4g} kg·m²; of any body the two smaller add up to the largest or more). It "
            "is used as written. The nearest physical one: ixx=\"{:.6g}\" ixy=\"{:.6g}\" "
            "ixz=\"{:.6g}\" iyy=\"{:.6g}\" iyz=\"{:.6g}\" izz=\"{:.6g}\" (about the centre of "
            "mass, link axes)",
            quote(link.name), verdict.reason, p[0], p[1], p[2], n(0, 0), n(0, 1), n(0, 2), n(1, 1),
            n(1, 2), n(2, 2)));
  }

  void moving_link(const LinkDescription& link) {
    const double mass = link.inertia.mass_kg;
    if (mass > 50.0) {
      odd(in_link(link.name, {"inertial", "mass"}),
          fmt::format("link {} has a mass of {} kg; expected less than 50 kg in a moving link: is "
                      "it in grams?",
                      quote(link.name), mass));
    } else if (mass > 0.0 && mass < 1e-3) {
      odd(in_link(link.name, {"inertial", "mass"}),
          fmt::format("link {} has a mass of {} kg; expected at least 1 g in a link with mass",
                      quote(link.name), mass));
    }
    if (const double distance = link.inertia.com_m.norm(); mass > 0.0 && distance > 1.0) {
      odd(in_link(link.name, {"inertial", "origin"}),
          fmt::format(
              "the centre of mass of link {} is {:.4g} m from its joint; expected less than "
              "1 m: is it in millimetres?",
              quote(link.name), distance));
    }
  }

  void moving_joint(const JointDescription& joint) {
    const tinyxml2::XMLElement& element = *index_.joints.at(joint.name);
    if (carried_[joint.child_link] <= 0.0) {
      odd(document_.place(element),
          fmt::format("nothing that joint {} moves has mass; the arm's inertia is singular there "
                      "without a rotor_inertia",
                      quote(joint.name)));
    }
    const tinyxml2::XMLElement* limit = element.FirstChildElement("limit");
    if (limit == nullptr) return;
    if (joint.effort == 0.0) {
      odd(document_.place(*limit, "effort"),
          fmt::format("joint {} has effort 0; it is taken as not stated", quote(joint.name)));
    }
    if (joint.velocity == 0.0) {
      odd(document_.place(*limit, "velocity"),
          fmt::format("joint {} has velocity 0; it is taken as not stated", quote(joint.name)));
    }
    if (joint.lower == joint.upper) {
      odd(document_.place(*limit),
          fmt::format(
              "joint {} cannot move: lower and upper are both {}; expected a fixed joint, or "
              "limits",
              quote(joint.name), joint.lower));
    }
  }

  const control::TreeDescription& tree_;
  const UrdfDocument& document_;
  const UrdfIndex& index_;
  bool strict_;
  Findings& findings_;
  std::map<std::string, std::vector<const JointDescription*>> children_;
  std::map<std::string, double> mass_;
  std::map<std::string, double> carried_;
  std::set<std::string> moving_;
};

}  // namespace

void lint_urdf(const UrdfResult& result, const UrdfDocument& document, const UrdfIndex& index,
               bool strict, Findings& findings) {
  Lint(result, document, index, strict, findings).run();
}

}  // namespace geodesic::config
