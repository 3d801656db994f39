// SPDX-License-Identifier: MIT
#pragma once
// The state of the odometry and its error: 17 numbers, [rotation, position, velocity, gyro bias,
// accel bias, gravity direction]. docs/math/eskf.md, section 1.

#include "mmlins/base/time.hpp"
#include "mmlins/math/se3.hpp"
#include "mmlins/math/sphere.hpp"

namespace mmlins::imu {

using math::Matrix3d;
using math::Vector3d;

/// Magnitude of gravity [m/s^2].
inline constexpr double kGravity = 9.81;

struct NavState {
  Time time;
  Matrix3d R_odom_imu = Matrix3d::Identity();
  Vector3d p_odom = Vector3d::Zero();                        ///< position of the IMU [m]
  Vector3d v_odom = Vector3d::Zero();                        ///< velocity of the IMU [m/s]
  Vector3d gyro_bias = Vector3d::Zero();                     ///< [rad/s]
  Vector3d accel_bias = Vector3d::Zero();                    ///< [m/s^2]
  Vector3d gravity_odom = Vector3d(0.0, 0.0, -kGravity);     ///< points down [m/s^2]

  [[nodiscard]] math::SE3 T_odom_imu() const { return {R_odom_imu, p_odom}; }
};

/// Where each part of the error begins.
inline constexpr int kRotation = 0;
inline constexpr int kPosition = 3;
inline constexpr int kVelocity = 6;
inline constexpr int kGyroBias = 9;
inline constexpr int kAccelBias = 12;
inline constexpr int kGravityDirection = 15;
inline constexpr int kErrorSize = 17;

using ErrorVector = Eigen::Matrix<double, kErrorSize, 1>;
using ErrorMatrix = Eigen::Matrix<double, kErrorSize, kErrorSize>;

/// state [+] error: rotation R Exp(e), gravity on its sphere, the rest added. docs/math/eskf.md, Eq. (1).
[[nodiscard]] NavState plus(const NavState& state, const ErrorVector& error);
/// The error with base [+] error = state. Eq. (2).
[[nodiscard]] ErrorVector minus(const NavState& state, const NavState& base);
/// Derivative of minus(plus(state, d), base) with respect to d, at d = 0. Eq. (3).
[[nodiscard]] ErrorMatrix minus_jacobian(const NavState& state, const NavState& base);

}  // namespace mmlins::imu
