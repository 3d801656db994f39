// SPDX-License-Identifier: MIT
#include "mmlins/imu/propagation.hpp"

#include <Eigen/Eigenvalues>
#include <algorithm>
#include <cmath>

#include "mmlins/base/check.hpp"

namespace mmlins::imu {

ImuStep step_between(const sensor::ImuSample& a, const sensor::ImuSample& b) {
  return {to_seconds(b.time - a.time), 0.5 * (a.gyro + b.gyro), 0.5 * (a.accel + b.accel)};
}

NavState integrate(const NavState& state, const ImuStep& step) {
  const double dt = step.dt;
  const Vector3d turn = (step.gyro - state.gyro_bias) * dt;
  const Matrix3d R_mid = state.R_odom_imu * math::so3_exp(0.5 * turn);
  const Vector3d accel_odom = R_mid * (step.accel - state.accel_bias) + state.gravity_odom;
  NavState next = state;
  next.p_odom += state.v_odom * dt + 0.5 * dt * dt * accel_odom;
  next.v_odom += accel_odom * dt;
  next.R_odom_imu = state.R_odom_imu * math::so3_exp(turn);
  next.time += from_seconds(dt);
  return next;
}

ErrorMatrix transition(const NavState& state, const ImuStep& step) {
  const double dt = step.dt;
  const Vector3d turn = (step.gyro - state.gyro_bias) * dt;
  const Vector3d force = step.accel - state.accel_bias;
  const Matrix3d half = math::so3_exp(0.5 * turn);
  const Matrix3d R_mid = state.R_odom_imu * half;
  const Matrix3d dv_dtheta = -R_mid * math::skew(force) * half.transpose() * dt;
  const Matrix3d dv_dgyro_bias = R_mid * math::skew(force) * math::so3_right_jacobian(0.5 * turn) * (0.5 * dt * dt);
  const Matrix3d dv_daccel_bias = -R_mid * dt;
  const math::Matrix32d dv_dgravity = math::sphere_plus_jacobian(state.gravity_odom) * dt;

  ErrorMatrix F = ErrorMatrix::Identity();
  F.block<3, 3>(kRotation, kRotation) = math::so3_exp(-turn);
  F.block<3, 3>(kRotation, kGyroBias) = -math::so3_right_jacobian(turn) * dt;
  F.block<3, 3>(kVelocity, kRotation) = dv_dtheta;
  F.block<3, 3>(kVelocity, kGyroBias) = dv_dgyro_bias;
  F.block<3, 3>(kVelocity, kAccelBias) = dv_daccel_bias;
  F.block<3, 2>(kVelocity, kGravityDirection) = dv_dgravity;
  F.block<3, 3>(kPosition, kVelocity) = Matrix3d::Identity() * dt;
  F.block<3, 3>(kPosition, kRotation) = 0.5 * dt * dv_dtheta;
  F.block<3, 3>(kPosition, kGyroBias) = 0.5 * dt * dv_dgyro_bias;
  F.block<3, 3>(kPosition, kAccelBias) = 0.5 * dt * dv_daccel_bias;
  F.block<3, 2>(kPosition, kGravityDirection) = 0.5 * dt * dv_dgravity;
  return F;
}

ErrorMatrix step_noise(const ImuStep& step, const ImuNoise& noise) {
  const double dt = step.dt;
  const Matrix3d I = Matrix3d::Identity();
  const double accel2 = noise.accel * noise.accel;
  ErrorMatrix Q = ErrorMatrix::Zero();
  Q.block<3, 3>(kRotation, kRotation) = noise.gyro * noise.gyro * dt * I;
  // White acceleration noise is the same in every frame, so it needs no rotation.
  Q.block<3, 3>(kVelocity, kVelocity) = accel2 * dt * I;
  Q.block<3, 3>(kPosition, kVelocity) = 0.5 * accel2 * dt * dt * I;
  Q.block<3, 3>(kVelocity, kPosition) = 0.5 * accel2 * dt * dt * I;
  Q.block<3, 3>(kPosition, kPosition) = accel2 * dt * dt * dt / 3.0 * I;
  Q.block<3, 3>(kGyroBias, kGyroBias) = noise.gyro_bias_walk * noise.gyro_bias_walk * dt * I;
  Q.block<3, 3>(kAccelBias, kAccelBias) = noise.accel_bias_walk * noise.accel_bias_walk * dt * I;
  return Q;
}

ErrorMatrix doubt_after_gap(double seconds) {
  const double gap = std::min(seconds, kLongestStep);
  ErrorVector sigma = ErrorVector::Zero();
  sigma.segment<3>(kRotation).setConstant(0.3 * gap);
  sigma.segment<3>(kVelocity).setConstant(3.0 * gap);
  sigma.segment<3>(kPosition).setConstant(1.5 * gap * gap);
  return sigma.cwiseAbs2().asDiagonal();
}

Propagation propagate(const Estimate& start, const sensor::ImuSamples& samples, const ImuNoise& noise) {
  MMLINS_CHECK(!samples.empty() && samples.front().time == start.state.time);
  Propagation result{start, {{start.state.time, start.state.T_odom_imu()}}};
  Estimate& now = result.estimate;
  for (std::size_t i = 1; i < samples.size(); ++i) {
    const ImuStep step = step_between(samples[i - 1], samples[i]);
    if (step.dt > kLongestStep) {
      now.P += doubt_after_gap(step.dt);
    } else {
      const ErrorMatrix F = transition(now.state, step);
      now.P = F * now.P * F.transpose() + step_noise(step, noise);
      now.state = integrate(now.state, step);
    }
    now.state.time = samples[i].time;
    result.T_odom_imu.push_back({now.state.time, now.state.T_odom_imu()});
  }
  return result;
}

math::Matrix6d pose_covariance(const Estimate& estimate) {
  math::Matrix6d to_body = math::Matrix6d::Identity();
  to_body.bottomRightCorner<3, 3>() = estimate.state.R_odom_imu.transpose();
  return to_body * estimate.P.topLeftCorner<6, 6>() * to_body.transpose();
}

double tilt_deviation(const Estimate& estimate) {
  const Matrix3d Rt = estimate.state.R_odom_imu.transpose();
  const Vector3d down = (Rt * estimate.state.gravity_odom).normalized();
  Eigen::Matrix<double, 3, kErrorSize> A = Eigen::Matrix<double, 3, kErrorSize>::Zero();
  A.block<3, 3>(0, kRotation) = -Matrix3d::Identity();
  A.block<3, 2>(0, kGravityDirection) = Rt * math::sphere_basis(estimate.state.gravity_odom);
  A = ((Matrix3d::Identity() - down * down.transpose()) * A).eval();
  const Matrix3d P = A * estimate.P * A.transpose();
  return std::sqrt(std::max(0.0, Eigen::SelfAdjointEigenSolver<Matrix3d>(P, Eigen::EigenvaluesOnly).eigenvalues()(2)));
}

}  // namespace mmlins::imu
