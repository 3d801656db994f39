// SPDX-License-Identifier: MIT
#include "mmlins/imu/frame_change.hpp"

namespace mmlins::imu {
namespace {

// Nothing divides by the variance of a pose that is known by definition, but it must stay positive [rad], [m].
constexpr double kDefinedByFrame = 1e-5;

/// Coordinates of small turns of gravity on its sphere.
Eigen::Matrix<double, 2, 3> sphere_coordinates(const Vector3d& gravity) {
  const math::Matrix32d B = math::sphere_plus_jacobian(gravity);
  return (B.transpose() * B).inverse() * B.transpose();
}

}  // namespace

NavState transformed(const math::SE3& T_new_odom, const NavState& state) {
  NavState result = state;
  result.R_odom_imu = T_new_odom.R * state.R_odom_imu;
  result.p_odom = T_new_odom * state.p_odom;
  result.v_odom = T_new_odom.R * state.v_odom;
  result.gravity_odom = T_new_odom.R * state.gravity_odom;
  return result;
}

Estimate transformed(const math::SE3& T_new_odom, const Estimate& estimate) {
  Estimate result{transformed(T_new_odom, estimate.state), estimate.P};
  ErrorMatrix J = ErrorMatrix::Identity();
  J.block<3, 3>(kPosition, kPosition) = T_new_odom.R;
  J.block<3, 3>(kVelocity, kVelocity) = T_new_odom.R;
  J.block<2, 2>(kGravityDirection, kGravityDirection) = sphere_coordinates(result.state.gravity_odom) * T_new_odom.R *
                                                        math::sphere_plus_jacobian(estimate.state.gravity_odom);
  result.P = J * estimate.P * J.transpose();
  return result;
}

ErrorMatrix jacobian_of_granted_pose(const NavState& state) {
  ErrorMatrix J = ErrorMatrix::Identity();
  J.block<6, kErrorSize>(0, 0).setZero();
  J.block<3, 3>(kVelocity, kRotation) = math::skew(state.v_odom) * state.R_odom_imu;
  J.block<2, 3>(kGravityDirection, kRotation) =
      sphere_coordinates(state.gravity_odom) * math::skew(state.gravity_odom) * state.R_odom_imu;
  return J;
}

Estimate with_pose_taken_for_granted(const Estimate& estimate) {
  const ErrorMatrix J = jacobian_of_granted_pose(estimate.state);
  Estimate result{estimate.state, J * estimate.P * J.transpose()};
  result.P.topLeftCorner<6, 6>() = kDefinedByFrame * kDefinedByFrame * math::Matrix6d::Identity();
  return result;
}

}  // namespace mmlins::imu
