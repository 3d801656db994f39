// SPDX-License-Identifier: MIT
#include "mmlins/graph/residuals.hpp"

#include <Eigen/Eigenvalues>
#include <cmath>

namespace mmlins::graph {
namespace {

using math::Matrix3d;

/// Rotation and translation have different units and magnitudes: eigenvalues are only comparable after
/// every axis is scaled by its own information.
Vector6d axis_scales(const Matrix6d& information) {
  return information.diagonal().unaryExpr([](double d) { return d > 0.0 ? std::sqrt(d) : 1.0; });
}

Eigen::SelfAdjointEigenSolver<Matrix6d> scaled_eigen(const Matrix6d& information, const Vector6d& scales) {
  const Vector6d inverse = scales.cwiseInverse();
  const Matrix6d scaled = inverse.asDiagonal() * information * inverse.asDiagonal();
  return Eigen::SelfAdjointEigenSolver<Matrix6d>(0.5 * (scaled + scaled.transpose()));
}

}  // namespace

SE3 retract(const SE3& T, const Vector6d& step) {
  return {T.R * math::so3_exp(step.head<3>()), T.t + T.R * step.tail<3>()};
}

Vector6d edge_error(const SE3& T_world_from, const SE3& T_world_to, const SE3& T_from_to) {
  const SE3 T_error = T_from_to.inverse() * (T_world_from.inverse() * T_world_to);
  Vector6d e;
  e << math::so3_log(T_error.R), T_error.t;
  return e;
}

EdgeError linearize_edge(const SE3& T_world_from, const SE3& T_world_to, const SE3& T_from_to) {
  const Matrix3d R_to_from_measured = T_from_to.R.transpose();
  const Matrix3d R_from_to = T_world_from.R.transpose() * T_world_to.R;
  const Vector3d p_from = T_world_from.R.transpose() * (T_world_to.t - T_world_from.t);
  const Matrix3d R_error = R_to_from_measured * R_from_to;
  EdgeError result;
  result.e << math::so3_log(R_error), R_to_from_measured * (p_from - T_from_to.t);

  const Matrix3d Jr_inverse = math::so3_right_jacobian_inverse(result.e.head<3>());
  result.J_to << Jr_inverse, Matrix3d::Zero(), Matrix3d::Zero(), R_error;
  result.J_from << -Jr_inverse * R_from_to.transpose(), Matrix3d::Zero(),
      R_to_from_measured * math::skew(p_from), -R_to_from_measured;
  return result;
}

GravityError linearize_gravity(const Matrix3d& R_world_node, const Vector3d& up_node) {
  const Vector3d up_predicted = R_world_node.transpose() * Vector3d::UnitZ();
  return {up_predicted - up_node, math::skew(up_predicted)};
}

SquareRoot square_root(const Matrix6d& information) {
  const Vector6d scales = axis_scales(information);
  const auto eigen = scaled_eigen(information, scales);
  SquareRoot root;
  for (int i = 0; i < 6; ++i) {
    const double value = eigen.eigenvalues()(i);
    if (value < kRankTolerance) continue;
    root.S.row(i) = std::sqrt(value) * (eigen.eigenvectors().col(i).cwiseProduct(scales)).transpose();
    ++root.rank;
  }
  return root;
}

bool is_information(const Matrix6d& information) {
  if (!information.allFinite()) return false;
  const Vector6d scales = axis_scales(information);
  const Vector6d inverse = scales.cwiseInverse();
  const Matrix6d scaled = inverse.asDiagonal() * information * inverse.asDiagonal();
  constexpr double kRounding = 1e-6;  // information written with six digits and read again
  if (!((scaled - scaled.transpose()).cwiseAbs().maxCoeff() < kRounding)) return false;
  return scaled_eigen(information, scales).eigenvalues()(0) > -kRounding;
}

}  // namespace mmlins::graph
