// SPDX-License-Identifier: MIT
#pragma once
// Do the IMU and the LiDAR tell the same story? A bag that moves along with the sensor, or a lift, is a perfect
// static scene: it determines all six directions, and only the IMU contradicts. docs/math/degeneracy.md, section 3.

#include "mmlins/math/se3.hpp"

namespace mmlins::degeneracy {

/// Squared distance between where the IMU predicts the pose and where the scan alone puts it, in units of their
/// joint uncertainty; chi-squared with six degrees of freedom if both are right. Eq. (8).
///
/// @param shift    from the prediction to the estimate that fuses both, [rotation; translation] [rad, m]
/// @param P_prior  covariance of the prediction
/// @param H        information of the scan, in the same tangent
[[nodiscard]] double innovation_chi2(const math::Vector6d& shift, const math::Matrix6d& P_prior, const math::Matrix6d& H);

}  // namespace mmlins::degeneracy
