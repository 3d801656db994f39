// SPDX-License-Identifier: MIT
#include "mmlins/odometry/scan_tracker.hpp"

#include <gtest/gtest.h>

#include "mmlins/odometry/restart.hpp"

namespace mmlins::odometry {
namespace {

double distance_to_a_rotation(const math::Matrix3d& R) {
  return (R.transpose() * R - math::Matrix3d::Identity()).cwiseAbs().maxCoeff();
}

TEST(ScanTracker, KeepsRotationsHoweverManyMapsBegin) {
  imu::Estimate start;
  start.state.R_odom_imu = math::so3_exp({0.3, -0.2, 1.0});
  ScanTracker tracker(OdometryConfig{}, sensor::Rig{}, start);
  for (int map = 0; map < 100; ++map) {
    const math::SE3 T_odom_imu = tracker.estimate().state.T_odom_imu();
    const math::SE3 T_turned{math::so3_exp({0.0, 0.0, 0.1 * map}) * T_odom_imu.R, T_odom_imu.t};
    tracker.call_the_pose(with_heading_of(T_turned, T_odom_imu));
  }
  // Rounding of a hundred products.
  EXPECT_LT(distance_to_a_rotation(tracker.T_odom_map().R), 1e-12);
  EXPECT_LT(distance_to_a_rotation(tracker.estimate().state.R_odom_imu), 1e-12);
}

}  // namespace
}  // namespace mmlins::odometry
