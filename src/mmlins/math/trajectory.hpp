// SPDX-License-Identifier: MIT
#pragma once
// Poses over time, in increasing order, with interpolation between them.

#include <algorithm>
#include <optional>
#include <vector>

#include "mmlins/base/time.hpp"
#include "mmlins/math/se3.hpp"

namespace mmlins::math {

struct StampedPose {
  Time time;
  SE3 pose;
};

/// Stamps strictly increasing.
using Trajectory = std::vector<StampedPose>;

/// The pose at `time`, interpolated between its neighbours; nothing outside the trajectory or across a
/// hole longer than `max_gap`.
[[nodiscard]] inline std::optional<SE3> pose_at(const Trajectory& trajectory, Time time, Duration max_gap) {
  const auto next = std::lower_bound(trajectory.begin(), trajectory.end(), time,
                                     [](const StampedPose& stamped, Time t) { return stamped.time < t; });
  if (next == trajectory.end()) return std::nullopt;
  if (next->time == time) return next->pose;
  if (next == trajectory.begin()) return std::nullopt;
  const auto previous = std::prev(next);
  if (next->time - previous->time > max_gap) return std::nullopt;
  const double s = to_seconds(time - previous->time) / to_seconds(next->time - previous->time);
  return interpolate(previous->pose, next->pose, s);
}

}  // namespace mmlins::math
