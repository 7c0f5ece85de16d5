// The inverse of the metric by minors; see the header.
#include "tools/derive/inverse_metric.hpp"

#include <fmt/format.h>

#include <map>

namespace geodesic::tools::derive {
namespace {

constexpr std::size_t kMostJoints = 5;

class Minors {
 public:
  Minors(ClosedForm& form, std::size_t limit, const OnProgress& on_progress)
      : form_(form), limit_(limit), on_progress_(on_progress) {}

  // Determinant of the rows and columns whose bits are set, by expansion along the first row.
  Polynomial minor(unsigned rows, unsigned columns) {
    if (rows == 0) return Polynomial(1.0L);
    const auto known = known_.find({rows, columns});
    if (known != known_.end()) return known->second;
    const auto row = static_cast<std::size_t>(__builtin_ctz(rows));
    Polynomial sum;
    long double sign = 1.0L;
    for (unsigned rest = columns; rest != 0; rest &= rest - 1) {
      const auto column = static_cast<std::size_t>(__builtin_ctz(rest));
      const Polynomial& entry = form_.metric[row][column];
      if (!entry.is_zero()) {
        sum += sign * times(entry, minor(rows & (rows - 1), columns & ~(1U << column)));
      }
      sign = -sign;
    }
    return known_[{rows, columns}] = sum;
  }

  Polynomial times(const Polynomial& a, const Polynomial& b) {
    work_ += a.terms().size() * b.terms().size();
    if (limit_ > 0 && work_ > 1000 * limit_) {
      throw TooLong(
          fmt::format("the inverse of this metric takes more than {} products of terms", work_));
    }
    if (on_progress_) on_progress_({"second kind", 0.0, known_.size(), 0});
    return multiply(form_.symbols.monomials, a, b);
  }

 private:
  ClosedForm& form_;
  std::size_t limit_;
  const OnProgress& on_progress_;
  std::size_t work_ = 0;
  std::map<std::pair<unsigned, unsigned>, Polynomial> known_;
};

}  // namespace

void add_second_kind(ClosedForm& form, std::size_t limit, const OnProgress& on_progress) {
  const auto n = static_cast<std::size_t>(form.n);
  if (n > kMostJoints && limit > 0) {
    throw TooLong(
        fmt::format("symbols of the second kind need the inverse of the metric in closed "
                    "form, which for {} joints is a quotient of sums too long to read",
                    n));
  }
  Minors minors(form, limit, on_progress);
  const unsigned all = (1U << n) - 1;
  form.determinant = minors.minor(all, all);
  form.second_kind.assign(n, std::vector(n, std::vector<Polynomial>(n)));
  for (std::size_t i = 0; i < n; ++i) {
    for (std::size_t l = 0; l < n; ++l) {
      Polynomial adjugate = minors.minor(all & ~(1U << l), all & ~(1U << i));
      if ((i + l) % 2 == 1) adjugate *= -1.0L;
      for (std::size_t j = 0; j < n; ++j) {
        for (std::size_t k = j; k < n; ++k) {
          form.second_kind[i][j][k] += minors.times(adjugate, form.christoffel[l][j][k]);
          form.second_kind[i][k][j] = form.second_kind[i][j][k];
        }
      }
    }
  }
}

}  // namespace geodesic::tools::derive
