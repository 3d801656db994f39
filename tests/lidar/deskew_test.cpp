// SPDX-License-Identifier: MIT
#include "mmlins/lidar/deskew.hpp"

#include <gtest/gtest.h>

#include "mmlins/sim/random.hpp"

namespace mmlins::lidar {
namespace {

using math::SE3;
using math::Trajectory;
using math::Vector3d;

const Time kStart = time_from_ns(1700000000123456789);
constexpr double kSweep = 0.1;  // [s]
const SE3 kT_imu_lidar{math::so3_exp({0.3, -1.2, 2.0}), {0.3, -0.1, 0.5}};
constexpr RangeGate kAll{0.0, 1000.0};
// Points lie up to 60 m away, where single precision resolves 4 um; a few roundings add up.
constexpr double kRounding = 3e-5;
// Points share poses in stretches of time; no point is farther from the middle of its own than this [s].
constexpr double kLargestTimeError = 1e-4;

/// The IMU turns and drives at constant rates, so that the poses in between are known and are also what
/// interpolation gives.
struct SteadyMotion {
  SE3 start{math::so3_exp({0.2, 0.5, -0.7}), {10.0, -20.0, 3.0}};
  Vector3d rate_imu{0.4, -0.9, 1.5};  // [rad/s]
  Vector3d velocity{8.0, 3.0, -1.0};  // [m/s]

