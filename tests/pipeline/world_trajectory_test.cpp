// SPDX-License-Identifier: MIT
#include "mmlins/pipeline/world_trajectory.hpp"

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>

namespace mmlins::pipeline {
namespace {

using math::SE3;
using math::Vector3d;

constexpr double kSpeed = 1.5;     // [m/s]
constexpr double kTurnRate = 0.1;  // [rad/s]

Time time_of(double t) { return Time(from_seconds(t)); }

/// Round a circle, looking ahead.
SE3 truth(double t) {
  const double radius = kSpeed / kTurnRate, angle = kTurnRate * t;
  return {math::so3_exp({0.0, 0.0, angle}),
          {radius * std::sin(angle), radius * (1.0 - std::cos(angle)), 0.3}};
}

double apart(const SE3& a, const SE3& b) { return (a.t - b.t).norm(); }

/// Ten scans a second and a keyframe each second. From 3 s to 3 s + `dark` nothing is seen; then comes map
/// `second_map`.
struct Recording {
  std::vector<ScanPlace> scans;
  std::vector<KeyframePlace> keyframes;
  std::vector<SE3> true_poses;

  /// @param T_world_second  where the second map lies
  /// @param accel_error     of the IMU in the dark, along the axes of the world [m/s^2]
  Recording(double dark, int second_map, const SE3& T_world_second, const Vector3d& accel_error) {
    for (int i = 0; i <= std::lround(10.0 * (6.0 + dark)); ++i) {
      const double t = 0.1 * i, in_the_dark = t - 2.9;
      const bool is_second = t >= 3.0 + dark - 1e-9;
      const SE3 T_world_map = is_second && second_map != 0 ? T_world_second : SE3{};
      ScanPlace scan;
      scan.time = time_of(t);
      scan.map_id = is_second ? second_map : 0;
      scan.is_placed = is_second || i < 30;
      scan.T_odom_imu = truth(t);
      scan.v_imu = {kSpeed, 0.0, 0.0};
      if (!scan.is_placed) {
        scan.T_odom_imu.t += 0.5 * in_the_dark * in_the_dark * accel_error;
        scan.v_imu += scan.T_odom_imu.R.transpose() * (in_the_dark * accel_error);
      } else if (is_second) {
        scan.T_odom_imu.t += 0.5 * (dark + 0.1) * (dark + 0.1) * accel_error;  // it goes on where it was
      }
      scan.T_map_imu = T_world_map.inverse() * truth(t);
      scans.push_back(scan);
      true_poses.push_back(truth(t));
      if (scan.is_placed && i % 10 == 0) {
        keyframes.push_back({scan.time, scan.map_id, scan.T_map_imu, truth(t)});
      }
    }
  }

