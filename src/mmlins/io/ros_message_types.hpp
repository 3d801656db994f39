// SPDX-License-Identifier: MIT
#pragma once
// The message types that are read and written, by name.

#include <string_view>

namespace mmlins::io {

inline constexpr std::string_view kPointCloud2Type = "sensor_msgs/PointCloud2";
inline constexpr std::string_view kImuType = "sensor_msgs/Imu";
inline constexpr std::string_view kLivoxType = "livox_ros_driver/CustomMsg";
inline constexpr std::string_view kLivox2Type = "livox_ros_driver2/CustomMsg";

[[nodiscard]] constexpr bool is_livox_type(std::string_view type) {
  return type == kLivoxType || type == kLivox2Type;
}
[[nodiscard]] constexpr bool is_lidar_type(std::string_view type) {
  return type == kPointCloud2Type || is_livox_type(type);
}

}  // namespace mmlins::io
