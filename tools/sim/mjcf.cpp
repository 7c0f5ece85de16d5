// Writes a robot as a MuJoCo model text; see the header.
#include "tools/sim/mjcf.hpp"

#include <fmt/format.h>

#include <Eigen/Geometry>
#include <algorithm>
#include <cmath>
#include <map>
#include <stdexcept>

#include "control/mechanism/inertia_check.hpp"

namespace geodesic::tools {
namespace {

using control::JointDescription;
using control::JointKind;

// MuJoCo needs some mass behind every joint; a link this light changes nothing that can be
// measured.
constexpr double kLeastMass = 1e-6;
constexpr double kLeastInertia = 1e-9;

// Constraints of MuJoCo give way a little. These make them as stiff as the step allows: dry
// friction holds with less than 1e-5 rad of creep in 20 s, stops and mimic gears within microns.
constexpr const char* kFrictionImpedance = R"(solimpfriction="0.9999 0.9999 0.001")";
constexpr const char* kStopImpedance = R"(solimplimit="0.99 0.9999 0.0005")";

std::string numbers(const Eigen::Vector3d& v) {
  return fmt::format("{:.17g} {:.17g} {:.17g}", v.x(), v.y(), v.z());
}

std::string orientation(const Eigen::Matrix3d& rotation) {
  const Eigen::Quaterniond q(rotation);
  return fmt::format("{:.17g} {:.17g} {:.17g} {:.17g}", q.w(), q.x(), q.y(), q.z());
}

class Writer {
 public:
  explicit Writer(const MjcfInput& input) : in_(input) {
    for (std::size_t i = 0; i < in_.tree.links.size(); ++i) link_[in_.tree.links[i].name] = i;
    for (std::size_t i = 0; i < in_.tree.joints.size(); ++i) {
      const JointDescription& joint = in_.tree.joints[i];
      joint_[joint.name] = i;
      children_[joint.parent_link].push_back(i);
    }
    for (std::size_t i = 0; i < in_.joints.size(); ++i) order_[in_.joints[i]] = i;
  }

  Mjcf write() {
    if (!link_.contains(in_.tree.root_link)) {
      throw std::invalid_argument("the tree's root link '" + in_.tree.root_link + "' is no link");
    }
    const double floor_z = in_.simulation.floor_z_m;
    out_.xml = fmt::format(
        "<mujoco><compiler angle=\"radian\" coordinate=\"local\" inertiafromgeom=\"false\" "
        "balanceinertia=\"false\" boundmass=\"0\" boundinertia=\"0\"/>\n"
        "<size njmax=\"2000\" nconmax=\"400\"/>\n"
        "<option timestep=\"{:.17g}\" gravity=\"{}\" integrator=\"Euler\" solver=\"Newton\" "
        "iterations=\"100\" tolerance=\"1e-14\" cone=\"elliptic\" impratio=\"10\">"
        "<flag energy=\"enable\" warmstart=\"enable\"/></option>\n<worldbody>\n",
        in_.timestep_s, numbers(in_.gravity));
    if (in_.simulation.floor) {
      out_.xml += fmt::format(
          "<geom name=\"floor\" type=\"plane\" size=\"0 0 1\" pos=\"0 0 {:.17g}\" "
          "contype=\"0\" conaffinity=\"1\" friction=\"0.8 0.005 0.0001\"/>\n",
          floor_z);
    }
    body(in_.tree.root_link, nullptr);
    out_.xml += "</worldbody>\n<equality>\n" + equality_ + "</equality>\n</mujoco>\n";
    return std::move(out_);
  }

