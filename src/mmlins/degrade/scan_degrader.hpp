// SPDX-License-Identifier: MIT
#pragma once
// Applies events to the points of a LiDAR, each point by its own time. Nothing here knows whether the
// points come from a simulator or out of a recorded message: it gets positions and times, and says which
// points remain, and where they are now.

#include <Eigen/Core>
#include <cstdint>
#include <vector>

#include "mmlins/base/time.hpp"
#include "mmlins/degrade/event_spec.hpp"
#include "mmlins/sensor/lidar_scan.hpp"

namespace mmlins::degrade {

/// One sweep as the events see it. Points that are not finite or at the origin are beams without an echo.
struct SweepView {
  Time stamp;                                            ///< seeds what is random in this sweep
  const std::vector<Eigen::Vector3f>* points = nullptr;  ///< in the LiDAR frame [m]
  const std::vector<Time>* times = nullptr;              ///< of each point
};

/// What is left of a sweep.
struct DegradedSweep {
  bool changed = false;                 ///< false: everything is as it was
  bool lost = false;                    ///< the whole sweep never arrived
  std::vector<std::uint32_t> kept;      ///< which points remain, in their old order
  std::vector<Eigen::Vector3f> points;  ///< where they are now, one for each of `kept` [m]
};

struct DegradeOptions {
  std::uint64_t seed = 1;
  double min_range = 0.0;  ///< the sensor gives nothing nearer than this [m]
};

class ScanDegrader {
 public:
  /// @param recording_start  what the starts of the events count from, in the clock of the points
  ScanDegrader(std::vector<EventSpec> events, Time recording_start, const DegradeOptions& options);

  /// Same events, options and sweep: same result. Events act one after the other, in the order given.
  [[nodiscard]] DegradedSweep apply(const SweepView& sweep) const;

 private:
  std::vector<EventSpec> events_;
  Time recording_start_;
  DegradeOptions options_;
};

/// The points of a degraded scan; its times are those of the points that are left.
/// @param sweep  of apply() on this scan
[[nodiscard]] sensor::LidarScan degraded(const sensor::LidarScan& scan, const DegradedSweep& sweep);

/// Absolute times of the points of a scan.
[[nodiscard]] std::vector<Time> point_times(const sensor::LidarScan& scan);

}  // namespace mmlins::degrade
