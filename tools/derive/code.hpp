// C and MATLAB/Octave functions of a derivation: M_metric(q) and Cgrav_forces(q, v). Documents for
// people are in sheet.hpp.
#pragma once

#include <string>
#include <vector>

#include "tools/derive/closed_form.hpp"
#include "tools/derive/sheet.hpp"

namespace geodesic::tools::derive {

struct CodeFile {
  std::string name;
  std::string text;
};

/// One file of C99 with M_metric and Cgrav_forces. Needs the Christoffel symbols, as does the next.
CodeFile c_code(const ClosedForm& form, const Origin& origin);

/// M_metric.m and Cgrav_forces.m.
std::vector<CodeFile> matlab_code(const ClosedForm& form, const Origin& origin);

}  // namespace geodesic::tools::derive
