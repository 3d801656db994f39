// SPDX-License-Identifier: MIT
#include "mmlins/initialization/state_prior.hpp"

#include <Eigen/LU>

#include "mmlins/base/check.hpp"
#include "mmlins/imu/frame_change.hpp"

namespace mmlins::initialization {
namespace {

using math::Matrix3d;
using math::Vector3d;

constexpr int kGyro = imu::kGyroBias - imu::kVelocity;
constexpr int kAccel = imu::kAccelBias - imu::kVelocity;
constexpr int kGravity = imu::kGravityDirection - imu::kVelocity;

/// Inverse of a covariance whose numbers differ by many orders of magnitude.
PriorMatrix inverse_of(const PriorMatrix& P) {
  // A floor far below any sensor: a state that is exactly known would have no inverse.
  const Eigen::Matrix<double, kPriorSize, 1> sigma = P.diagonal().cwiseMax(1e-16).cwiseSqrt();
  const Eigen::Matrix<double, kPriorSize, 1> scale = sigma.cwiseInverse();
  PriorMatrix correlation = scale.asDiagonal() * P * scale.asDiagonal();
  correlation.diagonal().array() += 1e-9;
  return scale.asDiagonal() * correlation.inverse() * scale.asDiagonal();
}

}  // namespace

StatePrior carried_over_prior(const imu::Estimate& estimate, const math::SE3& first) {
  const math::SE3 T_new_old = first * estimate.state.T_odom_imu().inverse();
  const imu::Estimate placed = imu::with_pose_taken_for_granted(imu::transformed(T_new_old, estimate));
  return {placed.state, inverse_of(placed.P.bottomRightCorner<kPriorSize, kPriorSize>())};
}

StatePrior cold_prior(Time time, const BiasDeviation& biases) {
  StatePrior prior;
  prior.state.time = time;
  prior.information.diagonal().segment<3>(kGyro).setConstant(1.0 / (biases.gyro * biases.gyro));
  prior.information.diagonal().segment<3>(kAccel).setConstant(1.0 / (biases.accel * biases.accel));
  return prior;
}

StatePrior rest_prior(const PoseMeasurement& pose, const sensor::ImuSamples& samples,
                      const PriorConfig& config, const BiasDeviation& biases) {
  MMLINS_CHECK(!samples.empty());
  Vector3d rate = Vector3d::Zero();
  Vector3d force = Vector3d::Zero();
  for (const auto& sample : samples) {
    rate += sample.gyro / static_cast<double>(samples.size());
    force += sample.accel / static_cast<double>(samples.size());
  }
  const Matrix3d& R = pose.T_odom_imu.R;
  StatePrior prior = cold_prior(pose.time, biases);
  prior.state.gyro_bias = rate;
  if (force.norm() > 0.0) prior.state.gravity_odom = -imu::kGravity * (R * force).normalized();
  prior.information.diagonal().head<3>().setConstant(1.0 / (config.rest_speed * config.rest_speed));
  prior.information.diagonal().segment<3>(kGyro).setConstant(1.0 / (config.rest_gyro * config.rest_gyro));
  // The residual f - (b_a - R^T g). Its length is left in it, so that the bias takes what |f| has beyond |g|.
  Eigen::Matrix<double, 3, kPriorSize> J = Eigen::Matrix<double, 3, kPriorSize>::Zero();
  J.block<3, 3>(0, kAccel).setIdentity();
  J.block<3, 2>(0, kGravity) = -R.transpose() * math::sphere_plus_jacobian(prior.state.gravity_odom);
  const Vector3d residual = force + R.transpose() * prior.state.gravity_odom;
  const double weight = 1.0 / (config.rest_accel * config.rest_accel);
  const PriorMatrix without_force = prior.information;
  prior.information += weight * J.transpose() * J;
  // The mean of both together. The direction is as the force has it, so only the bias along it moves.
  const Vector3d bias_weight = without_force.diagonal().segment<3>(kAccel);
  prior.state.accel_bias = (weight / (weight + bias_weight(0))) * residual;
  return prior;
}

}  // namespace mmlins::initialization
