// SPDX-License-Identifier: MIT
#include "mmlins/math/so3.hpp"

#include <Eigen/SVD>
#include <cmath>

namespace mmlins::math {
namespace {
// Below this angle [rad] the closed forms lose digits and their series are exact to machine precision.
constexpr double kSmallAngle = 1e-5;
}  // namespace

Matrix3d skew(const Vector3d& a) {
  Matrix3d S;
  S << 0.0, -a.z(), a.y(), a.z(), 0.0, -a.x(), -a.y(), a.x(), 0.0;
  return S;
}

Matrix3d so3_exp(const Vector3d& w) { return so3_exp_quaternion(w).toRotationMatrix(); }

Eigen::Quaterniond so3_exp_quaternion(const Vector3d& w) {
  const double angle = w.norm();
  const double half = 0.5 * angle;
  const double sinc_half = angle < kSmallAngle ? 0.5 - angle * angle / 48.0 : std::sin(half) / angle;
  Eigen::Quaterniond q;
  q.w() = std::cos(half);
  q.vec() = sinc_half * w;
  return q;
}

Vector3d so3_log(const Matrix3d& R) { return so3_log(Eigen::Quaterniond(R)); }

Vector3d so3_log(const Eigen::Quaterniond& q) {
  const double sign = q.w() < 0.0 ? -1.0 : 1.0;
  const double sin_half = q.vec().norm();
  const double cos_half = sign * q.w();
  const double scale = sin_half < 1e-7 ? 2.0 / cos_half : 2.0 * std::atan2(sin_half, cos_half) / sin_half;
  return sign * scale * q.vec();
}

Matrix3d so3_right_jacobian(const Vector3d& w) {
  const double angle2 = w.squaredNorm();
  const Matrix3d W = skew(w);
  if (angle2 < kSmallAngle * kSmallAngle) return Matrix3d::Identity() - 0.5 * W + W * W / 6.0;
  const double angle = std::sqrt(angle2);
  // 1 - cos(angle) without its cancellation.
  const double sinc_half = std::sin(0.5 * angle) / (0.5 * angle);
  return Matrix3d::Identity() - 0.5 * sinc_half * sinc_half * W +
         (angle - std::sin(angle)) / (angle2 * angle) * W * W;
}

Matrix3d so3_right_jacobian_inverse(const Vector3d& w) {
  const double angle2 = w.squaredNorm();
  const Matrix3d W = skew(w);
  if (angle2 < kSmallAngle * kSmallAngle) return Matrix3d::Identity() + 0.5 * W + W * W / 12.0;
  const double angle = std::sqrt(angle2);
  const double half = 0.5 * angle;
  const double factor = (1.0 - half * std::cos(half) / std::sin(half)) / angle2;
  return Matrix3d::Identity() + 0.5 * W + factor * W * W;
}

Matrix3d nearest_rotation(const Matrix3d& M) {
  const Eigen::JacobiSVD<Matrix3d> svd(M, Eigen::ComputeFullU | Eigen::ComputeFullV);
  Matrix3d D = Matrix3d::Identity();
  D(2, 2) = (svd.matrixU() * svd.matrixV().transpose()).determinant() < 0.0 ? -1.0 : 1.0;
  return svd.matrixU() * D * svd.matrixV().transpose();
}

}  // namespace mmlins::math
