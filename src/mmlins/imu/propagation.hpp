// SPDX-License-Identifier: MIT
#pragma once
// Motion between scans: strapdown integration of the IMU and of the covariance. docs/math/eskf.md, section 2.

#include <vector>

#include "mmlins/imu/nav_state.hpp"
#include "mmlins/math/trajectory.hpp"
#include "mmlins/sensor/imu_sample.hpp"

namespace mmlins::imu {

/// Continuous noise densities.
struct ImuNoise {
  double gyro = 0.0;             ///< [rad/s/sqrt(Hz)]
  double accel = 0.0;            ///< [m/s^2/sqrt(Hz)]
  double gyro_bias_walk = 0.0;   ///< [rad/s^2/sqrt(Hz)]
  double accel_bias_walk = 0.0;  ///< [m/s^3/sqrt(Hz)]
};

struct Estimate {
  NavState state;
  ErrorMatrix P = ErrorMatrix::Identity();  ///< covariance of the error of `state`
};

/// Covariance of the pose alone, of the error e in T_odom_imu Exp(e), [rotation; translation].
[[nodiscard]] math::Matrix6d pose_covariance(const Estimate& estimate);

/// Largest standard deviation of the direction of gravity as the IMU sees it: that of attitude and of gravity in odom
/// together. docs/math/initialization.md, Eq. (15) [rad].
[[nodiscard]] double tilt_deviation(const Estimate& estimate);

/// One integration step: mean rate and specific force over `dt` seconds.
struct ImuStep {
  double dt = 0.0;
  Vector3d gyro = Vector3d::Zero();
  Vector3d accel = Vector3d::Zero();
};

/// The step from one sample to the next, with the mean of their readings.
[[nodiscard]] ImuStep step_between(const sensor::ImuSample& a, const sensor::ImuSample& b);

/// The state after one step, by the midpoint rule. Eqs. (4)-(6).
[[nodiscard]] NavState integrate(const NavState& state, const ImuStep& step);
/// Derivative of the error after the step with respect to the error before it. Eq. (7).
[[nodiscard]] ErrorMatrix transition(const NavState& state, const ImuStep& step);
/// Covariance that the step's noise adds. Eq. (8).
[[nodiscard]] ErrorMatrix step_noise(const ImuStep& step, const ImuNoise& noise);

/// Estimate at the last sample, and the poses on the way, one per sample.
struct Propagation {
  Estimate estimate;
  math::Trajectory T_odom_imu;
};

/// A longer step [s] is a clock that was set forward or a recording that paused, not a motion to integrate.
inline constexpr double kLongestStep = 1.0;

/// Covariance of what may have happened while the IMU was silent for that long: turns of 0.3 rad/s and
/// accelerations of 3 m/s^2 that nobody measured. Pauses beyond kLongestStep count as one of that length.
[[nodiscard]] ErrorMatrix doubt_after_gap(double seconds);

/// Integrates from `start` through `samples`, of which the first must be at start.state.time. Across steps
/// longer than kLongestStep the motion is taken to go on afterwards as it was before, with much doubt.
[[nodiscard]] Propagation propagate(const Estimate& start, const sensor::ImuSamples& samples, const ImuNoise& noise);

}  // namespace mmlins::imu