  [[nodiscard]] SE3 at(double seconds) const {
    return {start.R * math::so3_exp(rate_imu * seconds), start.t + velocity * seconds};
  }
  [[nodiscard]] Trajectory trajectory(double first, double last, int count) const {
    Trajectory poses;
    for (int i = 0; i < count; ++i) {
      const double t = count > 1 ? first + (last - first) * i / (count - 1) : first;
      poses.push_back({kStart + from_seconds(t), at(t)});
    }
    return poses;
  }
};

/// Landmarks of a world, each measured at its own time from where the LiDAR then was.
struct MovingScan {
  sensor::LidarScan scan;
  std::vector<Vector3d> p_world;
};

MovingScan make_scan(const SteadyMotion& motion, int count) {
  sim::Random random(1);
  MovingScan result;
  result.scan.start_time = kStart;
  result.scan.end_time = kStart + from_seconds(kSweep);
  for (int i = 0; i < count; ++i) {
    const double t = kSweep * i / (count - 1);
    const Vector3d p_world = motion.start.t + random.normal3().normalized() * random.uniform(5.0, 50.0);
    result.p_world.push_back(p_world);
    result.scan.points.push_back(((motion.at(t) * kT_imu_lidar).inverse() * p_world).cast<float>());
    result.scan.offsets.push_back(static_cast<float>(t));
    result.scan.intensities.push_back(0.0F);
  }
  return result;
}

double largest_error(const Cloud& cloud, const std::vector<Vector3d>& p_world, const SE3& T_world_imu) {
  double largest = 0.0;
  for (std::size_t i = 0; i < cloud.size(); ++i) {
    const Vector3d expected = T_world_imu.inverse() * p_world[cloud.source[i]];
    largest = std::max(largest, (cloud.points[i].cast<double>() - expected).norm());
  }
  return largest;
}

TEST(Deskew, PointsOfAMovingScanMeetTheirLandmarks) {
  const SteadyMotion motion;
  const MovingScan moving = make_scan(motion, 2001);
  const Cloud cloud = deskew(moving.scan, motion.trajectory(0.0, kSweep, 21), kT_imu_lidar, kAll);
  ASSERT_EQ(cloud.size(), moving.scan.size());
  const double fastest = motion.rate_imu.norm() * 60.0 + motion.velocity.norm();
  EXPECT_LT(largest_error(cloud, moving.p_world, motion.at(kSweep)), kLargestTimeError * fastest + kRounding);
  // The scan was really distorted: with the extrinsics alone it misses by metres.
  const Cloud bent = deskew(moving.scan, {{moving.scan.end_time, SE3{}}}, kT_imu_lidar, kAll);
  EXPECT_GT(largest_error(bent, moving.p_world, motion.at(kSweep)), 1.0);
}

TEST(Deskew, OnlyTheMotionDuringTheScanMattersNotWhereItBegan) {
  SteadyMotion here;
  SteadyMotion far_away = here;
  far_away.start = SE3{math::so3_exp({-1.0, 0.3, 2.0}), {500.0, 100.0, -50.0}};
  far_away.velocity = far_away.start.R * here.start.R.transpose() * here.velocity;
  const sensor::LidarScan scan = make_scan(here, 200).scan;
  const Cloud a = deskew(scan, here.trajectory(0.0, kSweep, 21), kT_imu_lidar, kAll);
  const Cloud b = deskew(scan, far_away.trajectory(0.0, kSweep, 21), kT_imu_lidar, kAll);
  for (std::size_t i = 0; i < a.size(); ++i) EXPECT_LT((a.points[i] - b.points[i]).norm(), kRounding);
}

TEST(Deskew, TrajectoryMayReachBeyondTheScanAtItsBeginning) {
  const SteadyMotion motion;
  const MovingScan moving = make_scan(motion, 500);
  const Cloud exact = deskew(moving.scan, motion.trajectory(0.0, kSweep, 21), kT_imu_lidar, kAll);
  const Cloud longer = deskew(moving.scan, motion.trajectory(-0.3, kSweep, 81), kT_imu_lidar, kAll);
  ASSERT_EQ(longer.size(), exact.size());
  for (std::size_t i = 0; i < exact.size(); ++i) {
    EXPECT_LT((exact.points[i] - longer.points[i]).norm(), kRounding) << i;
  }
}

TEST(Deskew, PointsBeforeTheTrajectoryTakeItsFirstPose) {
  const SteadyMotion motion;
  const MovingScan moving = make_scan(motion, 101);
  // The poses begin only in the middle of the scan.
  const Cloud cloud = deskew(moving.scan, motion.trajectory(0.05, kSweep, 11), kT_imu_lidar, kAll);
  const SE3 T = motion.at(kSweep).inverse() * motion.at(0.05) * kT_imu_lidar;
  for (std::size_t i = 0; i < 50; ++i) {
    EXPECT_LT((cloud.points[i].cast<double>() - T * moving.scan.points[i].cast<double>()).norm(), kRounding)
        << i;
  }
}

TEST(Deskew, StationaryScanIsOnlyMovedByTheExtrinsics) {
  SteadyMotion motion;
  motion.rate_imu.setZero();
  motion.velocity.setZero();
  const MovingScan still = make_scan(motion, 300);
  const Cloud cloud = deskew(still.scan, motion.trajectory(0.0, kSweep, 21), kT_imu_lidar, kAll);
  ASSERT_EQ(cloud.size(), still.scan.size());
  for (std::size_t i = 0; i < cloud.size(); ++i) {
    const Vector3d expected = kT_imu_lidar * still.scan.points[i].cast<double>();
    EXPECT_LT((cloud.points[i].cast<double>() - expected).norm(), kRounding) << i;
    EXPECT_EQ(cloud.source[i], i);
  }
}

TEST(Deskew, InstantaneousScanTakesThePoseOfItsInstant) {
  const SteadyMotion motion;
  sensor::LidarScan scan = make_scan(motion, 50).scan;
  scan.start_time = scan.end_time;
  scan.offsets.assign(scan.size(), 0.0F);
  // With the poses since the scan before, and with a single one.
  for (const auto& poses : {motion.trajectory(-0.4, kSweep, 101), motion.trajectory(kSweep, kSweep, 1)}) {
    const Cloud cloud = deskew(scan, poses, kT_imu_lidar, kAll);
    ASSERT_EQ(cloud.size(), scan.size());
    for (std::size_t i = 0; i < cloud.size(); ++i) {
      EXPECT_LT((cloud.points[i].cast<double>() - kT_imu_lidar * scan.points[i].cast<double>()).norm(),
                kRounding);
    }
  }
}

TEST(Deskew, RangeIsCountedFromTheLidarAndSourcesPointBack) {
  sensor::LidarScan scan;
  scan.start_time = scan.end_time = kStart;
  scan.points = {{0.4F, 0, 0}, {0.6F, 0, 0}, {0, 0, -9.9F}, {0, 10.1F, 0}, {3, 3, 3}};
  scan.offsets.assign(scan.size(), 0.0F);
  const SE3 far_mount{math::Matrix3d::Identity(), {5.0, 0.0, 0.0}};
  const Cloud cloud = deskew(scan, {{kStart, SE3{}}}, far_mount, {0.5, 10.0});
  EXPECT_EQ(cloud.source, (std::vector<std::uint32_t>{1, 2, 4}));
}

TEST(Deskew, EmptyScanGivesAnEmptyCloud) {
  sensor::LidarScan scan;
  scan.start_time = scan.end_time = kStart;
  EXPECT_EQ(deskew(scan, {{kStart, SE3{}}}, kT_imu_lidar, kAll).size(), 0U);
}

}  // namespace
}  // namespace mmlins::lidar
