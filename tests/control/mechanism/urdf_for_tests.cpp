// Implements urdf_for_tests.hpp.
#include "tests/control/mechanism/urdf_for_tests.hpp"

#include <tinyxml2.h>

#include <set>
#include <sstream>
#include <stdexcept>

namespace geodesic::control::testing {
namespace {

using tinyxml2::XMLElement;

Eigen::Vector3d vector(const XMLElement* element, const char* name, const Eigen::Vector3d& absent) {
  const char* text = element != nullptr ? element->Attribute(name) : nullptr;
  if (text == nullptr) {
    return absent;
  }
  Eigen::Vector3d value;
  std::istringstream(text) >> value.x() >> value.y() >> value.z();
  return value;
}

Eigen::Isometry3d origin(const XMLElement* parent) {
  const XMLElement* element = parent->FirstChildElement("origin");
  const Eigen::Vector3d rpy = vector(element, "rpy", Eigen::Vector3d::Zero());
  Eigen::Isometry3d pose = Eigen::Isometry3d::Identity();
  pose.linear() = (Eigen::AngleAxisd(rpy.z(), Eigen::Vector3d::UnitZ()) *
                   Eigen::AngleAxisd(rpy.y(), Eigen::Vector3d::UnitY()) *
                   Eigen::AngleAxisd(rpy.x(), Eigen::Vector3d::UnitX()))
                      .toRotationMatrix();
  pose.translation() = vector(element, "xyz", Eigen::Vector3d::Zero());
  return pose;
}

LinkDescription link(const XMLElement* element) {
  LinkDescription result;
  result.name = element->Attribute("name");
  const XMLElement* inertial = element->FirstChildElement("inertial");
  if (inertial == nullptr) {
    return result;
  }
  const Eigen::Isometry3d pose = origin(inertial);
  const XMLElement* i = inertial->FirstChildElement("inertia");
  const auto figure = [&](const char* name) {
    return i != nullptr ? i->DoubleAttribute(name) : 0.0;
  };
  Eigen::Matrix3d inertia;
  inertia << figure("ixx"), figure("ixy"), figure("ixz"),  //
      figure("ixy"), figure("iyy"), figure("iyz"),         //
      figure("ixz"), figure("iyz"), figure("izz");
  result.inertia.mass_kg = inertial->FirstChildElement("mass")->DoubleAttribute("value");
  result.inertia.com_m = pose.translation();
  const Eigen::Matrix3d turned = pose.linear() * inertia * pose.linear().transpose();
  result.inertia.inertia_kg_m2 = 0.5 * (turned + turned.transpose());
  return result;
}

JointKind kind(const std::string& type) {
  if (type == "revolute") {
    return JointKind::kRevolute;
  }
  if (type == "continuous") {
    return JointKind::kContinuous;
  }
  if (type == "planar") {
    return JointKind::kPlanar;
  }
  if (type == "floating") {
    return JointKind::kFloating;
  }
  return type == "prismatic" ? JointKind::kPrismatic : JointKind::kFixed;
}

JointDescription joint(const XMLElement* element) {
  JointDescription result;
  result.name = element->Attribute("name");
  result.kind = kind(element->Attribute("type"));
  result.parent_link = element->FirstChildElement("parent")->Attribute("link");
  result.child_link = element->FirstChildElement("child")->Attribute("link");
  result.parent_from_joint = origin(element);
  const XMLElement* axis = element->FirstChildElement("axis");
  result.axis = vector(axis, "xyz", Eigen::Vector3d::UnitX()).normalized();
  if (const XMLElement* mimic = element->FirstChildElement("mimic")) {
    result.mimic =
        MimicDescription{mimic->Attribute("joint"), mimic->DoubleAttribute("multiplier", 1.0),
                         mimic->DoubleAttribute("offset", 0.0)};
  }
  return result;
}

}  // namespace

TreeDescription read_urdf(const std::filesystem::path& file) {
  tinyxml2::XMLDocument document;
  if (document.LoadFile(file.c_str()) != tinyxml2::XML_SUCCESS) {
    throw std::runtime_error(file.string() + ": " + document.ErrorStr());
  }
  const XMLElement* robot = document.FirstChildElement("robot");
  TreeDescription tree;
  tree.name = robot->Attribute("name");
  std::set<std::string> children;
  for (const auto* e = robot->FirstChildElement("joint"); e != nullptr;
       e = e->NextSiblingElement("joint")) {
    tree.joints.push_back(joint(e));
    children.insert(tree.joints.back().child_link);
  }
  for (const auto* e = robot->FirstChildElement("link"); e != nullptr;
       e = e->NextSiblingElement("link")) {
    tree.links.push_back(link(e));
    if (children.count(tree.links.back().name) == 0) {
      tree.root_link = tree.links.back().name;
    }
  }
  return tree;
}

}  // namespace geodesic::control::testing
