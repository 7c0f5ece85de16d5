// Structure and numbers of a URDF; see urdf_check.hpp.
#include "config/urdf_check.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <cstring>
#include <set>
#include <string_view>

namespace geodesic::config {
namespace {

using tinyxml2::XMLElement;

template <class T>
std::vector<std::string> names_of(const std::map<std::string, T>& map) {
  std::vector<std::string> names;
  names.reserve(map.size());
  for (const auto& [name, unused] : map) names.push_back(name);
  return names;
}

bool has_many_freedoms(std::string_view type) {
  return type == "planar" || type == "floating";
}

class Checker {
 public:
  Checker(const UrdfDocument& document, Findings& findings)
      : document_(document), findings_(findings), numbers_(document, findings) {}

  UrdfIndex run() {
    const XMLElement& robot = document_.robot();
    if (robot.Attribute("name") == nullptr || *robot.Attribute("name") == '\0') {
      error(robot, "<robot> has no name=\"...\"");
    }
    for (const XMLElement* e = robot.FirstChildElement(); e; e = e->NextSiblingElement()) {
      if (std::strcmp(e->Name(), "link") == 0) {
        if (collect(*e, index_.links)) link(*e);
      } else if (std::strcmp(e->Name(), "joint") == 0) {
        collect(*e, index_.joints);
      } else if (std::strncmp(e->Name(), "xacro:", 6) == 0) {
        error(*e, fmt::format("found <{}>: this is a xacro source, expected a URDF; expand it "
                              "first: xacro FILE > robot.urdf",
                              e->Name()));
        return index_;
      }
    }
    if (index_.links.empty()) error(robot, "<robot> has no <link>");
    for (const auto& [name, element] : index_.joints) joint(name, *element);
    if (structure_is_whole_) tree();
    return index_;
  }

 private:
  void error(const XMLElement& element, std::string text) {
    findings_.error(document_.place(element), std::move(text));
  }
  void error(const XMLElement& element, const char* attribute, std::string text) {
    findings_.error(document_.place(element, attribute), std::move(text));
  }

  bool collect(const XMLElement& e, std::map<std::string, const XMLElement*>& into) {
    const char* name = e.Attribute("name");
    if (name == nullptr || *name == '\0') {
      error(e, fmt::format("<{}> has no name=\"...\"", e.Name()));
      structure_is_whole_ = false;
      return false;
    }
    const auto [place, inserted] = into.emplace(name, &e);
    if (!inserted) {
      error(e, "name",
            fmt::format("a second {} {}; the first is in line {}", e.Name(), quote(name),
                        place->second->GetLineNum()));
      structure_is_whole_ = false;
    }
    return inserted;
  }

  /// The child element of that name; a second one is an error, since readers differ on which
  /// counts.
  const XMLElement* only_child(const XMLElement& parent, const char* name) {
    const XMLElement* child = parent.FirstChildElement(name);
    if (child != nullptr && child->NextSiblingElement(name) != nullptr) {
      error(*child->NextSiblingElement(name),
            fmt::format("a second <{}> in {} {}; expected one", name, parent.Name(),
                        quote(parent.Attribute("name") ? parent.Attribute("name") : "")));
    }
    return child;
  }

  void origin(const XMLElement& parent) {
    if (const XMLElement* e = only_child(parent, "origin")) {
      numbers_.triple(*e, "xyz", {});
      numbers_.triple(*e, "rpy", {});
    }
  }

  void link(const XMLElement& e) {
    const XMLElement* inertial = only_child(e, "inertial");
    if (inertial == nullptr) return;
    origin(*inertial);
    if (const XMLElement* mass = only_child(*inertial, "mass")) {
      const auto value = numbers_.required(*mass, "value");
      if (value && *value < 0.0) {
        error(*mass, "value",
              fmt::format("link {} has mass {} kg, expected 0 or more", quote(e.Attribute("name")),
                          *value));
      }
    } else {
      error(*inertial, fmt::format("<inertial> of link {} has no <mass value=\"...\"/>",
                                   quote(e.Attribute("name"))));
    }
    if (const XMLElement* inertia = only_child(*inertial, "inertia")) {
      for (const char* entry : {"ixx", "ixy", "ixz", "iyy", "iyz", "izz"}) {
        numbers_.required(*inertia, entry);
      }
    } else {
      error(*inertial, fmt::format("<inertial> of link {} has no <inertia ixx=\"...\" .../>",
                                   quote(e.Attribute("name"))));
    }
  }

  void joint(const std::string& name, const XMLElement& e) {
    const std::string type = e.Attribute("type") ? e.Attribute("type") : "";
    const bool moves = type == "revolute" || type == "continuous" || type == "prismatic";
    if (!moves && !has_many_freedoms(type) && type != "fixed") {
      error(e, "type",
            fmt::format("joint {}: found type {}, expected revolute, continuous, "
                        "prismatic, planar, floating or fixed",
                        quote(name), quote(type)));
    }
    origin(e);
    const std::string parent = end(name, e, "parent");
    const std::string child = end(name, e, "child");
    if (!child.empty()) {
      const auto [place, inserted] = parent_joint_.emplace(child, &e);
      if (!inserted) {
        error(*e.FirstChildElement("child"), "link",
              fmt::format("link {} is the child of joint {} already (line {}); a link hangs on one "
                          "joint",
                          quote(child), quote(place->second->Attribute("name")),
                          place->second->GetLineNum()));
        structure_is_whole_ = false;
      }
    }
    if (!parent.empty() && parent == child) {
      error(e, fmt::format("joint {} joins link {} to itself", quote(name), quote(child)));
      structure_is_whole_ = false;
    }
    if (has_many_freedoms(type) && e.FirstChildElement("mimic") != nullptr) {
      error(*e.FirstChildElement("mimic"),
            fmt::format("joint {} is {} and mimics another; only a revolute, continuous or "
                        "prismatic joint can",
                        quote(name), type));
    }
    if (type == "planar") axis(name, e);
    if (!moves) return;
    axis(name, e);
    limits(name, e, type != "continuous");
    mimic(name, e);
  }

