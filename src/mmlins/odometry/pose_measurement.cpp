// SPDX-License-Identifier: MIT
#include "mmlins/odometry/pose_measurement.hpp"

#include <Eigen/LU>
#include <numbers>

namespace mmlins::odometry {

initialization::PoseMeasurement measured_pose(const ScanResult& result, const RestartConfig& config) {
  auto pose = initialization::pose_from_matching(result.time, result.pull.T_odom_imu, result.pull.H, result.pull.b);
  const double rotation = config.pose_deviation_deg * std::numbers::pi / 180.0;
  math::Matrix6d doubt = math::Matrix6d::Identity();
  doubt.diagonal().head<3>().setConstant(rotation * rotation);
  doubt.diagonal().tail<3>().setConstant(config.pose_deviation * config.pose_deviation);
  const math::Matrix6d shrink = (math::Matrix6d::Identity() + doubt * pose.information).inverse();
  pose.information = pose.information * shrink;
  pose.information = 0.5 * (pose.information + pose.information.transpose()).eval();
  return pose;
}

initialization::BiasDeviation bias_deviation(const sensor::Rig& rig) {
  return {rig.gyro_turn_on_bias, rig.accel_turn_on_bias};
}

}  // namespace mmlins::odometry
