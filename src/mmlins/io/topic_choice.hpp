// SPDX-License-Identifier: MIT
#pragma once
// Which topics of a recording are the LiDAR and the inertial sensor.

#include <cstddef>
#include <string>

#include "mmlins/base/result.hpp"
#include "mmlins/io/rosbag1/rosbag1_reader.hpp"
#include "mmlins/sensor/rig.hpp"

namespace mmlins::io {

/// The topic that the rig names, or else the only one with messages of a fitting type.
/// Errors list what there is to choose from. @return index into reader.topics()
[[nodiscard]] Result<std::size_t> choose_lidar_topic(const Rosbag1Reader& reader, const sensor::Rig& rig);
[[nodiscard]] Result<std::size_t> choose_imu_topic(const Rosbag1Reader& reader, const sensor::Rig& rig);

}  // namespace mmlins::io
