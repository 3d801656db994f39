// SPDX-License-Identifier: MIT
#pragma once
// What the IMU says about the motion between two times, whatever the state at the first of them was:
// rotation, velocity and position without gravity. docs/math/initialization.md, section 1.

#include "mmlins/imu/propagation.hpp"

namespace mmlins::imu {

struct ImuBias {
  Vector3d gyro = Vector3d::Zero();   ///< [rad/s]
  Vector3d accel = Vector3d::Zero();  ///< [m/s^2]
};

struct TimeSpan {
  Time begin;
  Time end;
};

/// Rotation, position and velocity that the readings alone give, in the IMU frame at `begin`.
struct ImuDelta {
  Matrix3d R = Matrix3d::Identity();  ///< maps the IMU frame at the end to that at the beginning
  Vector3d p = Vector3d::Zero();      ///< double integral of the specific force [m]
  Vector3d v = Vector3d::Zero();      ///< its integral [m/s]
};

/// Errors are ordered [rotation, position, velocity], as the first nine of the state's error: kRotation,
/// kPosition, kVelocity. Rotation is perturbed on the right.
struct Preintegration {
  static constexpr int kSize = 9;

  TimeSpan span;
  ImuBias bias;  ///< at which the readings were integrated
  ImuDelta delta;
  Eigen::Matrix<double, kSize, kSize> covariance = Eigen::Matrix<double, kSize, kSize>::Zero();
  /// Derivative of the delta with respect to [gyro bias, accel bias].
  Eigen::Matrix<double, kSize, 6> bias_jacobian = Eigen::Matrix<double, kSize, 6>::Zero();
  double longest_step = 0.0;  ///< longest time without a sample that falls into the span at least in part [s]

  [[nodiscard]] double seconds() const { return to_seconds(span.end - span.begin); }
};

/// Integrates the readings from the beginning of `span` to its end, both interpolated between samples; where
/// the samples do not reach, the nearest one is held. Eqs. (1)-(4). Steps longer than kLongestStep add the
/// doubt of doubt_after_gap.
/// @param samples  in order of time, not empty
/// @pre span.begin <= span.end
[[nodiscard]] Preintegration preintegrate(const sensor::ImuSamples& samples, const TimeSpan& span,
                                          const ImuBias& bias, const ImuNoise& noise);

/// The delta for another bias, to first order in the difference. Eq. (5).
[[nodiscard]] ImuDelta corrected(const Preintegration& motion, const ImuBias& bias);

}  // namespace mmlins::imu
