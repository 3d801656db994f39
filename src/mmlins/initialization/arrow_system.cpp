// SPDX-License-Identifier: MIT
#include "mmlins/initialization/arrow_system.hpp"

#include <Eigen/Cholesky>
#include <Eigen/Eigenvalues>

namespace mmlins::initialization {
namespace {

// Relative to its own scales, a last block that is worse conditioned is singular in the digits of a double.
constexpr double kSmallestEigenvalue = 1e-13;

/// What elimination of one node leaves for the way back: x = b - next x_next - border x_shared.
struct Eliminated {
  NodeMatrix next;
  BorderMatrix border;
  NodeVector b;
};

/// Inverse of a positive definite matrix whose numbers differ by many orders of magnitude; empty if it is
/// not.
Eigen::MatrixXd inverse_of(const Eigen::MatrixXd& H) {
  if (!(H.diagonal().minCoeff() > 0.0) || !H.allFinite()) return {};
  const Eigen::VectorXd scale = H.diagonal().cwiseSqrt().cwiseInverse();
  const Eigen::MatrixXd scaled = scale.asDiagonal() * H * scale.asDiagonal();
  const Eigen::SelfAdjointEigenSolver<Eigen::MatrixXd> eigen(scaled);
  if (eigen.info() != Eigen::Success || !(eigen.eigenvalues()(0) > kSmallestEigenvalue)) return {};
  const Eigen::MatrixXd V = scale.asDiagonal() * eigen.eigenvectors();
  return V * eigen.eigenvalues().cwiseInverse().asDiagonal() * V.transpose();
}

}  // namespace

ArrowSystem::ArrowSystem(std::size_t num_nodes, int num_shared)
    : diagonal(num_nodes, NodeMatrix::Zero()),
      next(num_nodes - 1, NodeMatrix::Zero()),
      border(num_nodes, BorderMatrix::Zero(kNodeSize, num_shared)),
      b(num_nodes, NodeVector::Zero()),
      shared(SharedMatrix::Zero(num_shared, num_shared)),
      b_shared(SharedVector::Zero(num_shared)) {}

ArrowSolution solve(ArrowSystem s) {
  ArrowSolution result;
  const std::size_t last = s.diagonal.size() - 1;
  const Eigen::Index m = s.shared.rows();
  std::vector<Eliminated> eliminated;
  for (std::size_t k = 0; k < last; ++k) {
    const Eigen::LLT<NodeMatrix> llt(s.diagonal[k]);
    if (llt.info() != Eigen::Success) return result;
    eliminated.push_back({llt.solve(s.next[k]), llt.solve(s.border[k]), llt.solve(s.b[k])});
    const Eliminated& x = eliminated.back();
    s.diagonal[k + 1].noalias() -= s.next[k].transpose() * x.next;
    s.border[k + 1].noalias() -= s.next[k].transpose() * x.border;
    s.b[k + 1].noalias() -= s.next[k].transpose() * x.b;
    s.shared.noalias() -= s.border[k].transpose() * x.border;
    s.b_shared.noalias() -= s.border[k].transpose() * x.b;
  }
  Eigen::MatrixXd H(kNodeSize + m, kNodeSize + m);
  H << s.diagonal[last], s.border[last], s.border[last].transpose(), s.shared;
  result.last_covariance = inverse_of(0.5 * (H + H.transpose()));
  if (result.last_covariance.size() == 0) return result;
  Eigen::VectorXd right(kNodeSize + m);
  right << s.b[last], s.b_shared;
  const Eigen::VectorXd x = result.last_covariance * right;
  result.shared = x.tail(m);
  result.nodes.resize(last + 1);
  result.nodes[last] = x.head<kNodeSize>();
  for (std::size_t k = last; k-- > 0;) {
    result.nodes[k] =
        eliminated[k].b - eliminated[k].next * result.nodes[k + 1] - eliminated[k].border * result.shared;
  }
  result.ok = x.allFinite();
  return result;
}

ArrowSystem with_shared(const ArrowSystem& system, const Eigen::MatrixXd& T) {
  ArrowSystem result = system;
  for (BorderMatrix& border : result.border) border = (border * T).eval();
  result.shared = (T.transpose() * system.shared * T).eval();
  result.b_shared = T.transpose() * system.b_shared;
  return result;
}

}  // namespace mmlins::initialization
