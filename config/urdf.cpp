// Reading a URDF: checked as XML first (for places in messages), then read by urdfdom, then judged
// by the model lint; see urdf.hpp.
#include "config/urdf.hpp"

#include <console_bridge/console.h>
#include <fmt/format.h>
#include <urdf_parser/urdf_parser.h>

#include <cmath>
#include <cstring>
#include <mutex>

#include "config/files.hpp"
#include "config/urdf_check.hpp"
#include "config/urdf_document.hpp"
#include "config/urdf_lint.hpp"

namespace geodesic::config {
namespace {

using tinyxml2::XMLElement;

/// Keeps urdfdom from writing to the terminal, and what it would have written.
class QuietUrdfdom final : public console_bridge::OutputHandler {
 public:
  QuietUrdfdom() { console_bridge::useOutputHandler(this); }
  ~QuietUrdfdom() override { console_bridge::restorePreviousOutputHandler(); }
  QuietUrdfdom(const QuietUrdfdom&) = delete;
  QuietUrdfdom& operator=(const QuietUrdfdom&) = delete;

  void log(const std::string& text, console_bridge::LogLevel level, const char* /*file*/,
           int /*line*/) override {
    if (level >= console_bridge::CONSOLE_BRIDGE_LOG_ERROR && said_.empty()) said_ = text;
  }
  const std::string& said() const noexcept { return said_; }

