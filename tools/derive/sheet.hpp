// What a derivation has to say, in order: headings, tables, formulas. One model of the document
// for text, LaTeX and JSON.
#pragma once

#include <Eigen/Core>
#include <nlohmann/json_fwd.hpp>
#include <string>
#include <vector>

#include "tools/derive/closed_form.hpp"
#include "tools/derive/layout.hpp"

namespace geodesic::tools::derive {

/// What was derived from what.
struct Origin {
  std::string robot;
  Eigen::Vector3d gravity = Eigen::Vector3d::Zero();
  bool rotors = false;             ///< rotor inertias are in the metric
  std::vector<std::string> notes;  ///< figures taken as exact ones
};

/// What is written down of it.
struct Content {
  bool metric = true;
  bool christoffel = true;
  bool second_kind = false;
  bool gravity = true;
  bool equations = true;  ///< needs the first three
};

/// For people. @param digits  of numbers
std::string text_document(ClosedForm& form, const Origin& origin, const Content& content,
                          int digits);

/// An article that LaTeX with amsmath compiles.
std::string latex_document(ClosedForm& form, const Origin& origin, const Content& content,
                           int digits);

/// robot, gravity, coordinates[], symbols{}, M[][], christoffel_first_kind[], g[], equations[],
/// notes[]: formulas as strings that C, Octave and Maxima read, but for ^ in C.
nlohmann::ordered_json json_document(ClosedForm& form, const Origin& origin,
                                     const Content& content);

/// The letters that occur, masses of a body together; not the coordinates.
std::vector<Letter> constants(const ClosedForm& form);

/// Where a body's only moment of inertia that counts is about its joint's axis, its letter becomes
/// that of textbooks: Izz1 -> I1.
void use_textbook_letters(ClosedForm& form);

}  // namespace geodesic::tools::derive
