// SPDX-License-Identifier: MIT
#pragma once
// What the IMU alone carried, once both ends are known: the most likely way between them, given how its errors grow.
// docs/math/mapping.md, Eqs. (5) to (7).

#include <span>
#include <vector>

#include "mmlins/base/time.hpp"
#include "mmlins/math/se3.hpp"
#include "mmlins/sensor/rig.hpp"

namespace mmlins::pipeline {

struct MovingPose {
  Time time;
  math::SE3 T_world_imu;
  math::Vector3d v_world = math::Vector3d::Zero();  ///< [m/s]
};

/// @param carried  from the last pose that is known, to what the IMU makes of the next one that is known; at least two
/// @param end      that pose as it really is, of the same time as the last carried one
/// @return the carried poses but the first and the last, corrected
[[nodiscard]] std::vector<math::SE3> smooth(std::span<const MovingPose> carried, const MovingPose& end,
                                            const sensor::Rig& rig);

}  // namespace mmlins::pipeline
