// How the numbers of somebody's file of states stand in q and v, and the maps between that layout
// and the mechanism's own: another order of joints, a turning joint written as (cos, sin), a planar
// one as (x, y, cos, sin). Reading the file is in states_file.hpp.
#pragma once

#include <Eigen/Core>
#include <string>
#include <vector>

#include "control/mechanism/mechanism.hpp"

namespace geodesic::tools {

/// A joint as a file lists it; what the file does not say is -1.
struct FileJoint {
  std::string name;
  int idx_q = -1;
  int nq = -1;
  int idx_v = -1;
  int nv = -1;
};

class StatesLayout {
 public:
  /// The mechanism's own layout.
  explicit StatesLayout(const control::Mechanism& mechanism);

  /// The layout of a file that lists its joints, or whose first state has q of length `q_size`.
  /// @param joints  as listed; empty: the mechanism's order
  /// @param where  begins every refusal
  /// @throws BadInput if the joints are not this robot's, or no reading fits the length.
  StatesLayout(const control::Mechanism& mechanism, const std::vector<FileJoint>& joints,
               int q_size, const std::string& where);

  /// The mechanism's own: nothing need be mapped.
  bool plain() const noexcept { return plain_; }
  /// v holds the mechanism's numbers, at most in another order.
  bool reorders_only() const noexcept { return reorders_only_; }
  int nq() const noexcept { return nq_; }
  int nv() const noexcept { return nv_; }
  /// Where each of mechanism.factors() stands in the file.
  const std::vector<control::Factor>& factors() const noexcept { return theirs_; }

  /// The mechanism's q. @throws BadInput, beginning with `where`, if a (cos, sin) is not on the
  /// unit circle or a quaternion not of unit length.
  Eigen::VectorXd own_q(const Eigen::VectorXd& file_q, const std::string& where) const;

  /// T(q) with v = T v_file, nv x nv: orthogonal. A planar joint written with (cos, sin) has its
  /// velocity along the child's axes (a left-invariant field of SE(2)), the mechanism's along the
  /// parent's. @param q  the mechanism's
  Eigen::MatrixXd own_from_file(const Eigen::VectorXd& q) const;
  /// dT/dt along v. @param v  the mechanism's
  Eigen::MatrixXd own_from_file_rate(const Eigen::VectorXd& q, const Eigen::VectorXd& v) const;

 private:
  void infer_lengths(int q_size, const std::string& where);
  void settle();

  std::vector<control::Factor> own_;
  std::vector<control::Factor> theirs_;
  int nq_ = 0;
  int nv_ = 0;
  bool plain_ = true;
  bool reorders_only_ = true;
};

}  // namespace geodesic::tools
