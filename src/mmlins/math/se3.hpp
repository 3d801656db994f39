// SPDX-License-Identifier: MIT
#pragma once
// Rigid transforms. `T_a_b` maps coordinates from frame b to frame a: p_a = T_a_b * p_b.
// Tangent vectors are [rotation; translation].

#include <Eigen/Core>
#include <Eigen/Geometry>

#include "mmlins/math/so3.hpp"

namespace mmlins::math {

using Vector6d = Eigen::Matrix<double, 6, 1>;
using Matrix6d = Eigen::Matrix<double, 6, 6>;

/// A rotation and a translation [m].
struct SE3 {
  Matrix3d R = Matrix3d::Identity();
  Vector3d t = Vector3d::Zero();

  [[nodiscard]] SE3 inverse() const { return {R.transpose(), -(R.transpose() * t)}; }
  [[nodiscard]] Eigen::Quaterniond quaternion() const { return Eigen::Quaterniond(R).normalized(); }
};

[[nodiscard]] inline SE3 operator*(const SE3& T_a_b, const SE3& T_b_c) {
  return {T_a_b.R * T_b_c.R, T_a_b.R * T_b_c.t + T_a_b.t};
}
[[nodiscard]] inline Vector3d operator*(const SE3& T_a_b, const Vector3d& p_b) { return T_a_b.R * p_b + T_a_b.t; }

/// Group exponential of [rotation; translation]. docs/math/lie_groups.md, Eq. (5).
[[nodiscard]] SE3 se3_exp(const Vector6d& x);
/// Group logarithm; inverse of se3_exp for rotations below pi.
[[nodiscard]] Vector6d se3_log(const SE3& T);

/// The adjoint of T: T Exp(x) = Exp(Ad x) T.
[[nodiscard]] Matrix6d adjoint(const SE3& T);

/// The pose at fraction `s` in [0, 1] between two poses: rotation along the geodesic, translation linear.
[[nodiscard]] SE3 interpolate(const SE3& T_a_from, const SE3& T_a_to, double s);

}  // namespace mmlins::math
