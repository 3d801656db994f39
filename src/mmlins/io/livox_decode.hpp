// SPDX-License-Identifier: MIT
#pragma once
// livox_ros_driver/CustomMsg and livox_ros_driver2/CustomMsg, which are laid out alike.

#include <string_view>

#include "mmlins/base/result.hpp"
#include "mmlins/io/byte_reader.hpp"
#include "mmlins/io/lidar_cloud.hpp"

namespace mmlins::io {

/// The time of each point after the stamp of the message. [ns]
inline constexpr std::string_view kLivoxTimeField = "offset_time";

/// Errors do not name the topic, the caller knows it.
[[nodiscard]] Result<LidarCloud> decode_livox(Bytes message);

}  // namespace mmlins::io
