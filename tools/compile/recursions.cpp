// Newton-Euler and gravity on expressions; see recursions.hpp. The metric is in composite.cpp.
#include "tools/compile/recursions.hpp"

namespace geodesic::tools::compile {
namespace {

using control::kWorld;
using control::Motion;

/// How a body moves.
struct Course {
  Triple angular;
  Triple angular_rate;
  Triple acceleration;
};

/// U = hat(alpha) + hat(omega)^2, by rows, and what it is made of.
struct Spread {
  explicit Spread(const Course& course)
      : rate(course.angular_rate),
        square{course.angular.x * course.angular.x, course.angular.y * course.angular.y,
               course.angular.z * course.angular.z},
        xy(course.angular.x * course.angular.y),
        xz(course.angular.x * course.angular.z),
        yz(course.angular.y * course.angular.z),
        x{-(square.y + square.z), xy - rate.z, xz + rate.y},
        y{xy + rate.z, -(square.x + square.z), yz - rate.x},
        z{xz - rate.y, yz + rate.x, -(square.x + square.y)} {}
  Triple operator*(const Triple& r) const { return {dot(x, r), dot(y, r), dot(z, r)}; }
  Triple rate;
  Triple square;
  Number xy, xz, yz;
  Triple x, y, z;
};

/// Moment about the origin: h x a + sum of r x (U r), r over the body; S its second moments. A
/// difference of two of U's diagonal is one of two squares.
Triple moment_of(const ReducedBody& body, const Course& course, const Spread& u) {
  const auto& s = body.second_moment;
  const Number xx = s(0, 0);
  const Number yy = s(1, 1);
  const Number zz = s(2, 2);
  const Number xy = s(0, 1);
  const Number xz = s(0, 2);
  const Number yz = s(1, 2);
  const auto products = [&](int component) { return (body.choice.moment_form >> component) & 1; };
  Triple pair;
  pair.x = products(0) ? (yy - zz) * u.yz + (yy + zz) * u.rate.x : yy * u.z.y - zz * u.y.z;
  pair.y = products(1) ? (zz - xx) * u.xz + (zz + xx) * u.rate.y : zz * u.x.z - xx * u.z.x;
  pair.z = products(2) ? (xx - yy) * u.xy + (xx + yy) * u.rate.z : xx * u.y.x - yy * u.x.y;
  const Triple rest{xy * u.z.x - xz * u.y.x + yz * (u.square.z - u.square.y),
                    yz * u.x.y - xy * u.z.y + xz * (u.square.x - u.square.z),
                    xz * u.y.z - yz * u.x.z + xy * (u.square.y - u.square.x)};
  return cross(constant(body.first_moment), course.acceleration) + (pair + rest);
}

class NewtonEuler {
 public:
  NewtonEuler(const ReducedTree& tree, Graph& graph, bool accelerates)
      : frames_(tree, graph), graph_(graph), accelerates_(accelerates) {}

  std::vector<Number> run() {
    const auto n = static_cast<std::size_t>(frames_.size());
    course_.resize(n);
    head_course_.resize(n);
    speed_.resize(n);
    acceleration_.resize(n);
    force_.resize(n);
    moment_.resize(n);
    for (int i = 0; i < frames_.size(); ++i) outwards(i);
    std::vector<Number> result(static_cast<std::size_t>(frames_.tree().nv));
    for (int i = frames_.size() - 1; i >= 0; --i) inwards(i, result);
    return result;
  }

 private:
  Number velocity(int i) { return graph_.input(Array::kV, i); }
  Number given_acceleration(int i) {
    return accelerates_ ? graph_.input(Array::kA, i) : Number(0.0);
  }