  [[nodiscard]] std::vector<SE3> trajectory() const {
    return world_trajectory(scans, keyframes, sensor::Rig{});
  }
};

TEST(WorldTrajectory, IsThatOfTheMapIfNothingWasCorrected) {
  const Recording recording(0.0, 0, {}, Vector3d::Zero());
  const std::vector<SE3> poses = recording.trajectory();
  ASSERT_EQ(poses.size(), recording.scans.size());
  for (std::size_t i = 0; i < poses.size(); ++i) {
    EXPECT_LT(math::se3_log(recording.scans[i].T_map_imu.inverse() * poses[i]).norm(), 1e-9);
  }
}

TEST(WorldTrajectory, HangsScansBetweenTheKeyframesAroundThem) {
  Recording recording(0.0, 0, {}, Vector3d::Zero());
  // Keyframe 2 is found 0.2 m higher, the others stay.
  recording.keyframes[2].T_world_imu.t.z() += 0.2;
  const std::vector<SE3> poses = recording.trajectory();
  const auto lift = [&](std::size_t i) { return poses[i].t.z() - recording.true_poses[i].t.z(); };
  EXPECT_NEAR(lift(10), 0.0, 1e-9);
  EXPECT_NEAR(lift(15), 0.1, 1e-9);
  EXPECT_NEAR(lift(20), 0.2, 1e-9);
  EXPECT_NEAR(lift(27), 0.06, 1e-9);
  EXPECT_NEAR(lift(30), 0.0, 1e-9);
}

TEST(WorldTrajectory, PutsEveryMapWhereItsKeyframesLie) {
  const SE3 T_world_second{math::so3_exp({0.0, 0.0, 1.1}), {30.0, -4.0, 2.0}};
  const Recording recording(2.0, 1, T_world_second, Vector3d::Zero());
  const std::vector<SE3> poses = recording.trajectory();
  // The velocity that the IMU would have had at the end is continued linearly: 0.15 mm/s off on this circle.
  for (std::size_t i = 0; i < poses.size(); ++i)
    EXPECT_LT(apart(poses[i], recording.true_poses[i]), 1e-4) << i;
}

TEST(WorldTrajectory, EndsACarriedStretchWhereTheNextPlacedScanIs) {
  // 0.3 m/s^2 for 5 s: 3.8 m off.
  const Vector3d error(0.0, 0.3, 0.0);
  for (const int second_map : {0, 1}) {
    const Recording recording(5.0, second_map, {}, error);
    const std::vector<SE3> poses = recording.trajectory();
    for (std::size_t i = 0; i < poses.size(); ++i) {
      const SE3& T_map_imu = recording.scans[i].T_map_imu;
      if (recording.scans[i].is_placed) {
        EXPECT_LT(apart(poses[i], T_map_imu), 1e-9) << i;
      }
      // And nowhere a jump: 0.1 s at 1.5 m/s, and what had to be made up for.
      if (i > 0) {
        EXPECT_LT(apart(poses[i], poses[i - 1]), 0.1 * (kSpeed + 1.5)) << i;
      }
    }
  }
}

TEST(WorldTrajectory, TakesOutWhatAConstantAccelerationErrorDid) {
  const double dark = 5.0;
  const Vector3d error(0.01, -0.015, 0.005);  // [m/s^2], as a bias may be
  const Recording recording(dark, 1, {}, error);
  const double carried = 0.5 * dark * dark * error.norm();
  const std::vector<SE3> poses = recording.trajectory();
  double worst = 0.0;
  for (std::size_t i = 0; i < poses.size(); ++i)
    worst = std::max(worst, apart(poses[i], recording.true_poses[i]));
  // All but what is put down to noise and tilt, which look much the same, and to a velocity not yet settled at the end.
  EXPECT_LT(worst, 0.03 * carried);
}

TEST(WorldTrajectory, MeasuresTheErrorByWhatTheImuMadeOfTheEnd) {
  const double dark = 5.0;
  const Vector3d error(0.01, -0.015, 0.005);  // [m/s^2]
  Recording recording(dark, 0, {}, error);
  // The first scan that is placed again corrects the odometry itself, which then looks as if nothing had been wrong.
  for (std::size_t i = 30; i < recording.scans.size(); ++i) {
    ScanPlace& scan = recording.scans[i];
    if (!scan.is_placed) continue;
    const bool is_first = !recording.scans[i - 1].is_placed;
    if (is_first) {
      scan.carried = {scan.T_odom_imu, scan.v_imu + scan.T_odom_imu.R.transpose() * ((dark + 0.1) * error)};
    }
    scan.T_odom_imu = recording.true_poses[i];
  }
  const std::vector<SE3> poses = recording.trajectory();
  double worst = 0.0;
  for (std::size_t i = 0; i < poses.size(); ++i)
    worst = std::max(worst, apart(poses[i], recording.true_poses[i]));
  // As above.
  EXPECT_LT(worst, 0.03 * 0.5 * dark * dark * error.norm());
}

// Somebody carried the robot on while the IMU was silent, and it drove on 2 s before a new map had its velocity: what was
// carried until then has the wrong place, attitude and velocity, but felt the right forces.
TEST(WorldTrajectory, PutsAllThatIsUnknownIntoTheTimeWithoutImu) {
  const Vector3d gravity(0.0, 0.0, -9.81), v_wrong(0.8, -1.1, 0.3);
  const SE3 T_odom_world{math::so3_exp({0.03, -0.05, 0.4}), {2.0, 1.0, -0.5}};
  const Vector3d gravity_wrong = gravity - T_odom_world.R * gravity;
  Recording recording(2.0, 1, {}, Vector3d::Zero());
  const std::size_t first = 30;
  const auto carried = [&](std::size_t i) {
    const double t = 0.1 * static_cast<double>(i - first);
    SE3 T_odom_imu = T_odom_world * recording.true_poses[i];
    T_odom_imu.t += t * v_wrong + 0.5 * t * t * gravity_wrong;
    const Vector3d v_odom = T_odom_world.R * recording.true_poses[i].R * Vector3d(kSpeed, 0.0, 0.0) + v_wrong + t * gravity_wrong;
    return CarriedPose{T_odom_imu, T_odom_imu.R.transpose() * v_odom};
  };
  std::size_t i = first;
  for (; !recording.scans[i].is_placed; ++i) {
    recording.scans[i].T_odom_imu = carried(i).T_odom_imu;
    recording.scans[i].v_imu = carried(i).v_imu;
  }
  recording.scans[i].carried = carried(i);
  const std::vector<SE3> smoothed = recording.trajectory();
  EXPECT_GT(apart(smoothed[first + 5], recording.true_poses[first + 5]), 0.3);
  recording.scans[first].is_cut_off = true;
  const std::vector<SE3> poses = recording.trajectory();
  for (i = 0; i < poses.size(); ++i) {
    EXPECT_LT(math::se3_log(poses[i].inverse() * recording.true_poses[i]).norm(), 1e-9) << i;
  }
}

TEST(WorldTrajectory, CarriesOnWithoutAnEnd) {
  Recording recording(4.0, 0, {}, Vector3d::Zero());
  recording.scans.resize(60);  // it ends in the dark
  std::erase_if(recording.keyframes, [](const KeyframePlace& k) { return k.time > time_of(5.0); });
  // The last keyframe has been moved; what was carried goes along.
  const SE3 moved{math::so3_exp({0.0, 0.0, 0.2}), {1.0, 2.0, 0.0}};
  for (KeyframePlace& k : recording.keyframes) k.T_world_imu = moved * k.T_world_imu;
  const std::vector<SE3> poses = recording.trajectory();
  for (std::size_t i = 0; i < poses.size(); ++i) {
    EXPECT_LT(apart(poses[i], moved * recording.true_poses[i]), 1e-9) << i;
  }
}

TEST(WorldTrajectory, OfNothingIsNothing) { EXPECT_TRUE(world_trajectory({}, {}, sensor::Rig{}).empty()); }

}  // namespace
}  // namespace mmlins::pipeline
