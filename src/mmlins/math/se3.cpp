// SPDX-License-Identifier: MIT
#include "mmlins/math/se3.hpp"

namespace mmlins::math {

// The left Jacobian of SO(3) carries the translation; it is the right Jacobian of the negated argument.
SE3 se3_exp(const Vector6d& x) {
  const Vector3d w = x.head<3>();
  return {so3_exp(w), so3_right_jacobian(-w) * x.tail<3>()};
}

Vector6d se3_log(const SE3& T) {
  Vector6d x;
  x.head<3>() = so3_log(T.R);
  x.tail<3>() = so3_right_jacobian_inverse(-x.head<3>()) * T.t;
  return x;
}

Matrix6d adjoint(const SE3& T) {
  Matrix6d Ad;
  Ad << T.R, Matrix3d::Zero(), skew(T.t) * T.R, T.R;
  return Ad;
}

SE3 interpolate(const SE3& T_a_from, const SE3& T_a_to, double s) {
  const Vector3d w = so3_log(Matrix3d(T_a_from.R.transpose() * T_a_to.R));
  return {T_a_from.R * so3_exp(s * w), T_a_from.t + s * (T_a_to.t - T_a_from.t)};
}

}  // namespace mmlins::math
