// SPDX-License-Identifier: MIT
#include "mmlins/degeneracy/disagreement.hpp"

#include <Eigen/Cholesky>
#include <Eigen/Eigenvalues>

namespace mmlins::degeneracy {

double innovation_chi2(const math::Vector6d& shift, const math::Matrix6d& P_prior, const math::Matrix6d& H) {
  // At the fused estimate both pull equally: P^-1 shift = H (scan - estimate).
  const math::Vector6d pull = P_prior.ldlt().solve(shift);
  const Eigen::SelfAdjointEigenSolver<math::Matrix6d> scan(H);
  const double floor = 1e-12 * std::max(scan.eigenvalues()(5), 0.0);
  double chi2 = shift.dot(pull);
  for (int i = 0; i < 6; ++i) {
    if (scan.eigenvalues()(i) <= floor) continue;  // the scan says nothing in this direction
    const double along = scan.eigenvectors().col(i).dot(pull);
    chi2 += along * along / scan.eigenvalues()(i);
  }
  return chi2;
}

}  // namespace mmlins::degeneracy
