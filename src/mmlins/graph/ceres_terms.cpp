// SPDX-License-Identifier: MIT
#include "mmlins/graph/ceres_terms.hpp"

#include <Eigen/Geometry>

namespace mmlins::graph {
namespace {

using RowMajor67 = Eigen::Matrix<double, 6, 7, Eigen::RowMajor>;
using RowMajor76 = Eigen::Matrix<double, 7, 6, Eigen::RowMajor>;
using RowMajor72 = Eigen::Matrix<double, 7, 2, Eigen::RowMajor>;
using RowMajor27 = Eigen::Matrix<double, 2, 7, Eigen::RowMajor>;
using RowMajor37 = Eigen::Matrix<double, 3, 7, Eigen::RowMajor>;

Eigen::Map<const Eigen::Quaterniond> rotation_of(const double* block) {
  return Eigen::Map<const Eigen::Quaterniond>(block);
}
Eigen::Map<const Vector3d> position_of(const double* block) { return Eigen::Map<const Vector3d>(block + 4); }

void store(const Eigen::Quaterniond& q, const Vector3d& position, double* block) {
  Eigen::Map<Eigen::Matrix<double, 7, 1>> out(block);
  out << q.normalized().coeffs(), position;
}

}  // namespace

PoseBlock to_block(const SE3& T) {
  PoseBlock block{};
  store(T.quaternion(), T.t, block.data());
  return block;
}

SE3 from_block(const double* block) { return {rotation_of(block).toRotationMatrix(), position_of(block)}; }

bool PoseManifold::Plus(const double* x, const double* delta, double* x_plus_delta) const {
  const Eigen::Quaterniond q = rotation_of(x);
  const Vector3d position = position_of(x) + q * Vector3d(delta[3], delta[4], delta[5]);
  store(q * math::so3_exp_quaternion({delta[0], delta[1], delta[2]}), position, x_plus_delta);
  return true;
}

bool PoseManifold::PlusJacobian(const double* /*x*/, double* jacobian) const {
  Eigen::Map<RowMajor76>(jacobian).setIdentity();
  return true;
}

bool PoseManifold::Minus(const double* y, const double* x, double* y_minus_x) const {
  const Eigen::Quaterniond q = rotation_of(x);
  Eigen::Map<Vector6d> step(y_minus_x);
  step << math::so3_log(q.conjugate() * rotation_of(y)), q.conjugate() * (position_of(y) - position_of(x));
  return true;
}

bool PoseManifold::MinusJacobian(const double* /*x*/, double* jacobian) const {
  Eigen::Map<RowMajor67>(jacobian).setIdentity();
  return true;
}

bool TiltManifold::Plus(const double* x, const double* delta, double* x_plus_delta) const {
  store(math::so3_exp_quaternion({delta[0], delta[1], 0.0}) * rotation_of(x), position_of(x), x_plus_delta);
  return true;
}

bool TiltManifold::PlusJacobian(const double* x, double* jacobian) const {
  Eigen::Map<RowMajor72> J(jacobian);
  J.setZero();
  J.topRows<3>() = rotation_of(x).conjugate().toRotationMatrix().leftCols<2>();
  return true;
}

bool TiltManifold::Minus(const double* y, const double* x, double* y_minus_x) const {
  const Vector3d turn = math::so3_log(rotation_of(y) * rotation_of(x).conjugate());
  y_minus_x[0] = turn.x();
  y_minus_x[1] = turn.y();
  return true;
}

bool TiltManifold::MinusJacobian(const double* x, double* jacobian) const {
  Eigen::Map<RowMajor27> J(jacobian);
  J.setZero();
  J.leftCols<3>() = rotation_of(x).toRotationMatrix().topRows<2>();
  return true;
}

bool EdgeCost::Evaluate(const double* const* blocks, double* residuals, double** jacobians) const {
  Eigen::Map<Vector6d> r(residuals);
  if (jacobians == nullptr) {
    r = S_ * edge_error(from_block(blocks[0]), from_block(blocks[1]), T_from_to_);
    return true;
  }
  const EdgeError error = linearize_edge(from_block(blocks[0]), from_block(blocks[1]), T_from_to_);
  r = S_ * error.e;
  const std::array<const Matrix6d*, 2> J{&error.J_from, &error.J_to};
  for (std::size_t i = 0; i < 2; ++i) {
    if (jacobians[i] == nullptr) continue;
    Eigen::Map<RowMajor67> out(jacobians[i]);
    out.leftCols<6>() = S_ * *J[i];
    out.col(6).setZero();
  }
  return true;
}

bool GravityCost::Evaluate(const double* const* blocks, double* residuals, double** jacobians) const {
  const GravityError error = linearize_gravity(from_block(blocks[0]).R, up_node_);
  Eigen::Map<Vector3d> r(residuals);
  r = error.e / sigma_;
  if (jacobians != nullptr && jacobians[0] != nullptr) {
    Eigen::Map<RowMajor37> out(jacobians[0]);
    out.setZero();
    out.leftCols<3>() = error.J_rotation / sigma_;
  }
  return true;
}

}  // namespace mmlins::graph
