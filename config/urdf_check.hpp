// Checks a URDF's structure and numbers before anybody computes with it: names, references, one
// root, no loop. Says nothing of whether the figures are plausible (urdf_lint.hpp).
#pragma once

#include <map>
#include <string>

#include "config/findings.hpp"
#include "config/urdf_document.hpp"

namespace geodesic::config {

struct UrdfIndex {
  std::map<std::string, const tinyxml2::XMLElement*> links;
  std::map<std::string, const tinyxml2::XMLElement*> joints;
};

/// Reports everything that keeps the document from being a tree of rigid bodies.
UrdfIndex check_urdf(const UrdfDocument& document, Findings& findings);

}  // namespace geodesic::config
