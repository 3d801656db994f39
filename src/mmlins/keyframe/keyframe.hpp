// SPDX-License-Identifier: MIT
#pragma once
// What the odometry hands on: a place, what was seen from it, and which way is down. Its pose is in the frame
// of its own map; points stay in the body frame, so that no optimisation ever has to rewrite them.

#include <Eigen/Core>
#include <cstdint>
#include <memory>
#include <vector>

#include "mmlins/base/time.hpp"
#include "mmlins/math/se3.hpp"

namespace mmlins::keyframe {

/// Coordinates of points are whole multiples of this [m], small enough for 16 bits: what is stored is what was in memory.
inline constexpr double kPointQuantum = 0.004;
/// Points farther away along any axis than this have no place in a keyframe [m].
inline constexpr double kPointReach = 131.0;

struct Keyframe {
  int id = 0;
  int map_id = 0;
  Time time;  ///< of the pose and of the points
  math::SE3 T_map_imu;
  math::Vector3d down_imu = -math::Vector3d::UnitZ();  ///< direction of gravity, unit, in the IMU frame
  std::vector<Eigen::Vector3f> points_imu;             ///< thinned, straightened [m]
  std::vector<std::uint16_t> intensities;              ///< of each point; empty if there are none
};

/// Angle of the rotation from one pose to the other [rad].
[[nodiscard]] inline double turn_between(const math::SE3& T_a, const math::SE3& T_b) {
  return math::so3_log((T_a.R.transpose() * T_b.R).eval()).norm();
}

/// Keyframes are shared between stages and never changed.
using KeyframePointer = std::shared_ptr<const Keyframe>;
using Keyframes = std::vector<KeyframePointer>;

}  // namespace mmlins::keyframe
