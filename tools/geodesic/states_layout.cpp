// Implements states_layout.hpp.
#include "tools/geodesic/states_layout.hpp"

#include <fmt/format.h>
#include <fmt/ranges.h>

#include <algorithm>
#include <cmath>
#include <map>
#include <optional>

#include "tools/geodesic/command.hpp"

namespace geodesic::tools {
namespace {

using control::Factor;
using control::JointKind;

bool turns(const Factor& factor) {
  return factor.kind == JointKind::kRevolute || factor.kind == JointKind::kContinuous;
}

/// With its angle written as (cos, sin), or -1 if it has none.
int length_on_the_circle(const Factor& factor) {
  return turns(factor) ? 2 : factor.kind == JointKind::kPlanar ? 4 : -1;
}

std::vector<std::string> names_of(const std::vector<Factor>& factors) {
  std::vector<std::string> names;
  names.reserve(factors.size());
  for (const Factor& factor : factors) names.push_back(factor.name);
  return names;
}

}  // namespace

StatesLayout::StatesLayout(const control::Mechanism& mechanism)
    : own_(mechanism.factors()), theirs_(own_) {
  settle();
}

StatesLayout::StatesLayout(const control::Mechanism& mechanism,
                           const std::vector<FileJoint>& joints, int q_size,
                           const std::string& where)
    : own_(mechanism.factors()), theirs_(own_) {
  if (joints.empty()) {
    infer_lengths(q_size, where);
    settle();
    return;
  }
  const bool base_listed = mechanism.floating() && !joints.empty() &&
                           std::any_of(joints.begin(), joints.end(), [&](const FileJoint& joint) {
                             return joint.name == control::kBaseName || joint.nv == 6;
                           });
  std::map<std::string, const FileJoint*> listed;
  std::vector<std::string> order;
  if (mechanism.floating() && !base_listed) order.emplace_back(control::kBaseName);
  for (const FileJoint& joint : joints) {
    const bool ours = std::any_of(own_.begin(), own_.end(),
                                  [&](const Factor& each) { return each.name == joint.name; });
    // The base may have any name.
    const std::string name =
        !ours && joint.nv == 6 && mechanism.floating() ? control::kBaseName : joint.name;
    if (!listed.emplace(name, &joint).second) {
      throw BadInput(fmt::format("{}: joints: {} is listed twice", where, joint.name));
    }
    order.push_back(name);
  }
  std::vector<std::string> expected = names_of(own_);
  std::vector<std::string> found = order;
  std::sort(expected.begin(), expected.end());
  std::sort(found.begin(), found.end());
  if (expected != found) {
    std::vector<std::string> missing;
    std::vector<std::string> unknown;
    std::set_difference(expected.begin(), expected.end(), found.begin(), found.end(),
                        std::back_inserter(missing));
    std::set_difference(found.begin(), found.end(), expected.begin(), expected.end(),
                        std::back_inserter(unknown));
    throw BadInput(fmt::format(
        "{}: joints: not this robot's{}{}; its independent joints are {}", where,
        missing.empty() ? "" : fmt::format("; not listed: {}", fmt::join(missing, ", ")),
        unknown.empty() ? "" : fmt::format("; unknown: {}", fmt::join(unknown, ", ")),
        fmt::join(names_of(own_), ", ")));
  }
  int next_q = 0;
  int next_v = 0;
  bool lengths_told = true;
  std::map<std::string, Factor> placed;
  for (const std::string& name : order) {
    Factor factor = *std::find_if(own_.begin(), own_.end(),
                                  [&](const Factor& each) { return each.name == name; });
    const auto told = listed.find(name);
    if (told != listed.end()) {
      const FileJoint& joint = *told->second;
      if (joint.nv >= 0 && joint.nv != factor.nv) {
        throw BadInput(fmt::format("{}: joints: {} has nv {}; this robot's {} joint has {}", where,
                                   name, joint.nv, control::kind_name(factor.kind), factor.nv));
      }
      if (joint.nq >= 0 && joint.nq != factor.nq && joint.nq != length_on_the_circle(factor)) {
        throw BadInput(fmt::format("{}: joints: {} has nq {}; expected {} for a {} joint", where,
                                   name, joint.nq, factor.nq, control::kind_name(factor.kind)));
      }
      lengths_told = lengths_told && (joint.nq >= 0 || turns(factor));
      if (joint.nq >= 0) factor.nq = joint.nq;
      factor.q = joint.idx_q >= 0 ? joint.idx_q : next_q;
      factor.v = joint.idx_v >= 0 ? joint.idx_v : next_v;
    } else {
      factor.q = next_q;
      factor.v = next_v;
    }
    next_q = std::max(next_q, factor.q + factor.nq);
    next_v = std::max(next_v, factor.v + factor.nv);
    placed[name] = factor;
  }
  for (std::size_t i = 0; i < own_.size(); ++i) theirs_[i] = placed.at(own_[i].name);
  const bool told = std::all_of(joints.begin(), joints.end(),
                                [](const FileJoint& joint) { return joint.nq >= 0; });
  if (!told) infer_lengths(q_size, where);
  settle();
  // Every number belongs to one joint.
  Eigen::VectorXi uses_of_q = Eigen::VectorXi::Zero(nq_);
  Eigen::VectorXi uses_of_v = Eigen::VectorXi::Zero(nv_);
  for (const Factor& factor : theirs_) {
    uses_of_q.segment(factor.q, factor.nq).array() += 1;
    uses_of_v.segment(factor.v, factor.nv).array() += 1;
  }
  if ((uses_of_q.array() != 1).any() || (uses_of_v.array() != 1).any()) {
    throw BadInput(fmt::format("{}: joints: idx_q, nq, idx_v, nv overlap or leave gaps", where));
  }
}

/// With no lengths told: the mechanism's own, or every continuous joint (then every turning one) as
/// (cos, sin) and every planar one as (x, y, cos, sin), whichever fits.
void StatesLayout::infer_lengths(int q_size, const std::string& where) {
  std::vector<Factor> in_order = theirs_;
  std::sort(in_order.begin(), in_order.end(),
            [](const Factor& a, const Factor& b) { return a.v < b.v; });
  const auto with = [&](auto on_the_circle) {
    std::vector<Factor> trial = in_order;
    int at = 0;
    for (Factor& factor : trial) {
      if (on_the_circle(factor)) factor.nq = length_on_the_circle(factor);
      factor.q = at;
      at += factor.nq;
    }
    return std::make_pair(at, trial);
  };
  const std::pair<int, std::vector<Factor>> trials[] = {
      with([](const Factor&) { return false; }), with([](const Factor& f) {
        return f.kind == JointKind::kContinuous || f.kind == JointKind::kPlanar;
      }),
      with([](const Factor& f) { return turns(f) || f.kind == JointKind::kPlanar; })};
  std::vector<int> sizes;
  for (const auto& [size, trial] : trials) {
    if (size == q_size || q_size < 0) {
      for (Factor& factor : theirs_) {
        factor = *std::find_if(trial.begin(), trial.end(),
                               [&](const Factor& each) { return each.name == factor.name; });
      }
      return;
    }
    if (sizes.empty() || sizes.back() != size) sizes.push_back(size);
  }
  throw BadInput(fmt::format("{}: states[0].q: expected {} numbers, found {}{}", where,
                             fmt::join(sizes, " or "), q_size,
                             q_size == sizes.front() + 7 ? "; --floating?" : ""));
}

void StatesLayout::settle() {
  nq_ = 0;
  nv_ = 0;
  for (std::size_t i = 0; i < own_.size(); ++i) {
    const Factor& ours = own_[i];
    const Factor& theirs = theirs_[i];
    nq_ = std::max(nq_, theirs.q + theirs.nq);
    nv_ = std::max(nv_, theirs.v + theirs.nv);
    plain_ = plain_ && ours.q == theirs.q && ours.nq == theirs.nq && ours.v == theirs.v;
    reorders_only_ = reorders_only_ && (ours.kind != JointKind::kPlanar || ours.nq == theirs.nq);
  }
}

Eigen::VectorXd StatesLayout::own_q(const Eigen::VectorXd& file_q, const std::string& where) const {
  int size = 0;
  for (const Factor& ours : own_) size += ours.nq;
  Eigen::VectorXd q(size);
  const auto unit = [&](const auto& part, const Factor& theirs, const char* what) {
    if (std::abs(part.norm() - 1.0) > 1e-6) {
      throw BadInput(fmt::format("{}.q: elements {} to {} ({}) must be {}", where,
                                 theirs.q + theirs.nq - part.size(), theirs.q + theirs.nq - 1,
                                 theirs.name, what));
    }
  };
  for (std::size_t i = 0; i < own_.size(); ++i) {
    const Factor& ours = own_[i];
    const Factor& theirs = theirs_[i];
    if (ours.nq != theirs.nq) {  // the last of ours is an angle
      const Eigen::Vector2d circle = file_q.segment<2>(theirs.q + theirs.nq - 2);
      unit(circle, theirs, "the cosine and sine of one angle");
      q.segment(ours.q, ours.nq - 1) = file_q.segment(theirs.q, ours.nq - 1);
      q[ours.q + ours.nq - 1] = std::atan2(circle.y(), circle.x());
      continue;
    }
    q.segment(ours.q, ours.nq) = file_q.segment(theirs.q, ours.nq);
    if (ours.nq > ours.nv) {
      unit(file_q.segment<4>(theirs.q + theirs.nq - 4), theirs, "a unit quaternion (x y z w)");
    }
  }
  return q;
}

Eigen::MatrixXd StatesLayout::own_from_file(const Eigen::VectorXd& q) const {
  Eigen::MatrixXd turn = Eigen::MatrixXd::Zero(nv_, nv_);
  for (std::size_t i = 0; i < own_.size(); ++i) {
    const Factor& ours = own_[i];
    const Factor& theirs = theirs_[i];
    turn.block(ours.v, theirs.v, ours.nv, ours.nv).setIdentity();
    if (ours.kind == JointKind::kPlanar && ours.nq != theirs.nq) {
      const double c = std::cos(q[ours.q + 2]);
      const double s = std::sin(q[ours.q + 2]);
      turn.block<2, 2>(ours.v, theirs.v) << c, -s, s, c;
    }
  }
  return turn;
}

Eigen::MatrixXd StatesLayout::own_from_file_rate(const Eigen::VectorXd& q,
                                                 const Eigen::VectorXd& v) const {
  Eigen::MatrixXd rate = Eigen::MatrixXd::Zero(nv_, nv_);
  for (std::size_t i = 0; i < own_.size(); ++i) {
    const Factor& ours = own_[i];
    const Factor& theirs = theirs_[i];
    if (ours.kind == JointKind::kPlanar && ours.nq != theirs.nq) {
      const double c = std::cos(q[ours.q + 2]);
      const double s = std::sin(q[ours.q + 2]);
      rate.block<2, 2>(ours.v, theirs.v) << -s, -c, c, -s;
      rate.block<2, 2>(ours.v, theirs.v) *= v[ours.v + 2];
    }
  }
  return rate;
}

}  // namespace geodesic::tools
