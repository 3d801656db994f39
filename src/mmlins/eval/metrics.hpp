// SPDX-License-Identifier: MIT
#pragma once
// How far an estimate is from the truth, in the usual figures. Pure functions of matched poses.

#include <optional>
#include <vector>

#include "mmlins/base/time.hpp"
#include "mmlins/math/trajectory.hpp"

namespace mmlins::eval {

/// The same instant, estimated and true.
struct PosePair {
  Time time;
  math::SE3 T_truth_imu;
  math::SE3 T_estimate_imu;
};
using PosePairs = std::vector<PosePair>;

struct Statistics {
  double rmse = 0.0;
  double mean = 0.0;
  double median = 0.0;
  double max = 0.0;
  double std = 0.0;  ///< of the population
  int count = 0;
};
[[nodiscard]] Statistics statistics_of(std::vector<double> values);

/// Errors of position and attitude. Units depend on the figure.
struct ErrorFigures {
  Statistics translation;
  Statistics rotation;
};

/// True poses at the stamps of the estimate, interpolated; stamps outside the truth, or inside one of its
/// holes (longer than three times its median period), give no pair.
[[nodiscard]] PosePairs match_poses(const math::Trajectory& truth, const math::Trajectory& estimate);

/// Length of the true path along the pairs [m].
[[nodiscard]] double path_length(const PosePairs& pairs);

/// Absolute errors after the alignment: [m] and [deg].
[[nodiscard]] ErrorFigures absolute_errors(const PosePairs& pairs, const math::SE3& T_truth_estimate);

/// Errors of the motion over `interval` from every pose on, [m] and [deg]. The other pose is the one
/// nearest in time to the end of the interval, and within a quarter of it; nothing if there is no such pair.
[[nodiscard]] std::optional<ErrorFigures> relative_errors_over_time(const PosePairs& pairs,
                                                                    Duration interval);

/// Errors of the motion over 100 m of true path from every pose on, as in the KITTI benchmark: [%] and
/// [deg per 100 m]; nothing if the path is shorter.
[[nodiscard]] std::optional<ErrorFigures> relative_errors_per_100m(const PosePairs& pairs);

/// Error of the motion from the first pose to the last.
struct EndToEndError {
  double translation = 0.0;   ///< [m]
  double rotation_deg = 0.0;  ///< [deg]
};
/// @pre pairs is not empty
[[nodiscard]] EndToEndError end_to_end_error(const PosePairs& pairs);

/// How much of the truth's duration has an estimate.
struct Coverage {
  double share = 0.0;        ///< in [0, 1]; gaps longer than three times the median period do not count
  double longest_gap = 0.0;  ///< between two poses [s]
  double late_start = 0.0;   ///< from the first true pose to the first estimated one [s]
  double early_end = 0.0;    ///< from the last estimated pose to the last true one [s]
};
/// @pre neither is empty
[[nodiscard]] Coverage coverage_of(const math::Trajectory& truth, const math::Trajectory& estimate);

}  // namespace mmlins::eval
