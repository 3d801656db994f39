// SPDX-License-Identifier: MIT
#include "mmlins/initialization/window.hpp"

#include <Eigen/Eigenvalues>
#include <Eigen/LU>

namespace mmlins::initialization {
namespace {

// Deviation of a pose that is so by choice [rad], [m].
constexpr double kByChoice = 1e-5;
// A direction that is known less well than this [rad], [m] is not worth moving the pose along.
constexpr double kSeen = 0.5;

}  // namespace

PoseMeasurement pose_with_covariance(Time time, const math::SE3& T_odom_imu,
                                     const math::Matrix6d& covariance) {
  return {time, T_odom_imu, covariance.inverse()};
}

PoseMeasurement defining_pose(Time time, const math::SE3& T_odom_imu) {
  return {time, T_odom_imu, math::Matrix6d::Identity() / (kByChoice * kByChoice)};
}

PoseMeasurement pose_from_matching(Time time, const math::SE3& T_odom_imu, const math::Matrix6d& H,
                                   const math::Vector6d& b) {
  const Eigen::SelfAdjointEigenSolver<math::Matrix6d> eigen(H);
  math::Vector6d step = math::Vector6d::Zero();
  for (int i = 0; i < 6; ++i) {
    const double seen = eigen.eigenvalues()(i);
    if (seen < 1.0 / (kSeen * kSeen)) continue;
    step -= eigen.eigenvectors().col(i) * (eigen.eigenvectors().col(i).dot(b) / seen);
  }
  const math::SE3 moved{T_odom_imu.R * math::so3_exp(step.head<3>()), T_odom_imu.t + step.tail<3>()};
  return {time, moved, H};
}

}  // namespace mmlins::initialization