 private:
  std::string said_;
};

/// Copies an element without what is in it, white space in its attributes made single (urdfdom
/// splits numbers at single spaces only).
XMLElement& copy(const XMLElement& from, tinyxml2::XMLNode& into) {
  XMLElement* to = into.GetDocument()->NewElement(from.Name());
  for (const tinyxml2::XMLAttribute* a = from.FirstAttribute(); a != nullptr; a = a->Next()) {
    std::string value;
    if (std::strcmp(a->Name(), "name") == 0 || std::strcmp(a->Name(), "link") == 0 ||
        std::strcmp(a->Name(), "joint") == 0) {
      value = a->Value();
    } else {
      for (const char* at = a->Value(); *at != '\0'; ++at) {
        const bool space = std::strchr(" \t\r\n", *at) != nullptr;
        if (!space) {
          value += *at;
        } else if (!value.empty() && value.back() != ' ') {
          value += ' ';
        }
      }
      if (!value.empty() && value.back() == ' ') value.pop_back();
    }
    to->SetAttribute(a->Name(), value.c_str());
  }
  into.InsertEndChild(to);
  return *to;
}

void copy_children(const XMLElement& from, XMLElement& to,
                   std::initializer_list<const char*> names) {
  for (const char* name : names) {
    if (const XMLElement* child = from.FirstChildElement(name)) copy(*child, to);
  }
}

/// What geodesic needs of the document and has checked, and nothing else: a mesh that is not there
/// or an extension of somebody's simulator must not keep an arm from running.
std::string essence(const XMLElement& robot) {
  tinyxml2::XMLDocument document;
  XMLElement* root = document.NewElement("robot");
  root->SetAttribute("name", robot.Attribute("name"));
  document.InsertEndChild(root);
  for (const XMLElement* e = robot.FirstChildElement(); e != nullptr; e = e->NextSiblingElement()) {
    if (std::strcmp(e->Name(), "link") == 0) {
      XMLElement& link = copy(*e, *root);
      if (const XMLElement* inertial = e->FirstChildElement("inertial")) {
        copy_children(*inertial, copy(*inertial, link), {"origin", "mass", "inertia"});
      }
    } else if (std::strcmp(e->Name(), "joint") == 0) {
      copy_children(*e, copy(*e, *root), {"origin", "parent", "child", "axis", "limit", "mimic"});
    }
  }
  tinyxml2::XMLPrinter printer;
  document.Print(&printer);
  return printer.CStr();
}

Eigen::Matrix3d rotation(const urdf::Rotation& r) {
  return Eigen::Quaterniond(r.w, r.x, r.y, r.z).toRotationMatrix();
}

Eigen::Vector3d vector(const urdf::Vector3& v) {
  return {v.x, v.y, v.z};
}

control::LinkDescription convert(const urdf::Link& link) {
  control::LinkDescription out;
  out.name = link.name;
  if (link.inertial == nullptr) return out;
  const urdf::Inertial& in = *link.inertial;
  const Eigen::Matrix3d turn = rotation(in.origin.rotation);
  Eigen::Matrix3d inertia;
  inertia << in.ixx, in.ixy, in.ixz, in.ixy, in.iyy, in.iyz, in.ixz, in.iyz, in.izz;
  out.inertia.mass_kg = in.mass;
  out.inertia.com_m = vector(in.origin.position);
  out.inertia.inertia_kg_m2 = turn * inertia * turn.transpose();
  return out;
}

control::JointKind kind(const urdf::Joint& joint) {
  switch (joint.type) {
    case urdf::Joint::REVOLUTE:
      return control::JointKind::kRevolute;
    case urdf::Joint::CONTINUOUS:
      return control::JointKind::kContinuous;
    case urdf::Joint::PRISMATIC:
      return control::JointKind::kPrismatic;
    case urdf::Joint::PLANAR:
      return control::JointKind::kPlanar;
    case urdf::Joint::FLOATING:
      return control::JointKind::kFloating;
    default:
      return control::JointKind::kFixed;  // all others were refused by check_urdf
  }
}

control::JointDescription convert(const urdf::Joint& joint) {
  control::JointDescription out;
  out.name = joint.name;
  out.kind = kind(joint);
  out.parent_link = joint.parent_link_name;
  out.child_link = joint.child_link_name;
  const urdf::Pose& pose = joint.parent_to_joint_origin_transform;
  out.parent_from_joint.linear() = rotation(pose.rotation);
  out.parent_from_joint.translation() = vector(pose.position);
  if (out.kind == control::JointKind::kFixed || out.kind == control::JointKind::kFloating) {
    return out;
  }
  const Eigen::Vector3d axis = vector(joint.axis);
  const double length = axis.norm();
  out.axis = length == 1.0 ? axis : Eigen::Vector3d(axis / length);
  // What a limit of a planar joint would bound, URDF does not say.
  if (joint.limits != nullptr && control::freedoms(out.kind) == 1) {
    if (out.kind != control::JointKind::kContinuous) {
      out.lower = joint.limits->lower;
      out.upper = joint.limits->upper;
    }
    out.effort = joint.limits->effort;
    out.velocity = joint.limits->velocity;
  }
  if (joint.mimic != nullptr) {
    out.mimic = {joint.mimic->joint_name, joint.mimic->multiplier, joint.mimic->offset};
  }
  return out;
}

bool read_by_urdfdom(const UrdfDocument& document, control::TreeDescription& tree,
                     Findings& findings) {
  static std::mutex one_at_a_time;  // console_bridge's handler is global
  const std::lock_guard lock(one_at_a_time);
  const QuietUrdfdom quiet;
  const urdf::ModelInterfaceSharedPtr model = urdf::parseURDF(essence(document.robot()));
  if (model == nullptr || model->getRoot() == nullptr) {
    findings.error(document.place(document.robot()),
                   fmt::format("urdfdom cannot read this file: {}",
                               quiet.said().empty() ? "it gives no reason" : quiet.said()));
    return false;
  }
  tree.name = model->getName();
  tree.root_link = model->getRoot()->name;
  for (const auto& [name, link] : model->links_) tree.links.push_back(convert(*link));
  for (const auto& [name, joint] : model->joints_) tree.joints.push_back(convert(*joint));
  return true;
}

}  // namespace

UrdfResult load_urdf(const std::filesystem::path& file, bool strict,
                     std::optional<std::string> text) {
  UrdfResult result;
  Findings findings;
  if (!text) text = read_file(file, findings);
  if (text) {
    result.text = *text;
    UrdfDocument document(file, *text);
    if (document.parse(findings)) {
      const UrdfIndex index = check_urdf(document, findings);
      for (const auto& [name, e] : index.links) result.links[name] = document.place(*e);
      for (const auto& [name, e] : index.joints) result.joints[name] = document.place(*e);
      if (!findings.has_errors() && read_by_urdfdom(document, result.tree, findings)) {
        lint_urdf(result, document, index, strict, findings);
      }
    }
  }
  result.ok = !findings.has_errors();
  result.messages = findings.take();
  return result;
}

}  // namespace geodesic::config
