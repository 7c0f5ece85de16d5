// Spends the freedom of frames and hands masses on; see reduced_tree.hpp.
#include "tools/compile/reduced_tree.hpp"

#include <fmt/format.h>

#include <Eigen/Geometry>
#include <cmath>
#include <numbers>

namespace geodesic::tools::compile {
namespace {

using control::Body;
using control::kWorld;
using control::Motion;
using Eigen::Matrix3d;
using Eigen::Vector3d;

/// A turn about one axis; a quarter turn has exact zeros.
struct Turn {
  double cosine = 1.0;
  double sine = 0.0;
  double angle() const { return std::atan2(sine, cosine); }
};

double snapped(double value, double snap) {
  for (const double whole : {-1.0, 0.0, 1.0}) {
    if (std::abs(value - whole) <= snap) return whole;
  }
  return value;
}

Turn turn_towards(double x, double y, double snap) {
  const double length = std::hypot(x, y);
  Turn turn{x / length, y / length};
  // Near a quarter turn one of the two is 1 to second order: both follow the small one.
  if (std::abs(turn.sine) <= snap) return {turn.cosine > 0.0 ? 1.0 : -1.0, 0.0};
  if (std::abs(turn.cosine) <= snap) return {0.0, turn.sine > 0.0 ? 1.0 : -1.0};
  return turn;
}

Matrix3d about_z(const Turn& turn) {
  Matrix3d r = Matrix3d::Identity();
  r.topLeftCorner<2, 2>() << turn.cosine, -turn.sine, turn.sine, turn.cosine;
  return r;
}

Matrix3d about_x(const Turn& turn) {
  Matrix3d r = Matrix3d::Identity();
  r.bottomRightCorner<2, 2>() << turn.cosine, -turn.sine, turn.sine, turn.cosine;
  return r;
}

/// How a body's new frame sits in its old one.
struct Adjustment {
  Matrix3d rotation = Matrix3d::Identity();
  Vector3d translation = Vector3d::Zero();
};

class Reducer {
 public:
  Reducer(const control::Mechanism& mechanism, const std::vector<Choice>& choices, double snap)
      : bodies_(mechanism.bodies()), snap_(snap) {
    tree_.gravity = mechanism.gravity();
    tree_.joint_names = mechanism.joint_names();
    tree_.rotor_inertia = mechanism.rotor_inertia();
    tree_.nq = mechanism.nq();
    tree_.nv = mechanism.dof();
    tree_.floating = mechanism.floating();
    tree_.bodies.resize(bodies_.size());
    adjustments_.resize(bodies_.size());
    for (std::size_t i = 0; i < choices.size() && i < bodies_.size(); ++i) {
      tree_.bodies[i].choice = choices[i];
    }
    label(mechanism.first_joint_v());
  }

  /// Once without sliding, to see the inertias that the choices are about, and once for good.
  ReducedTree run() {
    pass(nullptr);
    const std::vector<ReducedBody> first = tree_.bodies;
    pass(&first);
    return tree_;
  }

 private:
  void label(int first_joint) {
    std::vector<int> seen(static_cast<std::size_t>(tree_.nv), 0);
    for (std::size_t i = 0; i < bodies_.size(); ++i) {
      if (bodies_[i].motion == Motion::kFree) {
        tree_.bodies[i].label = fmt::format("{}", 0);
        continue;
      }
      const int dof = bodies_[i].dof;
      int& times = seen[static_cast<std::size_t>(dof)];
      const std::string suffix(times > 0 ? 1 : 0, static_cast<char>('a' + times));
      tree_.bodies[i].label = fmt::format("{}{}", dof - first_joint + 1, suffix);
      ++times;
    }
  }

  void pass(const std::vector<ReducedBody>* first) {
    for (std::size_t i = 0; i < bodies_.size(); ++i) {
      switch (bodies_[i].motion) {
        case Motion::kFree:
          adjustments_[i] = {};
          break;
        case Motion::kTranslation:
          place_sliding(i);
          break;
        default:
          place_turning(i, first != nullptr ? &(*first)[i] : nullptr);
          break;
      }
      take_over(i);
    }
    for (std::size_t i = bodies_.size(); i-- > 0;) hand_on(i);
  }

  const Adjustment& parent_adjustment(std::size_t i) const {
    static const Adjustment kNone;
    const int parent = bodies_[i].parent;
    return parent == kWorld ? kNone : adjustments_[static_cast<std::size_t>(parent)];
  }

  void place_sliding(std::size_t i) {
    const Body& from = bodies_[i];
    ReducedBody& body = tree_.bodies[i];
    const Adjustment& parent = parent_adjustment(i);
    const Matrix3d to_parent = parent.rotation.transpose();
    adjustments_[i].rotation = from.parent_from_joint.rotation.transpose() * parent.rotation;
    adjustments_[i].translation.setZero();
    body.axis = clean(to_parent * from.parent_from_joint.rotation.col(2));
    body.translation = clean(to_parent * (from.parent_from_joint.translation - parent.translation));
    body.slide = from.offset;
    body.rate = from.ratio;
  }

