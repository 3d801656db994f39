// SPDX-License-Identifier: MIT
#include "mmlins/imu/nav_state.hpp"

#include <cmath>

namespace mmlins::imu {
namespace {

// Derivative of sphere_minus(sphere_plus(g, d), base) at d = 0. The direction is recovered from
// u = base x g / (|base||g|), scaled by angle / sine; both factors are differentiated.
Eigen::Matrix2d gravity_minus_jacobian(const Vector3d& gravity, const Vector3d& base) {
  const Vector3d b = base.normalized();
  const Vector3d g = gravity.normalized();
  const Vector3d axis = b.cross(g);
  const double sine = axis.norm();
  const double cosine = b.dot(g);
  const math::Matrix32d dg = math::sphere_plus_jacobian(g);
  const math::Matrix32d daxis = math::skew(b) * dg;
  const math::Matrix32d B = math::sphere_basis(base);
  if (sine < 1e-6) return B.transpose() * daxis;
  const double angle = std::atan2(sine, cosine);
  const Eigen::RowVector2d dsine = axis.transpose() / sine * daxis;
  const Eigen::RowVector2d dcosine = b.transpose() * dg;
  const Eigen::RowVector2d dangle = cosine * dsine - sine * dcosine;
  const Eigen::RowVector2d dscale = dangle / sine - angle / (sine * sine) * dsine;
  return B.transpose() * (daxis * (angle / sine) + axis * dscale);
}

}  // namespace

NavState plus(const NavState& state, const ErrorVector& error) {
  NavState result = state;
  result.R_odom_imu = state.R_odom_imu * math::so3_exp(error.segment<3>(kRotation));
  result.p_odom += error.segment<3>(kPosition);
  result.v_odom += error.segment<3>(kVelocity);
  result.gyro_bias += error.segment<3>(kGyroBias);
  result.accel_bias += error.segment<3>(kAccelBias);
  result.gravity_odom = math::sphere_plus(state.gravity_odom, error.segment<2>(kGravityDirection));
  return result;
}

ErrorVector minus(const NavState& state, const NavState& base) {
  ErrorVector error;
  error.segment<3>(kRotation) = math::so3_log(Matrix3d(base.R_odom_imu.transpose() * state.R_odom_imu));
  error.segment<3>(kPosition) = state.p_odom - base.p_odom;
  error.segment<3>(kVelocity) = state.v_odom - base.v_odom;
  error.segment<3>(kGyroBias) = state.gyro_bias - base.gyro_bias;
  error.segment<3>(kAccelBias) = state.accel_bias - base.accel_bias;
  error.segment<2>(kGravityDirection) = math::sphere_minus(state.gravity_odom, base.gravity_odom);
  return error;
}

ErrorMatrix minus_jacobian(const NavState& state, const NavState& base) {
  ErrorMatrix L = ErrorMatrix::Identity();
  const Vector3d rotation = math::so3_log(Matrix3d(base.R_odom_imu.transpose() * state.R_odom_imu));
  L.block<3, 3>(kRotation, kRotation) = math::so3_right_jacobian_inverse(rotation);
  L.block<2, 2>(kGravityDirection, kGravityDirection) = gravity_minus_jacobian(state.gravity_odom, base.gravity_odom);
  return L;
}

}  // namespace mmlins::imu
