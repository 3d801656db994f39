// SPDX-License-Identifier: MIT
#pragma once
// A run beside the true trajectory.

#include <string>
#include <vector>

#include "mmlins/eval/evaluation.hpp"
#include "mmlins/pipeline/slam_system.hpp"

namespace mmlins::report {

/// Error of one trajectory at each scan, after alignment; NaN at scans that the truth does not cover.
struct ErrorSeries {
  std::vector<double> position;      ///< [m]
  std::vector<double> rotation_deg;  ///< [deg]
};

struct TruthComparison {
  std::string file;
  eval::Evaluation odometry;
  eval::Evaluation trajectory;
  ErrorSeries odometry_errors;
  ErrorSeries trajectory_errors;
  std::vector<math::Vector3d> path_world;  ///< true positions at the scans, in the frame of the first map; of those covered
};

/// Compares both trajectories of the run with the truth, each aligned by rotation and translation; by
/// heading and translation where its path, a straight line, does not determine more.
/// Errors, one line: no common time, too few common poses, a path that does not determine the alignment.
/// @param file  what to call the truth
[[nodiscard]] Result<TruthComparison> compare_with_truth(const pipeline::RunResult& result, const math::Trajectory& truth,
                                                         const std::string& file);

}  // namespace mmlins::report
