// SPDX-License-Identifier: MIT
#pragma once
// From decoded points to a scan with absolute times.

#include "mmlins/io/lidar_cloud.hpp"
#include "mmlins/io/point_time.hpp"
#include "mmlins/sensor/lidar_scan.hpp"

namespace mmlins::io {

/// Points whose time lies more than a few seconds from that of the others are dropped and counted as
/// invalid: some drivers leave the time of some points at zero.
/// @param time_offset  added to all times: from the clock of the LiDAR to that of the IMU
[[nodiscard]] sensor::LidarScan to_scan(LidarCloud cloud, const PointTimeModel& model, Duration time_offset);

/// The time at which the time field of this message is zero.
/// @param cloud  with points and times
[[nodiscard]] Time zero_of_times(LidarCloud cloud, const PointTimeModel& model);

}  // namespace mmlins::io
