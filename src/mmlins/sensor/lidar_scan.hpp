// SPDX-License-Identifier: MIT
#pragma once
// One sweep of a LiDAR, as plain arrays: only finite points, each with its own time.

#include <Eigen/Core>
#include <cstdint>
#include <vector>

#include "mmlins/base/time.hpp"

namespace mmlins::sensor {

/// Points of one sweep in the LiDAR frame. All arrays have the same length; `ring` may be empty.
struct LidarScan {
  Time start_time;                       ///< time of the earliest point
  Time end_time;                         ///< time of the latest point; equal to start_time if instantaneous
  std::vector<Eigen::Vector3f> points;   ///< [m], finite, in the order of the message
  std::vector<float> offsets;            ///< time of each point after start_time [s], >= 0
  std::vector<float> intensities;        ///< as recorded; zeros if the recording has none
  std::vector<std::uint16_t> rings;      ///< laser number, or empty
  int num_invalid = 0;                   ///< points of the message that were not finite or at the origin

  [[nodiscard]] std::size_t size() const { return points.size(); }
};

}  // namespace mmlins::sensor
