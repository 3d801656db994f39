// SPDX-License-Identifier: MIT
#pragma once
// What a start is found from: poses that the LiDAR measured over a second or so, and the IMU in between.

#include <vector>

#include "mmlins/imu/preintegration.hpp"

namespace mmlins::initialization {

/// A pose that the scans alone gave, without help of the IMU's translation; otherwise the IMU counts twice.
struct PoseMeasurement {
  Time time;
  math::SE3 T_odom_imu;
  /// Inverse covariance of [rotation (on the right), position (added, in odom)]; zero where a direction is
  /// not seen.
  math::Matrix6d information = math::Matrix6d::Zero();
};

/// Times strictly increasing.
using PoseMeasurements = std::vector<PoseMeasurement>;

struct Window {
  PoseMeasurements poses;
  sensor::ImuSamples samples;  ///< from the first pose to the last
  imu::ImuNoise noise;
};

[[nodiscard]] PoseMeasurement pose_with_covariance(Time time, const math::SE3& T_odom_imu,
                                                   const math::Matrix6d& covariance);

/// The pose of the scan that begins a map: where it is, is a matter of choice.
[[nodiscard]] PoseMeasurement defining_pose(Time time, const math::SE3& T_odom_imu);

/// The pose that scan matching alone prefers, where the sum of its weighted squares around `T_odom_imu` is
/// d^T H d + 2 b^T d + const: the least of it, but unmoved in directions that H hardly sees. Eq. (19).
[[nodiscard]] PoseMeasurement pose_from_matching(Time time, const math::SE3& T_odom_imu,
                                                 const math::Matrix6d& H, const math::Vector6d& b);

}  // namespace mmlins::initialization
