// SPDX-License-Identifier: MIT
#pragma once
// Straightens a sweep: every point goes to where it would have been seen from at the end of the sweep.

#include <Eigen/Core>
#include <cstdint>
#include <vector>

#include "mmlins/math/trajectory.hpp"
#include "mmlins/sensor/lidar_scan.hpp"

namespace mmlins::lidar {

/// Points of a straightened scan; `source` is the index of each in the scan it came from.
struct Cloud {
  std::vector<Eigen::Vector3f> points;
  std::vector<std::uint32_t> source;

  [[nodiscard]] std::size_t size() const { return points.size(); }
};

struct RangeGate {
  double min_range = 0.0;  ///< [m]
  double max_range = 0.0;  ///< [m]
};

/// Moves every point of `scan` within the range gate into the IMU frame at the end of the trajectory.
///
/// @param T_odom_imu   poses that cover the scan, first to last; between them rotation follows the
///                     geodesic and position a straight line. Points before or after take the end pose.
/// @param T_imu_lidar  where the LiDAR sits
[[nodiscard]] Cloud deskew(const sensor::LidarScan& scan, const math::Trajectory& T_odom_imu,
                           const math::SE3& T_imu_lidar, const RangeGate& gate);

}  // namespace mmlins::lidar