  /// The first body with a turning joint that hangs on `i`, sliding ones passed over.
  int first_turning_child(std::size_t i, Matrix3d& rotation, Vector3d& translation) const {
    for (std::size_t c = i + 1; c < bodies_.size(); ++c) {
      if (bodies_[c].parent != static_cast<int>(i)) continue;
      const auto& pose = bodies_[c].parent_from_joint;
      if (bodies_[c].motion == Motion::kTranslation) {
        Matrix3d inner;
        Vector3d place;
        const int found = first_turning_child(c, inner, place);
        if (found < 0) continue;
        rotation = pose.rotation * inner;
        translation = pose.translation + pose.rotation * place;
        return found;
      }
      rotation = pose.rotation;
      translation = pose.translation;
      return static_cast<int>(c);
    }
    return -1;
  }

  void place_turning(std::size_t i, const ReducedBody* first) {
    const Body& from = bodies_[i];
    ReducedBody& body = tree_.bodies[i];
    const Adjustment& parent = parent_adjustment(i);
    const Matrix3d to_parent = parent.rotation.transpose();
    Matrix3d rotation = to_parent * from.parent_from_joint.rotation;
    Vector3d translation = to_parent * (from.parent_from_joint.translation - parent.translation);

    // An axis that points backwards is turned round, and its joint's direction with it.
    double direction = 1.0;
    Matrix3d own = Matrix3d::Identity();
    if (rotation(2, 2) < -snap_) {
      own.diagonal() << 1.0, -1.0, -1.0;
      direction = -1.0;
      rotation = rotation * own;
    }
    // Rz(turn) Rx(tilt) Rz(after).
    const double tilt_sine = std::hypot(rotation(0, 2), rotation(1, 2));
    Turn tilt = turn_towards(rotation(2, 2), tilt_sine, snap_);
    Turn turn;
    if (tilt.sine != 0.0) turn = turn_towards(-rotation(1, 2), rotation(0, 2), snap_);
    const Matrix3d rest = about_z({turn.cosine, -turn.sine}) * rotation;
    const double after = std::atan2(-rest(0, 1), rest(0, 0));

    const Turn own_turn = choose_turn(i, own, after, first);
    own = own * about_z(own_turn);
    const double along = translation.dot(rotation.col(2));
    body.rate = direction * from.ratio;
    body.angle = {from.coordinate, body.rate, after + own_turn.angle() + direction * from.offset};
    if (std::abs(std::remainder(body.angle.offset, 2.0 * std::numbers::pi)) <= 1e-15) {
      body.angle.offset = 0.0;
    }
    const double slide = first == nullptr ? 0.0 : choose_slide(i, own, along, *first);
    body.turned = turn.sine != 0.0 || turn.cosine != 1.0;
    body.parallel = tilt.sine == 0.0;
    body.turn_cosine = turn.cosine;
    body.turn_sine = turn.sine;
    body.tilt_cosine = tilt.cosine;
    body.tilt_sine = tilt.sine;
    const Vector3d axis = about_z(turn) * about_x(tilt).col(2);
    body.axis = axis;
    body.translation = clean(translation + slide * axis);
    adjustments_[i].rotation = own;
    adjustments_[i].translation = slide * own.col(2);
  }

  /// Turns the frame about its z axis such that the first child's axis tilts about x; where there
  /// is nothing to tilt, as chosen.
  Turn choose_turn(std::size_t i, const Matrix3d& own, double after,
                   const ReducedBody* first) const {
    Matrix3d child_rotation;
    Vector3d child_translation;
    const int child = first_turning_child(i, child_rotation, child_translation);
    if (child >= 0) {
      Vector3d z = own.transpose() * child_rotation.col(2);
      if (z.z() < -snap_) z = -z;
      if (z.head<2>().norm() > std::max(snap_, 1e-15)) return turn_towards(-z.y(), z.x(), snap_);
      const Vector3d p = own.transpose() * child_translation;
      if (p.head<2>().norm() > 1e-9) return turn_towards(p.x(), p.y(), snap_);
      return {};
    }
    double turn = -after;  // makes the angle the joint's own
    if (first != nullptr && first->choice.turn == Choice::Turn::kFirstMoment) {
      const Vector3d& h = first->first_moment;
      turn += std::atan2(h.y(), h.x());
    } else if (first != nullptr && first->choice.turn == Choice::Turn::kSecondMoment) {
      const Matrix3d& s = first->second_moment;
      turn += 0.5 * std::atan2(2.0 * s(0, 1), s(0, 0) - s(1, 1));
    }
    return {std::cos(turn), std::sin(turn)};
  }