  /// The link at one end of a joint; empty, with a finding, if there is none.
  std::string end(const std::string& name, const XMLElement& e, const char* which) {
    const XMLElement* element = only_child(e, which);
    const char* link = element == nullptr ? nullptr : element->Attribute("link");
    if (link == nullptr) {
      error(element == nullptr ? e : *element,
            fmt::format("joint {} has no <{} link=\"...\"/>", quote(name), which));
      structure_is_whole_ = false;
      return {};
    }
    if (index_.links.count(link) == 0) {
      const std::vector<std::string> known = names_of(index_.links);
      error(*element, "link",
            fmt::format("joint {}: there is no link {}{}", quote(name), quote(link),
                        did_you_mean(link, known)));
      structure_is_whole_ = false;
      return {};
    }
    return link;
  }

  void axis(const std::string& name, const XMLElement& e) {
    const XMLElement* element = only_child(e, "axis");
    if (element == nullptr) return;
    // urdfdom takes an axis without its figures for 0 0 0.
    if (element->Attribute("xyz") == nullptr) {
      error(*element, fmt::format("<axis> of joint {} has no xyz=\"...\"", quote(name)));
      return;
    }
    const auto found = numbers_.triple(*element, "xyz", {});
    if (!found) return;
    const double length = std::hypot((*found)[0], (*found)[1], (*found)[2]);
    if (length < 1e-6) {
      error(*element, "xyz",
            fmt::format("joint {} has the axis 0 0 0, expected a direction", quote(name)));
    } else if (length > 1e6) {
      error(*element, "xyz",
            fmt::format("joint {} has an axis of length {:.3g}, expected a direction of length 1",
                        quote(name), length));
    }
  }

  void limits(const std::string& name, const XMLElement& e, bool needed) {
    const XMLElement* element = only_child(e, "limit");
    if (element == nullptr) {
      if (needed) {
        error(e, fmt::format("joint {} has no <limit lower=\"...\" upper=\"...\" effort=\"...\" "
                             "velocity=\"...\"/>; only continuous joints go without",
                             quote(name)));
      }
      return;
    }
    const auto lower = numbers_.optional(*element, "lower", 0.0);
    const auto upper = numbers_.optional(*element, "upper", 0.0);
    if (lower && upper && *lower > *upper) {
      error(*element, "lower",
            fmt::format("joint {}: lower {} is above upper {}", quote(name), *lower, *upper));
    }
    for (const char* attribute : {"effort", "velocity"}) {
      const auto value = numbers_.required(*element, attribute);
      if (value && *value < 0.0) {
        error(
            *element, attribute,
            fmt::format("joint {}: {} is {}, expected 0 or more", quote(name), attribute, *value));
      }
    }
  }

  void mimic(const std::string& name, const XMLElement& e) {
    const XMLElement* element = only_child(e, "mimic");
    if (element == nullptr) return;
    numbers_.optional(*element, "multiplier", 1.0);
    numbers_.optional(*element, "offset", 0.0);
    const std::string other = element->Attribute("joint") ? element->Attribute("joint") : "";
    const auto found = index_.joints.find(other);
    if (found == index_.joints.end()) {
      error(*element, "joint",
            fmt::format("joint {} mimics {}, which does not exist{}", quote(name), quote(other),
                        did_you_mean(other, names_of(index_.joints))));
      return;
    }
    const char* type = found->second->Attribute("type");
    if (other == name || found->second->FirstChildElement("mimic") != nullptr ||
        (type != nullptr && (std::strcmp(type, "fixed") == 0 || has_many_freedoms(type)))) {
      error(*element, "joint",
            fmt::format("joint {} mimics {}, expected another joint that moves "
                        "on its own, with one degree of freedom",
                        quote(name), quote(other)));
    }
  }

  /// One root, and everything hangs on it. Every link has at most one parent joint by now.
  void tree() {
    std::vector<std::string> roots;
    for (const auto& [name, element] : index_.links) {
      if (parent_joint_.count(name) == 0) roots.push_back(name);
    }
    if (roots.size() > 1) {
      std::sort(roots.begin(), roots.end(), [this](const std::string& a, const std::string& b) {
        return index_.links[a]->GetLineNum() < index_.links[b]->GetLineNum();
      });
      error(*index_.links[roots[1]],
            fmt::format("{} links are nobody's child: {}; expected one root, join them",
                        roots.size(), list_names(roots)));
      return;
    }
    // A link from which going up never ends is in a loop, or hangs on one.
    std::set<std::string> good(roots.begin(), roots.end());
    for (const auto& [start, element] : index_.links) {
      std::vector<std::string> path;
      std::set<std::string> seen;
      for (std::string at = start; good.count(at) == 0;) {
        path.push_back(at);
        if (!seen.insert(at).second) {
          error(*parent_joint_[at],
                fmt::format("a loop of joints: {}; expected a tree", list_names(path)));
          return;
        }
        at = parent_joint_[at]->FirstChildElement("parent")->Attribute("link");
      }
      good.insert(path.begin(), path.end());
    }
  }

  const UrdfDocument& document_;
  Findings& findings_;
  UrdfNumbers numbers_;
  UrdfIndex index_;
  std::map<std::string, const XMLElement*> parent_joint_;
  bool structure_is_whole_ = true;
};

}  // namespace

UrdfIndex check_urdf(const UrdfDocument& document, Findings& findings) {
  return Checker(document, findings).run();
}

}  // namespace geodesic::config
