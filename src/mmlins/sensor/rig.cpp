// SPDX-License-Identifier: MIT
#include "mmlins/sensor/rig.hpp"

#include <cmath>

namespace mmlins::sensor {

Fields Rig::fields() {
  return {
      field("lidar_model", lidar_model, "free text, for people"),
      field("lidar_topic", lidar_topic, "topic of the point clouds; empty: the only one"),
      field("imu_topic", imu_topic, "topic of the inertial sensor; empty: the only one"),
      field("p_imu_lidar", p_imu_lidar, "m", {-100.0, 100.0}, "origin of the LiDAR in the IMU frame"),
      field("q_imu_lidar_xyzw", q_imu_lidar_xyzw, "", {-1.0, 1.0},
            "rotation that takes directions from the LiDAR frame to the IMU frame, quaternion x y z w"),
      field("imu_rate_hz", imu_rate_hz, "Hz", {0.0, 1e5},
            "nominal rate of the inertial sensor, for people: the samples' own times are used"),
      field("gyro_noise_density", gyro_noise_density, "rad/s/sqrt(Hz)", {1e-8, 1.0}, "white noise of the gyroscope"),
      field("accel_noise_density", accel_noise_density, "m/s^2/sqrt(Hz)", {1e-8, 10.0},
            "white noise of the accelerometer"),
      field("gyro_bias_walk", gyro_bias_walk, "rad/s^2/sqrt(Hz)", {0.0, 1.0}, "random walk of the gyroscope's bias"),
      field("accel_bias_walk", accel_bias_walk, "m/s^3/sqrt(Hz)", {0.0, 10.0},
            "random walk of the accelerometer's bias"),
      field("gyro_turn_on_bias", gyro_turn_on_bias, "rad/s", {1e-6, 1.0},
            "standard deviation of the gyroscope's bias when switched on, per axis"),
      field("accel_turn_on_bias", accel_turn_on_bias, "m/s^2", {1e-6, 5.0},
            "the same for the accelerometer; a start in motion cannot tell it from tilt at once"),
      field("time_field", time_field, "point field that holds the time; empty: found by name"),
      field("time_unit", time_unit, {"auto", "s", "ms", "us", "ns"}, "unit of the time field"),
      field("time_reference", time_reference, {"auto", "absolute", "relative"},
            "whether the time field counts from the epoch or from the stamp of the cloud"),
      field("stamp_reference", stamp_reference, {"auto", "start", "end"},
            "whether the stamp of a cloud is the time of its first or of its last point"),
      field("accel_unit", accel_unit, {"auto", "m/s^2", "g"}, "unit of the accelerometer"),
      field("lidar_time_offset", lidar_time_offset, "s", {-10.0, 10.0},
            "added to LiDAR times to put them on the clock of the IMU"),
      field("min_range", min_range, "m", {0.0, 100.0}, "nearer points are the robot itself"),
      field("max_range", max_range, "m", {1.0, 1000.0}, "farther points are not used"),
      field("range_noise", range_noise, "m", {1e-4, 1.0}, "standard deviation of one range"),
      field("bearing_noise_deg", bearing_noise_deg, "deg", {0.0, 5.0}, "standard deviation of one beam's direction"),
  };
}

math::SE3 Rig::T_imu_lidar() const {
  const auto& q = q_imu_lidar_xyzw;
  return {Eigen::Quaterniond(q[3], q[0], q[1], q[2]).normalized().toRotationMatrix(),
          math::Vector3d(p_imu_lidar[0], p_imu_lidar[1], p_imu_lidar[2])};
}

Status validate(const Rig& rig, const std::string& source) {
  const auto& q = rig.q_imu_lidar_xyzw;
  const double norm = std::sqrt(q[0] * q[0] + q[1] * q[1] + q[2] * q[2] + q[3] * q[3]);
  if (!(std::abs(norm - 1.0) <= 1e-2)) {
    return make_error(ErrorCode::kInvalid,
                      "{}: q_imu_lidar_xyzw has length {:.4f} and is no rotation; give a unit quaternion in the order x y z w",
                      source, norm);
  }
  if (!(rig.min_range < rig.max_range)) {
    return make_error(ErrorCode::kInvalid, "{}: min_range ({} m) must be below max_range ({} m)", source, rig.min_range,
                      rig.max_range);
  }
  return {};
}

}  // namespace mmlins::sensor
