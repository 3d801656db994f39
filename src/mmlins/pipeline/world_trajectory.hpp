// SPDX-License-Identifier: MIT
#pragma once
// One trajectory for the whole recording: every scan is hung between the keyframes around it, wherever these lie in
// the end, and what the IMU alone carried is fitted between its two ends. docs/math/mapping.md, Eqs. (4) to (7a).

#include <optional>
#include <span>
#include <vector>

#include "mmlins/base/time.hpp"
#include "mmlins/math/se3.hpp"
#include "mmlins/sensor/rig.hpp"

namespace mmlins::pipeline {

/// A keyframe before and after.
struct KeyframePlace {
  Time time;
  int map_id = 0;
  math::SE3 T_map_imu;    ///< as the odometry had it
  math::SE3 T_world_imu;  ///< as it lies in the end
};

/// A pose with its velocity.
struct CarriedPose {
  math::SE3 T_odom_imu;
  math::Vector3d v_imu = math::Vector3d::Zero();  ///< along the axes of the IMU [m/s]
};

struct ScanPlace {
  Time time;
  int map_id = 0;
  bool is_placed = false;  ///< matched, so that T_map_imu is to be believed
  math::SE3 T_map_imu;
  math::SE3 T_odom_imu;
  math::Vector3d v_imu = math::Vector3d::Zero();  ///< along the axes of the IMU [m/s]
  std::optional<CarriedPose> carried;             ///< what the IMU alone made of the way from the scan before
  bool is_cut_off = false;                        ///< nothing tells of the way from the scan before
};

/// @param scans      in the order of their times
/// @param keyframes  likewise
/// @return T_world_imu of every scan
[[nodiscard]] std::vector<math::SE3> world_trajectory(std::span<const ScanPlace> scans,
                                                      std::span<const KeyframePlace> keyframes,
                                                      const sensor::Rig& rig);

}  // namespace mmlins::pipeline