 private:
  // One link: its pose in the parent, its joint, its inertia, its geometry, its children.
  void body(const std::string& name, const JointDescription* joint) {  // NOLINT(misc-no-recursion)
    const auto found = link_.find(name);
    if (found == link_.end()) {
      throw std::invalid_argument("joint '" + (joint != nullptr ? joint->name : std::string()) +
                                  "' names link '" + name + "', which there is not");
    }
    const std::size_t index = found->second;
    if (++depth_ > 256) throw std::invalid_argument("the tree loops at link '" + name + "'");
    const Eigen::Isometry3d pose =
        joint != nullptr ? joint->parent_from_joint : Eigen::Isometry3d::Identity();
    out_.xml += fmt::format("<body name=\"b{}\" pos=\"{}\" quat=\"{}\">\n", index,
                            numbers(pose.translation()), orientation(pose.linear()));
    const bool moves = joint != nullptr && joint->kind != JointKind::kFixed;
    if (moves) dof(*joint);
    inertial(in_.tree.links[index], moves);
    geometry(index);
    for (const std::size_t child : children_[name]) {
      body(in_.tree.joints[child].child_link, &in_.tree.joints[child]);
    }
    out_.xml += "</body>\n";
    --depth_;
  }

  void dof(const JointDescription& joint) {
    if (control::freedoms(joint.kind) != 1) {
      throw std::invalid_argument(fmt::format(
          "joint '{}' is {}; the simulated arm has joints with one degree of freedom only",
          joint.name, control::kind_name(joint.kind)));
    }
    const std::size_t index = joint_.at(joint.name);
    config::SimulatedJoint own;
    if (const auto place = order_.find(joint.name); place != order_.end()) {
      if (place->second < in_.simulation.joints.size()) own = in_.simulation.joints[place->second];
    }
    out_.xml += fmt::format(
        "<joint name=\"j{}\" type=\"{}\" axis=\"{}\" damping=\"{:.17g}\" armature=\"{:.17g}\"",
        index, joint.kind == JointKind::kPrismatic ? "slide" : "hinge", numbers(joint.axis),
        own.viscous_friction, own.rotor_inertia);
    if (own.coulomb_friction > 0.0) {
      // Direct form (negative numbers): velocity is taken out within one step, the stiffest stable.
      out_.xml += fmt::format(" frictionloss=\"{:.17g}\" solreffriction=\"-1 -{:.17g}\" {}",
                              own.coulomb_friction, 1.0 / in_.timestep_s, kFrictionImpedance);
    }
    if (joint.mimic) {
      mimic(index, joint);
    } else if (joint.kind != JointKind::kContinuous && std::isfinite(joint.lower) &&
               std::isfinite(joint.upper) && joint.lower < joint.upper) {
      out_.xml +=
          fmt::format(" limited=\"true\" range=\"{:.17g} {:.17g}\" solreflimit=\"{:.17g} 1\" {}",
                      joint.lower, joint.upper, 8.0 * in_.timestep_s, kStopImpedance);
    }
    out_.xml += "/>\n";
  }

  // A mimic of a mimic follows the joint at the end of the row.
  void mimic(std::size_t index, const JointDescription& joint) {
    double multiplier = 1.0;
    double offset = 0.0;
    const JointDescription* leader = &joint;
    for (int hops = 0; leader->mimic; ++hops) {
      const auto next = joint_.find(leader->mimic->joint);
      if (next == joint_.end() || hops > 32) {
        throw std::invalid_argument("joint '" + joint.name + "' mimics '" + leader->mimic->joint +
                                    "', which there is not");
      }
      offset += multiplier * leader->mimic->offset;
      multiplier *= leader->mimic->multiplier;
      leader = &in_.tree.joints[next->second];
    }
    equality_ += fmt::format(
        "<joint joint1=\"j{}\" joint2=\"j{}\" polycoef=\"{:.17g} {:.17g} 0 0 0\" "
        "solref=\"{:.17g} 1\" solimp=\"0.9999 0.9999 0.001\"/>\n",
        index, joint_.at(leader->name), offset, multiplier, 4.0 * in_.timestep_s);
  }

