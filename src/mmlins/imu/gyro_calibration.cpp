// SPDX-License-Identifier: MIT
#include "mmlins/imu/gyro_calibration.hpp"

#include <Eigen/LU>
#include <numbers>

namespace mmlins::imu {
namespace {

using math::Matrix3d;
using math::Vector3d;

/// Time between the attitudes that are compared: long enough for a turn to show, short enough for the bias to stay [s].
constexpr double kWindow = 0.5;
/// What an attitude found by matching may be off, beyond what the filter says: planes that are none, deskewing [rad].
constexpr double kAttitudeDeviation = 0.1 * std::numbers::pi / 180.0;
/// 99.9 % of three squared normal errors stay below; what lies beyond is no calibration.
constexpr double kMaxChi2 = 16.27;

/// How the rotation over the window depends on the errors: e = J [M; b], e being that of the gyroscope at its end.
struct Window {
  Matrix3d R_begin_end = Matrix3d::Identity();
  Eigen::Matrix<double, 3, 12> J = Eigen::Matrix<double, 3, 12>::Zero();
};

Window integrate_window(const sensor::ImuSamples& samples, const Vector3d& bias) {
  Window window;
  for (std::size_t i = 1; i < samples.size(); ++i) {
    const double dt = to_seconds(samples[i].time - samples[i - 1].time);
    const Vector3d rate = 0.5 * (samples[i].gyro + samples[i - 1].gyro) - bias;
    const Matrix3d R_step = math::so3_exp((rate * dt).eval());
    window.J = (R_step.transpose() * window.J).eval();
    for (int axis = 0; axis < 3; ++axis) window.J.block<3, 3>(0, 3 * axis) += rate(axis) * dt * Matrix3d::Identity();
    window.J.rightCols<3>() += dt * Matrix3d::Identity();
    window.R_begin_end = window.R_begin_end * R_step;
  }
  return window;
}

}  // namespace

GyroCalibration::GyroCalibration(const GyroCalibrationConfig& config) : config_(config) {
  P_.setZero();
  P_.diagonal().head<9>().setConstant(config.scale_deviation * config.scale_deviation);
  P_.diagonal().tail<3>().setConstant(config.turn_on_bias * config.turn_on_bias);
}

sensor::ImuSample GyroCalibration::apply(sensor::ImuSample sample) const {
  sample.gyro -= proportional_error() * sample.gyro;
  return sample;
}

void GyroCalibration::add(Time time, const Matrix3d& R_odom_imu, const sensor::ImuBuffer& imu) {
  if (!last_) {
    last_ = {time, R_odom_imu};
    return;
  }
  const double seconds = to_seconds(time - last_->time);
  if (seconds < kWindow) return;
  const Window window = integrate_window(imu.covering(last_->time, time), x_.tail<3>());
  const Matrix3d R_begin_end = last_->R_odom_imu.transpose() * R_odom_imu;
  last_ = {time, R_odom_imu};
  P_.diagonal().tail<3>().array() += config_.bias_walk * config_.bias_walk * seconds;
  const Vector3d error = math::so3_log((R_begin_end.transpose() * window.R_begin_end).eval());
  const double variance = 2.0 * kAttitudeDeviation * kAttitudeDeviation + config_.noise * config_.noise * seconds;
  const Matrix3d S = window.J * P_ * window.J.transpose() + variance * Matrix3d::Identity();
  const Matrix3d S_inverse = S.inverse();
  if (error.dot(S_inverse * error) > kMaxChi2) return;
  const Eigen::Matrix<double, kSize, 3> K = P_ * window.J.transpose() * S_inverse;
  x_ += K * error;
  P_ = (P_ - K * S * K.transpose()).eval();
  P_ = (0.5 * (P_ + P_.transpose())).eval();
}

Matrix3d GyroCalibration::proportional_error() const { return Eigen::Map<const Matrix3d>(x_.data()); }

Matrix3d GyroCalibration::deviation() const {
  const Eigen::Matrix<double, 9, 1> deviation = P_.diagonal().head<9>().cwiseSqrt();
  return Eigen::Map<const Matrix3d>(deviation.data());
}

std::optional<Time> GyroCalibration::needs_imu_since() const {
  return last_ ? std::optional<Time>(last_->time) : std::nullopt;
}

}  // namespace mmlins::imu
