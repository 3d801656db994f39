// SPDX-License-Identifier: MIT
#pragma once
// Velocity and gravity from positions that the scans gave and from what the IMU felt in between: a linear
// least-squares problem, with nothing known beforehand. docs/math/eskf.md, section 5.

#include <optional>

#include "mmlins/imu/nav_state.hpp"
#include "mmlins/math/trajectory.hpp"
#include "mmlins/sensor/imu_sample.hpp"

namespace mmlins::odometry {

struct InertialAlignment {
  math::Vector3d v_odom = math::Vector3d::Zero();        ///< velocity at the first sample [m/s]
  math::Vector3d gravity_odom = math::Vector3d::Zero();  ///< of the known magnitude [m/s^2]
};

/// Fits p(t) = p0 + v t + g t^2 / 2 + (double integral of the specific force) to the poses. Eq. (22).
///
/// @param samples    IMU from the start of the window to its end
/// @param T_odom_imu poses within the window, in order; their positions are used
/// @param begin      attitude and biases at the first sample
/// @return nothing with fewer than four poses
[[nodiscard]] std::optional<InertialAlignment> align_inertially(const sensor::ImuSamples& samples,
                                                                const math::Trajectory& T_odom_imu,
                                                                const imu::NavState& begin);

}  // namespace mmlins::odometry
