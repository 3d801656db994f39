// SPDX-License-Identifier: MIT
#pragma once
// What is known at the first pose of the window before looking at it: one struct for a state that the IMU
// carried over a gap, for nothing at all, and for rest. docs/math/initialization.md, section 4.

#include "mmlins/initialization/initialization_config.hpp"
#include "mmlins/initialization/window.hpp"

namespace mmlins::initialization {

/// The error of the state without its first six numbers: velocity, biases, gravity direction.
inline constexpr int kPriorSize = imu::kErrorSize - imu::kVelocity;
using PriorMatrix = Eigen::Matrix<double, kPriorSize, kPriorSize>;

struct StatePrior {
  /// Velocity, biases and gravity; its pose is not used: poses are measurements.
  imu::NavState state;
  /// Inverse covariance of the error of `state`; zero where nothing is known.
  PriorMatrix information = PriorMatrix::Zero();

  [[nodiscard]] bool knows_gravity() const { return information.bottomRightCorner<2, 2>().trace() > 0.0; }
};

/// Carried over: the filter's estimate, propagated by the IMU to the time of the first pose. Eq. (16).
/// @param estimate  as the filter has it, in whatever frame: it is placed where the first pose is, and what
/// it doubts
///                  of its own attitude becomes doubt about velocity and gravity
/// @param first     the first pose of the window, in the frame of the poses
[[nodiscard]] StatePrior carried_over_prior(const imu::Estimate& estimate, const math::SE3& first);

/// Standard deviations of the biases of an IMU of which nothing is known yet but its make.
struct BiasDeviation {
  double gyro = 0.01;   ///< [rad/s]
  double accel = 0.1;   ///< [m/s^2]
};

/// Cold start in motion: biases are nil to within their deviations, nothing else is known. Eq. (17).
[[nodiscard]] StatePrior cold_prior(Time time, const BiasDeviation& biases);

/// Stand-still: no velocity, the mean angular rate is the gyro's bias, the mean force is minus gravity plus
/// the accelerometer's bias. Eq. (18).
/// @param pose     the first pose of the window
/// @param samples  of the time at rest, not empty
[[nodiscard]] StatePrior rest_prior(const PoseMeasurement& pose, const sensor::ImuSamples& samples,
                                    const PriorConfig& config, const BiasDeviation& biases);

}  // namespace mmlins::initialization
