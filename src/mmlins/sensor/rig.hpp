// SPDX-License-Identifier: MIT
#pragma once
// The rig: which sensors, where they sit, how noisy they are. Nothing about the method.

#include <array>
#include <string>

#include "mmlins/base/config_fields.hpp"
#include "mmlins/base/result.hpp"
#include "mmlins/math/se3.hpp"

namespace mmlins::sensor {

enum class TimeUnit { kAuto, kSeconds, kMilliseconds, kMicroseconds, kNanoseconds };
enum class TimeReference { kAuto, kAbsolute, kRelative };
enum class StampReference { kAuto, kStart, kEnd };
enum class AccelUnit { kAuto, kMetresPerSecondSquared, kStandardGravity };

/// Every key may be left out of the file: empty text and "auto" mean "find out".
struct Rig {
  std::string lidar_model;
  std::string lidar_topic;
  std::string imu_topic;
  std::array<double, 3> p_imu_lidar{0.0, 0.0, 0.0};
  std::array<double, 4> q_imu_lidar_xyzw{0.0, 0.0, 0.0, 1.0};
  double imu_rate_hz = 0.0;
  double gyro_noise_density = 2.5e-4;
  double accel_noise_density = 2.0e-3;
  double gyro_bias_walk = 2.0e-5;
  double accel_bias_walk = 2.0e-4;
  double gyro_turn_on_bias = 0.01;
  double accel_turn_on_bias = 0.1;
  std::string time_field;
  TimeUnit time_unit = TimeUnit::kAuto;
  TimeReference time_reference = TimeReference::kAuto;
  StampReference stamp_reference = StampReference::kAuto;
  AccelUnit accel_unit = AccelUnit::kAuto;
  double lidar_time_offset = 0.0;
  double min_range = 0.5;
  double max_range = 200.0;
  double range_noise = 0.02;
  double bearing_noise_deg = 0.05;

  [[nodiscard]] Fields fields();
  /// Maps points from the LiDAR frame to the IMU frame.
  [[nodiscard]] math::SE3 T_imu_lidar() const;
};

/// Checks what ranges alone cannot: the quaternion must be a rotation, the ranges in order.
/// @param source  what to call the rig in the message: its file name
[[nodiscard]] Status validate(const Rig& rig, const std::string& source);

}  // namespace mmlins::sensor
