// Derives metric, potential, Christoffel symbols and gravity; see the header.
#include "tools/derive/closed_form.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <numeric>

#include "tools/derive/expressions.hpp"
#include "tools/derive/inverse_metric.hpp"
#include "tools/derive/metric_of_tree.hpp"

namespace geodesic::tools::derive {
namespace {

using Table = std::vector<std::vector<Polynomial>>;

// Derivatives of the metric: [i][j][k] = dM_ij / dq_k, i <= j.
class Differentiation {
 public:
  Differentiation(ClosedForm& form, const Wanted& wanted, const OnProgress& on_progress)
      : form_(form), wanted_(wanted), on_progress_(on_progress), expressions_(form.symbols) {}

  void gravity() {
    const GiNaC::ex potential = expressions_.expression(form_.potential);
    for (int i = 0; i < form_.n; ++i) {
      form_.gravity.push_back(expressions_.polynomial(expressions_.derivative(potential, i)));
    }
  }

  void christoffel() {
    const std::size_t expected = expected_terms();
    if (wanted_.limit > 0 && expected > wanted_.limit) {
      throw TooLong(fmt::format(
          "the Christoffel symbols of this robot will have about {} terms of sines and cosines; M "
          "and g alone have {} (--what M,g)",
          expected, count_terms(form_)));
    }
    differentiate(expected);
    const auto n = static_cast<std::size_t>(form_.n);
    form_.christoffel.assign(n, std::vector(n, std::vector<Polynomial>(n)));
    std::size_t terms = count_terms(form_);
    for (std::size_t i = 0; i < n; ++i) {
      report(0.5 + 0.5 * static_cast<double>(i) / static_cast<double>(n), terms, expected);
      for (std::size_t j = 0; j < n; ++j) {
        for (std::size_t k = j; k < n; ++k) {
          const Polynomial symbol = 0.5L * (rate(i, j, k) + rate(i, k, j) - rate(j, k, i));
          terms += symbol.terms().size() * (j == k ? 1 : 2);
          form_.christoffel[i][j][k] = form_.christoffel[i][k][j] = symbol;
        }
      }
    }
  }

 private:
  // What arms of 3 to 7 joints were found to have. At most it is three derivatives of every entry;
  // but they share terms, and few entries depend on every angle.
  std::size_t expected_terms() const {
    std::size_t sum = 0;
    const auto n = static_cast<std::size_t>(form_.n);
    for (const auto& row : form_.metric) {
      for (const Polynomial& entry : row) sum += entry.terms().size();
    }
    return count_terms(form_) + sum * n * 6 / 5;
  }

  void differentiate(std::size_t expected) {
    const auto n = static_cast<std::size_t>(form_.n);
    rates_.assign(n, std::vector(n, std::vector<Polynomial>(n)));
    std::size_t done = 0;
    for (std::size_t i = 0; i < n; ++i) {
      for (std::size_t j = i; j < n; ++j) {
        report(static_cast<double>(done++) / static_cast<double>(n * (n + 1)), 0, expected);
        const GiNaC::ex entry = expressions_.expression(form_.metric[i][j]);
        for (std::size_t k = 0; k < n; ++k) {
          rates_[i][j][k] =
              expressions_.polynomial(expressions_.derivative(entry, static_cast<int>(k)));
        }
      }
    }
  }

  const Polynomial& rate(std::size_t i, std::size_t j, std::size_t k) const {
    return rates_[std::min(i, j)][std::max(i, j)][k];
  }

  void report(double part, std::size_t terms, std::size_t expected) const {
    if (on_progress_) on_progress_({"Christoffel symbols", part, terms, expected});
  }

  ClosedForm& form_;
  const Wanted& wanted_;
  const OnProgress& on_progress_;
  Expressions expressions_;
  std::vector<Table> rates_;
};

}  // namespace

std::size_t count_terms(const ClosedForm& form) {
  std::size_t sum = form.potential.terms().size();
  const auto count = [&](const std::vector<Polynomial>& list) {
    for (const Polynomial& entry : list) sum += entry.terms().size();
  };
  count(form.gravity);
  for (const auto& row : form.metric) count(row);
  for (const auto& matrix : form.christoffel) {
    for (const auto& row : matrix) count(row);
  }
  for (const auto& matrix : form.second_kind) {
    for (const auto& row : matrix) count(row);
  }
  return sum;
}

ClosedForm derive(SymbolicTree tree, const Wanted& wanted, const OnProgress& on_progress) {
  ClosedForm form;
  form.n = static_cast<int>(tree.symbols.coordinates.size());
  MetricOfTree energies = metric_of_tree(tree, wanted.limit, on_progress);
  form.symbols = std::move(tree.symbols);
  form.metric = std::move(energies.metric);
  form.potential = std::move(energies.potential);
  Differentiation differentiation(form, wanted, on_progress);
  differentiation.gravity();
  if (wanted.christoffel || wanted.second_kind) differentiation.christoffel();
  if (wanted.second_kind) add_second_kind(form, wanted.limit, on_progress);
  return form;
}

}  // namespace geodesic::tools::derive
