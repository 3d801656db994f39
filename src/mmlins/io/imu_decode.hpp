// SPDX-License-Identifier: MIT
#pragma once
// sensor_msgs/Imu from its ROS 1 wire format.

#include "mmlins/base/result.hpp"
#include "mmlins/io/byte_reader.hpp"
#include "mmlins/sensor/imu_sample.hpp"

namespace mmlins::io {

/// Angular rate and acceleration as recorded: the unit of the acceleration is for the caller to find out,
/// and the numbers may be not finite. Errors do not name the topic, the caller knows it.
[[nodiscard]] Result<sensor::ImuSample> decode_imu(Bytes message);

}  // namespace mmlins::io