  void inertial(const control::LinkDescription& link, bool moves) {
    double mass = link.inertia.mass_kg;
    Eigen::Matrix3d inertia = link.inertia.inertia_kg_m2;
    if (mass <= 0.0) {
      // A frame without mass is fine as long as something heavy is rigidly behind its joint.
      if (!moves || carries_mass(link.name)) return;
      out_.warnings.push_back(fmt::format("link '{}' moves and has no mass: simulated with {} kg",
                                          link.name, kLeastMass));
      mass = kLeastMass;
      inertia = Eigen::Matrix3d::Identity() * kLeastInertia;
    }
    inertia = physical(link, inertia);
    out_.xml += fmt::format(
        "<inertial pos=\"{}\" mass=\"{:.17g}\" fullinertia=\"{:.17g} {:.17g} {:.17g} {:.17g} "
        "{:.17g} {:.17g}\"/>\n",
        numbers(link.inertia.com_m), mass, inertia(0, 0), inertia(1, 1), inertia(2, 2),
        inertia(0, 1), inertia(0, 2), inertia(1, 2));
  }

  bool carries_mass(const std::string& name) {  // NOLINT(misc-no-recursion)
    for (const std::size_t child : children_[name]) {
      const JointDescription& joint = in_.tree.joints[child];
      if (joint.kind != JointKind::kFixed) continue;
      const auto link = link_.find(joint.child_link);
      if (link == link_.end()) continue;
      if (in_.tree.links[link->second].inertia.mass_kg > 0.0) return true;
      if (carries_mass(joint.child_link)) return true;
    }
    return false;
  }

  // MuJoCo refuses an inertia that no body can have; published files do have them.
  Eigen::Matrix3d physical(const control::LinkDescription& link, const Eigen::Matrix3d& inertia) {
    control::LinkInertia whole = link.inertia;
    whole.inertia_kg_m2 = inertia;
    const control::InertiaVerdict verdict = control::check_inertia(whole);
    Eigen::Matrix3d result = verdict.nearest.inertia_kg_m2;
    if (!verdict.physical) {
      out_.warnings.push_back(
          fmt::format("link '{}': {}; simulated with the nearest inertia a body can have",
                      link.name, verdict.reason));
    }
    // MuJoCo's own check has no tolerance: rods and plates, just on the edge, are made a hair
    // thicker.
    result += Eigen::Matrix3d::Identity() * std::max(1e-9 * result.trace(), kLeastInertia * 1e-3);
    return result;
  }

  // A capsule to each child's origin, or a small ball at the centre of mass: enough to touch a
  // floor with. Links touch nothing but the floor.
  void geometry(std::size_t index) {
    if (!in_.simulation.floor) return;
    const control::LinkDescription& link = in_.tree.links[index];
    constexpr const char* kTouch = "contype=\"1\" conaffinity=\"0\" friction=\"0.8 0.005 0.0001\"";
    double reach = 0.0;
    Eigen::Vector3d far = Eigen::Vector3d::Zero();
    for (const std::size_t child : children_[link.name]) {
      const Eigen::Vector3d end = in_.tree.joints[child].parent_from_joint.translation();
      if (end.norm() <= reach) continue;
      reach = end.norm();
      far = end;
    }
    if (reach > 0.02) {
      out_.xml += fmt::format(
          "<geom name=\"g{}\" type=\"capsule\" size=\"{:.17g}\" fromto=\"0 0 0 {}\" {}/>\n", index,
          std::min(0.02, 0.2 * reach), numbers(far), kTouch);
    } else if (link.inertia.mass_kg > 0.0) {
      out_.xml += fmt::format("<geom name=\"g{}\" type=\"sphere\" size=\"0.02\" pos=\"{}\" {}/>\n",
                              index, numbers(link.inertia.com_m), kTouch);
    }
  }

  const MjcfInput& in_;
  Mjcf out_;
  std::string equality_;
  int depth_ = 0;
  std::map<std::string, std::size_t> link_;                   // index into tree.links
  std::map<std::string, std::size_t> joint_;                  // index into tree.joints
  std::map<std::string, std::size_t> order_;                  // index in order of v
  std::map<std::string, std::vector<std::size_t>> children_;  // joints by parent link
};

}  // namespace

Mjcf write_mjcf(const MjcfInput& input) {
  return Writer(input).write();
}

}  // namespace geodesic::tools
