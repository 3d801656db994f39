// SPDX-License-Identifier: MIT
#pragma once
// What each kind of event does to the points of one sweep that lie within it.

#include <Eigen/Core>
#include <cstdint>
#include <vector>

#include "mmlins/base/time.hpp"
#include "mmlins/degrade/event_spec.hpp"

namespace mmlins::degrade {

/// A point on its way through the events.
struct EffectPoint {
  std::uint32_t index = 0;                             ///< in the sweep
  Eigen::Vector3f position = Eigen::Vector3f::Zero();  ///< [m]
  bool has_echo = true;
  Duration since_begin{0};  ///< of the event
};

/// What an effect may depend on besides the points.
struct EffectContext {
  EventSpec event;
  std::uint64_t event_seed = 0;  ///< the same for all sweeps
  std::uint64_t sweep_seed = 0;  ///< differs from sweep to sweep
  std::size_t sweep_size = 0;    ///< points with an echo in the whole sweep, in and out of the event
};

/// The points that are left, in order, where they are now.
/// @param points  those of one sweep whose time lies within the event
[[nodiscard]] std::vector<EffectPoint> apply_effect(const std::vector<EffectPoint>& points,
                                                    const EffectContext& context);

/// Distance of a membrane of mean distance `distance` that surrounds the sensor and flutters [m].
/// @param direction  unit vector in the LiDAR frame
[[nodiscard]] double membrane_range(const Eigen::Vector3d& direction, double seconds, double distance,
                                    std::uint64_t seed);

}  // namespace mmlins::degrade
