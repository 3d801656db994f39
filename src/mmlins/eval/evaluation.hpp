// SPDX-License-Identifier: MIT
#pragma once
// Everything `mmlins evaluate` reports about one estimate.

#include <optional>
#include <string>

#include "mmlins/base/result.hpp"
#include "mmlins/eval/align.hpp"
#include "mmlins/eval/metrics.hpp"

namespace mmlins::eval {

struct Evaluation {
  int num_truth = 0;                       ///< poses of the truth
  int num_estimate = 0;                    ///< poses of the estimate
  int num_matched = 0;                     ///< poses of the estimate that have a true pose
  double duration = 0.0;                   ///< of the truth [s]
  double path_length = 0.0;                ///< of the truth along the matched poses [m]
  math::SE3 T_truth_estimate;              ///< the alignment
  ErrorFigures absolute;                   ///< [m] and [deg]
  std::optional<ErrorFigures> per_second;  ///< over 1 s: [m] and [deg]; absent if poses are farther apart
  std::optional<ErrorFigures> per_100m;    ///< [%] and [deg per 100 m]; absent if the path is shorter
  EndToEndError end_to_end;
  Coverage coverage;
};

/// Compares the two. Errors, one line each: no common time, fewer than 3 common poses, a path that does
/// not determine the alignment.
[[nodiscard]] Result<Evaluation> evaluate(const math::Trajectory& truth, const math::Trajectory& estimate,
                                          Alignment alignment);

}  // namespace mmlins::eval
