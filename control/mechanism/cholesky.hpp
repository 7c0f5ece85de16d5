// Sparse factorisation of the metric along the mechanism's tree, its solve and its inverse, without
// fill-in and without allocation.
#pragma once

#include <Eigen/Core>
#include <vector>

namespace geodesic::control {

class Mechanism;

/// M = L' D L with L unit lower triangular. M_ij is zero unless one body is moved by both i and j;
/// eliminating the last degree of freedom first then fills nothing in, and row i of L is nonzero
/// only at ancestors of i: O(n depth^2) instead of O(n^3).
/// Source: Featherstone 2008, section 6.5. The tree of degrees of freedom is the
/// elimination tree of M's pattern (Liu 1990, "The role of elimination trees in sparse
/// factorization"): the mechanism's own tree unless mimic joints tie branches together, which adds
/// ancestors where M has entries.
class TreeCholesky {
 public:
  /// Not real-time: allocates.
  explicit TreeCholesky(const Mechanism& mechanism);

  /// Factors M [n x n], of which only the upper triangle is read.
  /// @return false if M is not positive definite to working precision (a pivot below 1e-14 of its
  ///   diagonal entry); solve() and inverse() must not be called then. Real-time.
  bool factor(const Eigen::MatrixXd& metric) noexcept;

  /// Replaces x [n] by M^-1 x. Real-time, O(n depth).
  void solve(Eigen::Ref<Eigen::VectorXd> x) const noexcept;

  /// M^-1 [n x n], full and symmetric to the bit: L^-1 has the pattern of L, so entry (i, j) sums
  /// over common ancestors only. Real-time, O(n^2 depth).
  void inverse(Eigen::MatrixXd& result) noexcept;

  /// The next degree of freedom towards the world, -1 at the root of its tree.
  int parent(int i) const noexcept { return parent_[static_cast<std::size_t>(i)]; }

 private:
  /// Ancestors of a degree of freedom with consecutive numbers: [begin, end).
  struct Run {
    int begin;
    int end;
  };

  /// Calls f(begin, end) for the runs of ancestors of i, ascending.
  template <class F>
  void for_runs(int i, F f) const noexcept {
    const Run* run = runs_.data() + first_run_[static_cast<std::size_t>(i)];
    const Run* const last = runs_.data() + first_run_[static_cast<std::size_t>(i) + 1];
    for (; run != last; ++run) {
      f(run->begin, run->end);
    }
  }

  /// Calls f(j, runs, own) for every ancestor j of i, ascending: j's own ancestors are the runs of
  /// i from `runs` to before `own`, and of `own` what is below j.
  template <class F>
  void for_ancestors(int i, F f) const noexcept {
    const Run* const runs = runs_.data() + first_run_[static_cast<std::size_t>(i)];
    const Run* const last = runs_.data() + first_run_[static_cast<std::size_t>(i) + 1];
    for (const Run* own = runs; own != last; ++own) {
      for (int j = own->begin; j < own->end; ++j) {
        f(j, runs, own);
      }
    }
  }

  int size_ = 0;
  std::vector<int> parent_;
  std::vector<Run> runs_;               ///< of all degrees of freedom, one after the other
  std::vector<std::size_t> first_run_;  ///< of each, and the end
  /// Column i holds row i of L above the diagonal: what is read together lies together.
  Eigen::MatrixXd l_;
  Eigen::MatrixXd l_inverse_;  ///< in the same arrangement
  Eigen::VectorXd d_inverse_;
  Eigen::VectorXd scaled_;
};

}  // namespace geodesic::control