  Course base_course() {
    const int first = frames_.body(0).dof;
    const Triple linear{velocity(first), velocity(first + 1), velocity(first + 2)};
    Course course;
    course.angular = {velocity(first + 3), velocity(first + 4), velocity(first + 5)};
    course.angular_rate = {given_acceleration(first + 3), given_acceleration(first + 4),
                           given_acceleration(first + 5)};
    course.acceleration = Triple{given_acceleration(first), given_acceleration(first + 1),
                                 given_acceleration(first + 2)} +
                          cross(course.angular, linear) + -frames_.gravity_of_base();
    return course;
  }

  void outwards(int i) {
    const auto at = static_cast<std::size_t>(i);
    const ReducedBody& body = frames_.body(i);
    Course& course = course_[at];
    if (body.motion == Motion::kFree) {
      course = base_course();
    } else {
      Course parent;
      if (body.parent == kWorld) {
        parent.acceleration = -constant(frames_.tree().gravity);
      } else {
        parent = course_[static_cast<std::size_t>(body.parent)];
      }
      const Triple origin = parent.acceleration + Spread(parent) * frames_.translation(i);
      const Number speed = body.rate * velocity(body.dof);
      const Number rate = body.rate * given_acceleration(body.dof);
      if (body.motion == Motion::kTranslation) {
        const Triple along = constant(body.axis);
        course = parent;
        course.acceleration = origin + 2.0 * speed * cross(parent.angular, along) + rate * along;
      } else {
        turn(i, parent, speed, rate);
        course.acceleration = frames_.to_body(i, origin);
      }
    }
    frames_.name(course.angular, "w", i);
    frames_.name(course.angular_rate, "dw", i);
    frames_.name(course.acceleration, "a", i);
    const Spread u(course);
    force_[at] = body.mass * course.acceleration + u * constant(body.first_moment);
    moment_[at] = moment_of(body, course, u);
    frames_.name(force_[at], "f", i);
    frames_.name(moment_[at], "n", i);
  }

  /// Angular velocity and its rate behind a turning joint. Bodies with parallel axes turn by the
  /// sum of their angles at the sum of their speeds.
  void turn(int i, const Course& parent, const Number& speed, const Number& rate) {
    const auto at = static_cast<std::size_t>(i);
    const int head = frames_.head(i);
    if (head == i) {
      head_course_[at].angular = frames_.tilted(i, parent.angular);
      head_course_[at].angular_rate = frames_.tilted(i, parent.angular_rate);
      speed_[at] = speed;
      acceleration_[at] = rate;
    } else {
      const auto before = static_cast<std::size_t>(frames_.body(i).parent);
      speed_[at] = speed_[before] + speed;
      acceleration_[at] = acceleration_[before] + rate;
    }
    const Course& fixed = head_course_[static_cast<std::size_t>(head)];
    Course& course = course_[at];
    course.angular = frames_.from_head(i, fixed.angular);
    course.angular_rate = frames_.from_head(i, fixed.angular_rate);
    course.angular_rate.x += speed_[at] * course.angular.y;
    course.angular_rate.y -= speed_[at] * course.angular.x;
    course.angular_rate.z += acceleration_[at];
    course.angular.z += speed_[at];
  }

  void inwards(int i, std::vector<Number>& result) {
    const auto at = static_cast<std::size_t>(i);
    const ReducedBody& body = frames_.body(i);
    const auto dof = static_cast<std::size_t>(body.dof);
    const Triple& force = force_[at];
    const Triple& moment = moment_[at];
    frames_.name(force, "F", i);
    frames_.name(moment, "N", i);
    if (body.motion == Motion::kFree) {
      const Number six[] = {force.x, force.y, force.z, moment.x, moment.y, moment.z};
      for (std::size_t k = 0; k < 6; ++k) result[dof + k] += six[k];
      return;
    }
    const bool turns = body.motion == Motion::kRotation;
    result[dof] += body.rate * (turns ? moment.z : dot(constant(body.axis), force));
    if (body.parent == kWorld) return;
    const auto parent = static_cast<std::size_t>(body.parent);
    const Triple on_parent = frames_.to_parent(i, force);
    force_[parent] = force_[parent] + on_parent;
    moment_[parent] =
        moment_[parent] + (frames_.to_parent(i, moment) + cross(frames_.translation(i), on_parent));
  }

