// From a mechanism's bodies to polynomials; see the header.
#include "tools/derive/symbolic_tree.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <stdexcept>

namespace geodesic::tools::derive {
namespace {

using control::Body;
using control::Mechanism;
using Kind = Letter::Kind;
using LongVector3 = Eigen::Matrix<long double, 3, 1>;
using Three = std::array<std::string, 3>;

// Differences of products of doubles that should have been nothing, next to their parts.
constexpr double kRounding = 1e-13;

Vector turned(const LongMatrix3& rotation, const Vector& vector) {
  Vector result;
  for (Eigen::Index i = 0; i < 3; ++i) {
    for (Eigen::Index j = 0; j < 3; ++j) {
      if (rotation(i, j) == 0.0L) continue;
      result[static_cast<std::size_t>(i)] += rotation(i, j) * vector[static_cast<std::size_t>(j)];
    }
  }
  return result;
}

Matrix transposed(const Matrix& matrix) {
  Matrix result;
  for (std::size_t i = 0; i < 3; ++i) {
    for (std::size_t j = 0; j < 3; ++j) result[i][j] = matrix[j][i];
  }
  return result;
}

// rotation * matrix * rotation'.
Matrix turned(const LongMatrix3& rotation, Matrix matrix) {
  for (int side = 0; side < 2; ++side) {
    matrix = transposed(matrix);
    for (Vector& row : matrix) row = turned(rotation, row);
  }
  return matrix;
}

// The joint's name and kind of every degree of freedom.
std::vector<Coordinate> coordinates(const Mechanism& mechanism) {
  std::vector<Coordinate> list;
  for (const control::Factor& factor : mechanism.factors()) {
    if (factor.kind == control::JointKind::kSpherical ||
        factor.kind == control::JointKind::kFloating) {
      throw std::invalid_argument(fmt::format(
          "joint '{}' is {}: its positions are a group that no one chart covers, so there is no "
          "closed form in coordinates that holds everywhere; `geodesic model` evaluates such "
          "robots. To derive one, replace the joint by revolute and prismatic ones",
          factor.name, control::kind_name(factor.kind)));
    }
    static constexpr std::array<const char*, 3> kPlane{"x", "y", "angle"};
    for (int i = 0; i < factor.nv; ++i) {
      const std::string number = std::to_string(list.size() + 1);
      const bool turns = factor.nv == 3 ? i == 2 : factor.kind != control::JointKind::kPrismatic;
      const std::string part =
          factor.nv == 3 ? fmt::format(", {}", kPlane[static_cast<std::size_t>(i)]) : "";
      list.push_back({fmt::format("{}{}", factor.name, part), control::kind_name(factor.kind),
                      turns, fmt::format("q{}", number), fmt::format("q_{{{}}}", number)});
    }
  }
  return list;
}

class Builder {
 public:
  Builder(const Mechanism& mechanism, bool letters) : mechanism_(mechanism), letters_(letters) {
    tree_.symbols.coordinates = coordinates(mechanism);
    for (const Body& body : mechanism.bodies()) list_angles(body);
    tree_.gravity = gravity();
    for (int dof = 0; dof < mechanism.dof(); ++dof) tree_.rotor.push_back(rotor(dof));
    for (std::size_t i = 0; i < mechanism.bodies().size(); ++i) add(static_cast<int>(i));
  }

  SymbolicTree take() { return std::move(tree_); }

 private:
  // Every angle of a degree of freedom is a whole multiple of one variable if a small fraction of
  // it will do; else it is a variable of its own.
  void list_angles(const Body& body) {
    if (body.motion != control::Motion::kRotation) return;
    auto& angles = tree_.symbols.angles;
    for (Angle& angle : angles) {
      if (angle.dof != body.dof) continue;
      if (is_whole(body.ratio / angle.ratio)) return;
    }
    angles.push_back({body.dof, is_whole(body.ratio) ? 1.0 : body.ratio});
    if (angles.size() > static_cast<std::size_t>(kMaxAngles)) {
      throw std::invalid_argument(
          fmt::format("the robot has more than {} joints that turn; closed forms of so many would "
                      "fill no book: lock some (`lock` in the robot's file)",
                      kMaxAngles));
    }
  }

  static bool is_whole(double number) {
    return std::abs(number) <= 16.0 && number == std::round(number);
  }

  Wave wave_of(const Body& body) const {
    Wave wave{};
    for (std::size_t i = 0; i < tree_.symbols.angles.size(); ++i) {
      const Angle& angle = tree_.symbols.angles[i];
      if (angle.dof == body.dof && is_whole(body.ratio / angle.ratio)) {
        wave[i] = static_cast<std::int8_t>(body.ratio / angle.ratio);
        break;
      }
    }
    return wave;
  }

