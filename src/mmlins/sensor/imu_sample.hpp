// SPDX-License-Identifier: MIT
#pragma once
#include <vector>

#include "mmlins/base/time.hpp"
#include "mmlins/math/so3.hpp"

namespace mmlins::sensor {

/// One reading of the inertial sensor, in the IMU frame.
struct ImuSample {
  Time time;
  math::Vector3d gyro = math::Vector3d::Zero();   ///< angular rate [rad/s]
  math::Vector3d accel = math::Vector3d::Zero();  ///< specific force [m/s^2]: +9.81 on the up axis at rest
};

using ImuSamples = std::vector<ImuSample>;

}  // namespace mmlins::sensor