  Frames frames_;
  Graph& graph_;
  bool accelerates_;
  std::vector<Course> course_;
  std::vector<Course> head_course_;  ///< of its parent, in tilted axes
  std::vector<Number> speed_;        ///< about z, of all bodies of the group so far
  std::vector<Number> acceleration_;
  std::vector<Triple> force_;
  std::vector<Triple> moment_;
};

}  // namespace

Program bias_program(const ReducedTree& tree) {
  Program program{.name = "bias", .arguments = {Array::kQ, Array::kV}, .outputs = {}};
  program.outputs = NewtonEuler(tree, *program.graph, false).run();
  return program;
}

Program inverse_dynamics_program(const ReducedTree& tree) {
  Program program{
      .name = "inverse_dynamics", .arguments = {Array::kQ, Array::kV, Array::kA}, .outputs = {}};
  program.outputs = NewtonEuler(tree, *program.graph, true).run();
  for (int i = 0; i < tree.nv; ++i) {
    program.outputs[static_cast<std::size_t>(i)] +=
        tree.rotor_inertia[i] * program.graph->input(Array::kA, i);
  }
  return program;
}

Program gravity_program(const ReducedTree& tree) {
  Program program{.name = "gravity", .arguments = {Array::kQ}, .outputs = {}};
  Frames frames(tree, *program.graph);
  const auto n = static_cast<std::size_t>(frames.size());
  std::vector<Triple> up(n);
  std::vector<Triple> up_in_head(n);
  std::vector<Triple> force(n);
  std::vector<Triple> moment(n);
  for (int i = 0; i < frames.size(); ++i) {
    const auto at = static_cast<std::size_t>(i);
    const ReducedBody& body = frames.body(i);
    const Triple above =
        body.parent == kWorld ? -constant(tree.gravity) : up[static_cast<std::size_t>(body.parent)];
    if (body.motion == Motion::kFree) {
      up[at] = -frames.gravity_of_base();
    } else if (body.motion == Motion::kTranslation) {
      up[at] = above;
    } else {
      if (frames.head(i) == i) up_in_head[at] = frames.tilted(i, above);
      up[at] = frames.from_head(i, up_in_head[static_cast<std::size_t>(frames.head(i))]);
    }
    frames.name(up[at], "up", i);
    force[at] = body.mass * up[at];
    moment[at] = cross(constant(body.first_moment), up[at]);
    frames.name(moment[at], "n", i);
  }
  program.outputs.resize(static_cast<std::size_t>(tree.nv));
  for (int i = frames.size() - 1; i >= 0; --i) {
    const auto at = static_cast<std::size_t>(i);
    const ReducedBody& body = frames.body(i);
    const auto dof = static_cast<std::size_t>(body.dof);
    frames.name(force[at], "F", i);
    frames.name(moment[at], "N", i);
    if (body.motion == Motion::kFree) {
      const Number six[] = {force[at].x,  force[at].y,  force[at].z,
                            moment[at].x, moment[at].y, moment[at].z};
      for (std::size_t k = 0; k < 6; ++k) program.outputs[dof + k] += six[k];
      continue;
    }
    const bool turns = body.motion == Motion::kRotation;
    program.outputs[dof] +=
        body.rate * (turns ? moment[at].z : dot(constant(body.axis), force[at]));
    if (body.parent == kWorld) continue;
    const auto parent = static_cast<std::size_t>(body.parent);
    const Triple on_parent = frames.to_parent(i, force[at]);
    force[parent] = force[parent] + on_parent;
    moment[parent] = moment[parent] +
                     (frames.to_parent(i, moment[at]) + cross(frames.translation(i), on_parent));
  }
  return program;
}

}  // namespace geodesic::tools::compile
