// SPDX-License-Identifier: MIT
#pragma once
// The reference: dynamic initialisation as the MM-LINS paper has it, from four LiDAR poses, unweighted,
// without accelerometer bias, without priors. docs/math/initialization.md, section 2, also says what was put
// right.

#include <vector>

#include "mmlins/initialization/window.hpp"

namespace mmlins::initialization {

enum class PaperStatus { kSolved, kTooFewFrames, kNoImu, kSingular };

struct PaperSolution {
  PaperStatus status = PaperStatus::kTooFewFrames;
  math::Vector3d gyro_bias = math::Vector3d::Zero();     ///< [rad/s]
  math::Vector3d gravity_odom = math::Vector3d::Zero();  ///< points down, of the known magnitude [m/s^2]
  double gravity_norm = 0.0;                             ///< before it was given its magnitude [m/s^2]
  std::vector<math::Vector3d> v_odom;                    ///< of the IMU at every pose [m/s]
  /// At the last pose. The paper has no covariance; P is what FAST-LIO2 begins its filter with.
  imu::Estimate estimate;
};

/// Gyro bias from rotations, then velocities and gravity from translations. The covariances of poses and IMU
/// are not looked at.
/// @param window  at least four poses; the frame of the poses is that of the result
[[nodiscard]] PaperSolution solve_paper(const Window& window);

/// Poses of the IMU relative to the first, from poses of the LiDAR relative to the first, as ICP gives them.
[[nodiscard]] math::Trajectory imu_motion(const math::Trajectory& T_first_lidar,
                                          const math::SE3& T_imu_lidar);

}  // namespace mmlins::initialization