  /// [m] along the axis.
  double choose_slide(std::size_t i, const Matrix3d& own, double along,
                      const ReducedBody& first) const {
    const Choice& choice = tree_.bodies[i].choice;
    Matrix3d child_rotation;
    Vector3d child_translation;
    const bool has_child = first_turning_child(i, child_rotation, child_translation) >= 0;
    // As it is in the frame turned for good.
    const double further = tree_.bodies[i].angle.offset - first.angle.offset;
    const Matrix3d back = about_z({std::cos(further), -std::sin(further)});
    const Vector3d h = back * first.first_moment;
    const Vector3d s = back * first.second_moment.col(2);
    switch (choice.slide) {
      case Choice::Slide::kChild:
        if (has_child) return (own.transpose() * child_translation).z();
        break;
      case Choice::Slide::kMoment:
        if (std::abs(h.x()) > 1e-6 * h.norm()) return s.x() / h.x();
        break;
      case Choice::Slide::kOther:
        if (std::abs(h.y()) > 1e-6 * h.norm()) return s.y() / h.y();
        break;
      case Choice::Slide::kOwn:
        break;
    }
    return -along;
  }

  /// Rounding of a rotation leaves traces where there was nothing.
  Vector3d clean(Vector3d v) const {
    for (double& x : v) x = snapped(x, snap_) == 0.0 ? 0.0 : x;
    return v;
  }

  /// The body's own inertia, in its new frame.
  void take_over(std::size_t i) {
    const Body& from = bodies_[i];
    ReducedBody& body = tree_.bodies[i];
    body.parent = from.parent;
    body.motion = from.motion;
    body.dof = from.dof;
    body.coordinate = from.coordinate;
    const Adjustment& own = adjustments_[i];
    const Matrix3d to_own = own.rotation.transpose();
    Matrix3d inertia = from.inertia.rotational;
    inertia.triangularView<Eigen::StrictlyLower>() = inertia.transpose();
    const Matrix3d second = 0.5 * inertia.trace() * Matrix3d::Identity() - inertia;
    const double m = from.inertia.mass;
    const Vector3d& h = from.inertia.first_moment;
    const Vector3d t = own.translation;
    body.mass = m;
    body.first_moment = to_own * (h - m * t);
    body.second_moment = to_own *
                         (second - h * t.transpose() - t * h.transpose() + m * t * t.transpose()) *
                         own.rotation;
  }

  /// To the parent, what does not move in it.
  void hand_on(std::size_t i) {
    ReducedBody& body = tree_.bodies[i];
    if (body.motion == Motion::kFree) return;
    ReducedBody* parent =
        body.parent == kWorld ? nullptr : &tree_.bodies[static_cast<std::size_t>(body.parent)];
    if (body.motion == Motion::kTranslation) {
      if (parent != nullptr) parent->second_moment += body.second_moment;
      body.second_moment.setZero();
      return;
    }
    const double mass = body.mass;
    const double moment = body.first_moment.z();
    const double second = body.second_moment(2, 2);
    body.mass = 0.0;
    body.first_moment.z() = 0.0;
    body.second_moment(2, 2) = 0.0;
    wipe(body);
    if (parent == nullptr) return;
    const Vector3d& p = body.translation;
    const Vector3d& z = body.axis;
    parent->mass += mass;
    parent->first_moment += mass * p + moment * z;
    parent->second_moment += mass * p * p.transpose() +
                             moment * (p * z.transpose() + z * p.transpose()) +
                             second * z * z.transpose();
  }

  /// What a choice has taken to zero is zero but for rounding.
  void wipe(ReducedBody& body) const {
    const double scale = std::max(body.second_moment.cwiseAbs().maxCoeff(), 1e-300);
    for (double& x : body.second_moment.reshaped()) {
      if (std::abs(x) <= 1e-16 * scale + 1e-20) x = 0.0;
    }
    const double length = body.first_moment.norm();
    for (double& x : body.first_moment) {
      if (std::abs(x) <= 1e-16 * length) x = 0.0;
    }
  }

  const std::vector<Body>& bodies_;
  double snap_;
  ReducedTree tree_;
  std::vector<Adjustment> adjustments_;
};

}  // namespace

std::string uncompilable(const control::Mechanism& mechanism) {
  const auto& bodies = mechanism.bodies();
  for (std::size_t i = 0; i < bodies.size(); ++i) {
    const Motion motion = bodies[i].motion;
    if (motion == Motion::kRotation || motion == Motion::kTranslation) continue;
    if (motion == Motion::kFree && i == 0 && mechanism.floating()) continue;
    return fmt::format(
        "moving body {} of '{}' hangs on a spherical or floating joint; compiled are revolute, "
        "continuous, prismatic, planar and mimic joints, and a floating base; the model as it is "
        "read from the file (geodesicd without `compiled`) takes all kinds",
        i, mechanism.name());
  }
  if (mechanism.dof() == 0) return "no joint moves: there is nothing to compile";
  return {};
}

ReducedTree reduce(const control::Mechanism& mechanism, const std::vector<Choice>& choices,
                   double snap) {
  return Reducer(mechanism, choices, snap).run();
}

}  // namespace geodesic::tools::compile
