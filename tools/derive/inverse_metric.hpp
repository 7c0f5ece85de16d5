// Christoffel symbols of the second kind: adjugate and determinant of the metric. Quotients of
// trigonometric polynomials, so numerators and the common denominator are kept apart.
#pragma once

#include "tools/derive/closed_form.hpp"

namespace geodesic::tools::derive {

/// Fills `second_kind` and `determinant` from the metric and the symbols of the first kind.
/// @throws TooLong where the products would have more than `limit` terms (0: no limit).
void add_second_kind(ClosedForm& form, std::size_t limit, const OnProgress& on_progress);

}  // namespace geodesic::tools::derive
