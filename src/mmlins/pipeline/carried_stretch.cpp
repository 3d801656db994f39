// SPDX-License-Identifier: MIT
#include "mmlins/pipeline/carried_stretch.hpp"

#include <Eigen/Cholesky>
#include <algorithm>

#include "mmlins/base/check.hpp"

namespace mmlins::pipeline {
namespace {

using math::Matrix3d;
using math::SE3;
using math::Vector3d;

/// The error: attitude (in the world), velocity, position, gyroscope's and accelerometer's bias.
constexpr int kSize = 15;
constexpr int kRotation = 0, kVelocity = 3, kPosition = 6, kGyro = 9, kAccel = 12;
using Error = Eigen::Matrix<double, kSize, 1>;
using ErrorMatrix = Eigen::Matrix<double, kSize, kSize>;

/// What a filter that has run for a while leaves unknown.
constexpr double kRotationDeviation = 1e-3;   // [rad]
constexpr double kVelocityDeviation = 0.01;   // [m/s]
constexpr double kPositionDeviation = 0.005;  // [m]
constexpr double kGyroDeviation = 3e-4;       // [rad/s]
constexpr double kAccelDeviation = 0.02;      // [m/s^2]
/// The first scan after an absence does not know its velocity well yet [m/s].
constexpr double kUnsettledVelocity = 0.04;
/// Of the gyroscope's scale, once it has been learnt.
constexpr double kScaleDeviation = 0.002;
/// Real accelerometers are noisier than their data sheets: vibration, scale, misalignment.
constexpr double kAccelNoiseFactor = 10.0;
const Vector3d kGravity(0.0, 0.0, -9.81);     // [m/s^2]

Matrix3d cross(const Vector3d& v) {
  Matrix3d m;
  m << 0.0, -v.z(), v.y(), v.z(), 0.0, -v.x(), -v.y(), v.x(), 0.0;
  return m;
}

/// How the error grows from one pose to the next, and what noise adds. Eqs. (5) and (6).
struct Step {
  ErrorMatrix F = ErrorMatrix::Identity();
  ErrorMatrix Q = ErrorMatrix::Zero();
};

Step step_between(const MovingPose& a, const MovingPose& b, const sensor::Rig& rig) {
  const double dt = std::max(to_seconds(b.time - a.time), 1e-6);
  const Vector3d force = (b.v_world - a.v_world) / dt - kGravity;
  Step step;
  step.F.block<3, 3>(kRotation, kGyro) = -dt * a.T_world_imu.R;
  step.F.block<3, 3>(kVelocity, kRotation) = -dt * cross(force);
  step.F.block<3, 3>(kVelocity, kAccel) = -dt * a.T_world_imu.R;
  step.F.block<3, 3>(kPosition, kVelocity) = dt * Matrix3d::Identity();
  step.F.block<3, 3>(kPosition, kRotation) = -0.5 * dt * dt * cross(force);
  step.F.block<3, 3>(kPosition, kAccel) = -0.5 * dt * dt * a.T_world_imu.R;
  const double turn = math::so3_log((a.T_world_imu.R.transpose() * b.T_world_imu.R).eval()).norm();
  const double accel_noise = kAccelNoiseFactor * rig.accel_noise_density;
  step.Q.diagonal().segment<3>(kRotation).setConstant(rig.gyro_noise_density * rig.gyro_noise_density * dt +
                                                      kScaleDeviation * kScaleDeviation * turn * turn);
  step.Q.diagonal().segment<3>(kVelocity).setConstant(accel_noise * accel_noise * dt);
  step.Q.diagonal().segment<3>(kPosition).setConstant(1e-8 * dt);
  step.Q.diagonal().segment<3>(kGyro).setConstant(rig.gyro_bias_walk * rig.gyro_bias_walk * dt);
  step.Q.diagonal().segment<3>(kAccel).setConstant(rig.accel_bias_walk * rig.accel_bias_walk * dt);
  return step;
}

ErrorMatrix initial_covariance() {
  Error deviation;
  deviation << Vector3d::Constant(kRotationDeviation), Vector3d::Constant(kVelocityDeviation),
      Vector3d::Constant(kPositionDeviation), Vector3d::Constant(kGyroDeviation), Vector3d::Constant(kAccelDeviation);
  return deviation.cwiseAbs2().asDiagonal();
}

}  // namespace

std::vector<SE3> smooth(std::span<const MovingPose> carried, const MovingPose& end, const sensor::Rig& rig) {
  MMLINS_CHECK(carried.size() >= 2);
  const std::size_t last = carried.size() - 1;
  std::vector<ErrorMatrix> covariances{initial_covariance()};
  std::vector<Step> steps;
  for (std::size_t k = 0; k < last; ++k) {
    steps.push_back(step_between(carried[k], carried[k + 1], rig));
    covariances.push_back(steps[k].F * covariances[k] * steps[k].F.transpose() + steps[k].Q);
  }
  // At the end attitude and position are seen as well as they were known at the beginning, the velocity less well.
  Eigen::Matrix<double, 9, 1> seen;
  seen << math::so3_log((end.T_world_imu.R * carried[last].T_world_imu.R.transpose()).eval()),
      end.v_world - carried[last].v_world, end.T_world_imu.t - carried[last].T_world_imu.t;
  Eigen::Matrix<double, 9, 9> S = covariances[last].topLeftCorner<9, 9>();
  S.diagonal() += initial_covariance().diagonal().head<9>();
  S.diagonal().segment<3>(kVelocity).array() += kUnsettledVelocity * kUnsettledVelocity;
  Error error = covariances[last].leftCols<9>() * S.ldlt().solve(seen);
  std::vector<SE3> poses(last > 0 ? last - 1 : 0);
  for (std::size_t k = last; k-- > 1;) {
    // Backwards, Eq. (7): nothing was seen on the way, so what was expected there is no error.
    error = (covariances[k] * steps[k].F.transpose() * covariances[k + 1].ldlt().solve(error)).eval();
    poses[k - 1].R = math::so3_exp(error.segment<3>(kRotation).eval()) * carried[k].T_world_imu.R;
    poses[k - 1].t = carried[k].T_world_imu.t + error.segment<3>(kPosition);
  }
  return poses;
}

}  // namespace mmlins::pipeline