  Polynomial constant(Kind kind, int body, const std::string& name, const std::string& latex,
                      double value, const char* unit, const std::string& meaning) {
    if (value == 0.0) return {};
    if (!letters_) return Polynomial(static_cast<long double>(value));
    tree_.symbols.letters.push_back({name, latex, kind, body, value, unit, meaning, -1});
    return letter(tree_.symbols.letters.size() - 1);
  }

  Polynomial letter(std::size_t number) {
    return {tree_.symbols.monomials.letter(static_cast<int>(number)), 1.0L};
  }

  Polynomial coordinate(int dof) {
    auto& letters = tree_.symbols.letters;
    const auto found = std::find_if(letters.begin(), letters.end(),
                                    [&](const Letter& known) { return known.dof == dof; });
    if (found != letters.end()) return letter(static_cast<std::size_t>(found - letters.begin()));
    const Coordinate& q = tree_.symbols.coordinates[static_cast<std::size_t>(dof)];
    letters.push_back({q.name, q.latex, Kind::kCoordinate, 0, 0.0, "", "", dof});
    return letter(letters.size() - 1);
  }

  // A vector as letters: one, if it has one coordinate ("lc1"), else one a coordinate ("lcx1").
  Vector vector(const LongVector3& value, Kind kind, int body, const Three& name, const char* unit,
                const std::string& meaning) {
    static constexpr std::array<const char*, 3> kAxis{"x", "y", "z"};
    const auto count = (value.array() != 0.0L).count();
    Vector result;
    for (std::size_t i = 0; i < 3; ++i) {
      const std::string axis = count == 1 ? "" : kAxis[i];
      result[i] = constant(
          kind, body, fmt::format("{}{}{}", name[0], axis, name[1]),
          fmt::format("{}_{{{}{}{}}}", name[0].substr(0, 1), name[0].substr(1), axis, name[2]),
          static_cast<double>(value[static_cast<Eigen::Index>(i)]), unit,
          fmt::format("{}{}{}", meaning, meaning.ends_with("against") ? " " : ", along ",
                      kAxis[i]));
    }
    return result;
  }

  // One letter, g > 0, where gravity is along an axis.
  Vector gravity() {
    const Eigen::Vector3d& pull = mechanism_.gravity();
    if ((pull.array() != 0.0).count() == 1 && pull.sum() < 0.0) {
      Vector up = vector(-pull.cast<long double>(), Kind::kGravity, 0, {"g", "", ""}, "m/s²",
                         "gravity in the world, against");
      for (Polynomial& part : up) part *= -1.0L;
      return up;
    }
    return vector(pull.cast<long double>(), Kind::kGravity, 0, {"g", "", ""}, "m/s²",
                  "gravity in the world");
  }

  Polynomial rotor(int dof) {
    const Coordinate& q = tree_.symbols.coordinates[static_cast<std::size_t>(dof)];
    const std::string number = std::to_string(dof + 1);
    return constant(Kind::kRotor, dof + 1, fmt::format("Ir{}", number),
                    fmt::format("I_{{r{}}}", number), mechanism_.rotor_inertia()[dof],
                    q.rotation ? "kg·m²" : "kg", fmt::format("rotor of {}", q.joint));
  }

  // Rotation from the axes of the link that the joint carries, in which letters are meant.
  struct Home {
    std::string link = "the world";
    LongMatrix3 body_from_link = LongMatrix3::Identity();
  };
  Home home(int body) const {
    const auto& links = mechanism_.links();
    const auto found = std::find_if(links.begin(), links.end(),
                                    [&](const auto& link) { return link.body == body; });
    if (body == control::kWorld || found == links.end()) return {};
    return {found->name, exact_rotation(found->body_from_link.rotation)};
  }

