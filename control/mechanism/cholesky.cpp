// Implements cholesky.hpp.
#include "control/mechanism/cholesky.hpp"

#include <algorithm>
#include <set>

#include "control/mechanism/mechanism.hpp"

namespace geodesic::control {
namespace {

/// Lower degrees of freedom that meet i in an entry of M, for every i.
std::vector<std::set<int>> metric_pattern(const Mechanism& mechanism) {
  const auto& bodies = mechanism.bodies();
  std::vector<std::set<int>> pattern(static_cast<std::size_t>(mechanism.dof()));
  std::vector<std::set<int>> support(bodies.size());  // degrees of freedom that move a body
  for (std::size_t b = 0; b < bodies.size(); ++b) {
    if (bodies[b].parent != kWorld) {
      support[b] = support[static_cast<std::size_t>(bodies[b].parent)];
    }
    for (int k = 0; k < freedoms(bodies[b].motion); ++k) {
      support[b].insert(bodies[b].dof + k);
    }
    for (const int i : support[b]) {
      pattern[static_cast<std::size_t>(i)].insert(support[b].begin(), support[b].find(i));
    }
  }
  return pattern;
}

/// y -= a x over a run of ancestors. The inner loop; runs are short, unrolling it costs more than
/// it saves.
inline void subtract(double* __restrict y, const double* __restrict x, double a, int begin,
                     int end) noexcept {
  for (int j = begin; j < end; ++j) {
    y[j] -= a * x[j];
  }
}

inline double product(const double* x, const double* y, int begin, int end) noexcept {
  double sum = 0.0;
  for (int j = begin; j < end; ++j) {
    sum += x[j] * y[j];
  }
  return sum;
}

}  // namespace

TreeCholesky::TreeCholesky(const Mechanism& mechanism)
    : size_(mechanism.dof()), parent_(static_cast<std::size_t>(size_), -1) {
  // Symbolic elimination, last first: the neighbours of i become neighbours of one another, and the
  // nearest of them hands the rest on.
  std::vector<std::set<int>> pattern = metric_pattern(mechanism);
  for (auto i = static_cast<std::size_t>(size_); i-- > 0;) {
    if (pattern[i].empty()) {
      continue;
    }
    parent_[i] = *pattern[i].rbegin();
    pattern[i].erase(parent_[i]);
    pattern[static_cast<std::size_t>(parent_[i])].insert(pattern[i].begin(), pattern[i].end());
  }
  for (int i = 0; i < size_; ++i) {
    first_run_.push_back(runs_.size());
    std::set<int> ancestors;
    for (int j = parent(i); j >= 0; j = parent(j)) {
      ancestors.insert(j);
    }
    for (const int j : ancestors) {
      if (runs_.size() > first_run_.back() && runs_.back().end == j) {
        ++runs_.back().end;
      } else {
        runs_.push_back({j, j + 1});
      }
    }
  }
  first_run_.push_back(runs_.size());
  l_.setZero(size_, size_);
  l_inverse_.setZero(size_, size_);
  d_inverse_.setZero(size_);
  scaled_.setZero(size_);
}

bool TreeCholesky::factor(const Eigen::MatrixXd& metric) noexcept {
  // A pivot this small against its diagonal entry is what rounding leaves of zero.
  constexpr double kSingular = 1e-14;
  const Eigen::Index stride = size_;
  double* const l = l_.data();
  for (int i = 0; i < size_; ++i) {
    const double* from = metric.data() + i * stride;
    double* to = l + i * stride;
    for_runs(i, [&](int begin, int end) { std::copy(from + begin, from + end, to + begin); });
    to[i] = from[i];
  }
  for (int k = size_; k-- > 0;) {
    double* const row = l + k * stride;  // row k of L
    if (!(row[k] > kSingular * metric.data()[k * stride + k])) {
      return false;
    }
    const double d_inverse = 1.0 / row[k];
    d_inverse_.data()[k] = d_inverse;
    // Every ancestor i loses what k explains of it, at its own ancestors (k's below i) and at i.
    for_ancestors(k, [&](int i, const Run* runs, const Run* own) {
      const double a = row[i] * d_inverse;
      double* const above = l + i * stride;
      for (const Run* run = runs; run != own; ++run) {
        subtract(above, row, a, run->begin, run->end);
      }
      subtract(above, row, a, own->begin, i + 1);
    });
    for_runs(k, [&](int begin, int end) {
      for (int i = begin; i < end; ++i) {
        row[i] *= d_inverse;
      }
    });
  }
  return true;
}

void TreeCholesky::solve(Eigen::Ref<Eigen::VectorXd> x) const noexcept {
  const Eigen::Index stride = size_;
  double* const y = x.data();
  for (int i = size_; i-- > 0;) {
    const double* row = l_.data() + i * stride;
    for_runs(i, [&](int begin, int end) { subtract(y, row, y[i], begin, end); });
  }
  for (int i = 0; i < size_; ++i) {
    const double* row = l_.data() + i * stride;
    double value = y[i] * d_inverse_.data()[i];
    for_runs(i, [&](int begin, int end) { value -= product(row, y, begin, end); });
    y[i] = value;
  }
}

void TreeCholesky::inverse(Eigen::MatrixXd& result) noexcept {
  const Eigen::Index stride = size_;
  // Row i of L^-1 from the rows above: sum over ancestors k of -L_ik (row k of L^-1).
  for (int i = 0; i < size_; ++i) {
    const double* row = l_.data() + i * stride;
    double* out = l_inverse_.data() + i * stride;
    for_runs(i, [&](int begin, int end) {
      for (int j = begin; j < end; ++j) {
        out[j] = -row[j];
      }
    });
    for_ancestors(i, [&](int k, const Run* runs, const Run* own) {
      const double* above = l_inverse_.data() + k * stride;
      for (const Run* run = runs; run != own; ++run) {
        subtract(out, above, row[k], run->begin, run->end);
      }
      subtract(out, above, row[k], own->begin, k);
    });
  }
  // M^-1 = L^-1 D^-1 L^-T: entry (i, j) gathers the common ancestors k, themselves included.
  double* const scaled = scaled_.data();
  for (int i = 0; i < size_; ++i) {
    double* const column = result.data() + i * stride;
    const double* row = l_inverse_.data() + i * stride;
    for (int j = 0; j < i; ++j) {
      scaled[j] = row[j] * d_inverse_.data()[j];
    }
    for (int j = 0; j < i; ++j) {
      const double* other = l_inverse_.data() + j * stride;
      double sum = scaled[j];
      for_runs(j, [&](int begin, int end) { sum += product(scaled, other, begin, end); });
      column[j] = sum;
      result.data()[j * stride + i] = sum;
    }
    double sum = d_inverse_.data()[i];
    for_runs(i, [&](int begin, int end) { sum += product(scaled, row, begin, end); });
    column[i] = sum;
  }
}

}  // namespace geodesic::control
