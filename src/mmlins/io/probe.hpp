// SPDX-License-Identifier: MIT
#pragma once
// Looks at the first messages of a sensor to find out how to read all of them.

#include "mmlins/base/result.hpp"
#include "mmlins/io/recording_info.hpp"
#include "mmlins/io/rosbag1/rosbag1_reader.hpp"
#include "mmlins/sensor/rig.hpp"

namespace mmlins::io {

/// Both leave the reader with the topic selected, somewhere in the bag.
/// Errors name the topic: no message can be decoded; the rig names a field that does not exist.
[[nodiscard]] Result<LidarInfo> probe_lidar(Rosbag1Reader& reader, std::size_t topic, const sensor::Rig& rig);
[[nodiscard]] Result<ImuInfo> probe_imu(Rosbag1Reader& reader, std::size_t topic, const sensor::Rig& rig);

}  // namespace mmlins::io