  void add_masses(const Body& source, int number, SymbolicBody& body) {
    const control::RigidInertia& inertia = source.inertia;
    if (!letters_ || inertia.mass <= 0.0) {
      body.mass = Polynomial(static_cast<long double>(inertia.mass));
      for (std::size_t i = 0; i < 3; ++i) {
        const auto row = static_cast<Eigen::Index>(i);
        body.first_moment[i] = Polynomial(static_cast<long double>(inertia.first_moment[row]));
        for (std::size_t j = 0; j < 3; ++j) {
          body.inertia[i][j] = Polynomial(
              static_cast<long double>(inertia.rotational(row, static_cast<Eigen::Index>(j))));
        }
      }
      return;
    }
    const Home at = home(number - 1);
    const std::string index = std::to_string(number);
    body.mass =
        constant(Kind::kMass, number, fmt::format("m{}", index), fmt::format("m_{{{}}}", index),
                 inertia.mass, "kg", fmt::format("mass of {} and what is fixed to it", at.link));
    const Eigen::Vector3d centre = inertia.first_moment / inertia.mass;
    LongVector3 centre_in_link = at.body_from_link.transpose() * centre.cast<long double>();
    const Vector arm = vector(centre_in_link, Kind::kLength, number, {"lc", index, index}, "m",
                              fmt::format("centre of mass of {}", at.link));
    const Vector centre_in_body = turned(at.body_from_link, arm);
    for (std::size_t i = 0; i < 3; ++i) body.first_moment[i] = times(body.mass, centre_in_body[i]);
    // About the centre of mass, then carried to the origin by the parallel-axis theorem.
    const Eigen::Matrix3d own =
        inertia.rotational - control::shifted(centre, (0.5 * inertia.mass) * centre);
    body.inertia = turned(at.body_from_link, moments(own, at, number));
    for (std::size_t i = 0; i < 3; ++i) {
      for (std::size_t j = 0; j < 3; ++j) {
        for (std::size_t k = 0; k < 3 && i == j; ++k) {
          body.inertia[i][i] += times(body.first_moment[k], centre_in_body[k]);
        }
        body.inertia[i][j] -= times(body.first_moment[i], centre_in_body[j]);
      }
    }
  }

  Matrix moments(const Eigen::Matrix3d& about_centre, const Home& at, int number) {
    LongMatrix3 own =
        at.body_from_link.transpose() * about_centre.cast<long double>() * at.body_from_link;
    const long double bound = kRounding * own.cwiseAbs().maxCoeff();
    Matrix result;
    for (std::size_t i = 0; i < 3; ++i) {
      for (std::size_t j = i; j < 3; ++j) {
        long double value = own(static_cast<Eigen::Index>(i), static_cast<Eigen::Index>(j));
        if (std::abs(value) < bound) value = 0.0L;
        const std::string axes{"xyz"[i], "xyz"[j]};
        result[i][j] = result[j][i] =
            constant(Kind::kInertia, number, fmt::format("I{}{}", axes, number),
                     fmt::format("I_{{{}{}}}", axes, number), static_cast<double>(value), "kg·m²",
                     fmt::format("{} of inertia of {} about its centre of mass, axes {}",
                                 i == j ? "moment" : "product", at.link, axes));
      }
    }
    return result;
  }

  void add(int index) {
    const Body& source = mechanism_.bodies()[static_cast<std::size_t>(index)];
    SymbolicBody body;
    body.parent = source.parent;
    body.dof = source.dof;
    body.ratio = source.ratio;
    body.rotation = source.motion == control::Motion::kRotation;
    body.wave = wave_of(source);
    body.parent_rotation = exact_rotation(source.parent_from_joint.rotation);

    const Home at = home(source.parent);
    const auto& bodies = mechanism_.bodies();
    const auto siblings = std::count_if(bodies.begin(), bodies.end(), [&](const Body& other) {
      return other.parent == source.parent;
    });
    const int from = source.parent + 1;
    const std::string plain =
        siblings > 1 ? fmt::format("{}_{}", from, index + 1) : std::to_string(from);
    const std::string latex =
        siblings > 1 ? fmt::format("{},{}", from, index + 1) : std::to_string(from);
    const Eigen::Vector3d& translation = source.parent_from_joint.translation;
    body.parent_translation = turned(
        at.body_from_link,
        vector(at.body_from_link.transpose() * translation.cast<long double>(), Kind::kLength, from,
               {"l", plain, latex}, "m",
               fmt::format("from the origin of {} to that of {}", at.link, home(index).link)));
    if (body.rotation) {
      turn_by_offset(source.offset, body.parent_rotation);
    } else {
      body.shift =
          body.ratio * coordinate(source.dof) + Polynomial(static_cast<long double>(source.offset));
    }
    add_masses(source, index + 1, body);
    tree_.bodies.push_back(std::move(body));
  }

  // A mimic joint's offset, as part of where its frame is at position 0.
  static void turn_by_offset(double offset, LongMatrix3& rotation) {
    if (offset == 0.0) return;
    const double s = std::sin(offset);
    const double c = std::cos(offset);
    Eigen::Matrix3d about_z;
    about_z << c, -s, 0.0, s, c, 0.0, 0.0, 0.0, 1.0;
    rotation = (rotation * exact_rotation(about_z)).eval();
  }

  Polynomial times(const Polynomial& a, const Polynomial& b) {
    return multiply(tree_.symbols.monomials, a, b);
  }

  const Mechanism& mechanism_;
  bool letters_;
  SymbolicTree tree_;
};

}  // namespace

SymbolicTree symbolic_tree(const Mechanism& mechanism, bool letters) {
  return Builder(mechanism, letters).take();
}

}  // namespace geodesic::tools::derive
