// The letters and angles that closed forms are written in, with their values and meanings. Data
// only; which letters a robot needs is symbolic_tree.cpp's matter.
#pragma once

#include <Eigen/Core>
#include <string>
#include <vector>

#include "tools/derive/polynomial.hpp"

namespace geodesic::tools::derive {

struct Letter {
  enum class Kind : std::uint8_t { kMass, kInertia, kRotor, kLength, kGravity, kCoordinate };
  std::string name;   ///< as in text and code: "lc2"
  std::string latex;  ///< "l_{c2}"
  Kind kind = Kind::kMass;
  int body = 0;        ///< counts from 1; 0: the world
  double value = 0.0;  ///< of the robot; not of coordinates
  std::string unit;
  std::string meaning;
  int dof = -1;  ///< of coordinates
};

/// An angle that sines and cosines are taken of: ratio * q[dof].
struct Angle {
  int dof = 0;
  double ratio = 1.0;
};

/// One degree of freedom.
struct Coordinate {
  std::string joint;
  std::string kind;  ///< "revolute", "prismatic", ...
  bool rotation = true;
  std::string name;   ///< "q2", as in text
  std::string latex;  ///< "q_{2}"
};

struct Symbols {
  std::vector<Letter> letters;
  std::vector<Angle> angles;
  std::vector<Coordinate> coordinates;
  MonomialTable monomials;
};

/// The value at q [dof], for comparison with numbers.
double evaluate(const Symbols& symbols, const Polynomial& polynomial, const Eigen::VectorXd& q);

}  // namespace geodesic::tools::derive
