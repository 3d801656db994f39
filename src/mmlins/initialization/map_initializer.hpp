// SPDX-License-Identifier: MIT
#pragma once
// The state in motion, as likely as it can be: one estimator over a window of LiDAR poses and the IMU between
// them, whatever is known beforehand. docs/math/initialization.md, sections 3 and 4.

#include "mmlins/initialization/state_prior.hpp"

namespace mmlins::initialization {

enum class SolveStatus { kSolved, kTooFewPoses, kNoImu, kSingular, kNotConverged };

/// What says whether the solution can be believed.
struct SolutionFigures {
  int num_poses = 0;
  double duration = 0.0;             ///< from the first pose to the last [s]
  double longest_imu_step = 0.0;     ///< [s]
  double gravity_error = 0.0;        ///< of gravity estimated freely: | |g| - G | [m/s^2]
  double sigma_gravity = 0.0;        ///< deviation of that |g|; infinite if poses do not determine it [m/s^2]
  double sigma_tilt = 0.0;           ///< of the direction of gravity as the IMU sees it, largest [rad]
  double inseparable_tilt = 0.0;     ///< what the prior's accelerometer bias hides, if it knows no gravity [rad]
  double sigma_speed = 0.0;          ///< of the velocity at the last pose, largest [m/s]
  double sigma_speed_unaided = 0.0;  ///< the same if the prior said nothing about velocity [m/s]
  double chi2_per_dof = 0.0;
  int degrees_of_freedom = 0;
  double gyro_bias_sigmas = 0.0;  ///< how far the bias moved from its prior
  double accel_bias_sigmas = 0.0;
  int iterations = 0;
};

struct MapSolution {
  SolveStatus status = SolveStatus::kTooFewPoses;
  imu::Estimate estimate;             ///< at the last pose, with its full marginal covariance
  std::vector<imu::NavState> states;  ///< at every pose, to straighten the scans again
  SolutionFigures figures;
};

/// Gauss-Newton over attitude, position and velocity at every pose, the biases, and the direction of gravity;
/// in the frame of the poses. Estimates are of use with any status but kSolved only for show.
/// @param prior  at the first pose; its biases are where the IMU is linearised
[[nodiscard]] MapSolution solve_map(const Window& window, const StatePrior& prior, int max_iterations);

}  // namespace mmlins::initialization
