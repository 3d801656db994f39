// SPDX-License-Identifier: MIT
#include "mmlins/sim/motion.hpp"

#include <gtest/gtest.h>

#include <cmath>
#include <numbers>

#include "mmlins/sim/scenario.hpp"

namespace mmlins::sim {
namespace {

using math::Vector3d;

struct NamedMotion {
  std::string name;
  TrajectoryConfig config;
  std::unique_ptr<Motion> motion;
};

// Every style that a scenario uses: ellipses, walks through rooms, drives, starts in motion.
std::vector<NamedMotion> all_motions() {
  std::vector<NamedMotion> motions;
  for (const ScenarioText& scenario : scenario_texts()) {
    const auto config = load_scenario(scenario.name);
    EXPECT_TRUE(config.ok()) << config.error().message;
    motions.push_back(
        {scenario.name, config->trajectory, make_motion(config->trajectory, scene_route(config->world))});
  }
  return motions;
}

// Steps of 1e-4 s: central differences err by h^2/6 times the third derivative, below 1e-6 for these.
constexpr double kStep = 1e-4;
constexpr double kTolerance = 1e-5;

TEST(Motion, VelocityIsTheDerivativeOfPosition) {
  for (const NamedMotion& m : all_motions()) {
    for (double t = 0.51; t < 25.0; t += 0.37) {
      const Vector3d numeric =
          (m.motion->at(t + kStep).T_world_imu.t - m.motion->at(t - kStep).T_world_imu.t) / (2.0 * kStep);
      EXPECT_LT((m.motion->at(t).velocity_world - numeric).norm(), kTolerance) << m.name << " at " << t;
    }
  }
}

TEST(Motion, AccelerationIsTheDerivativeOfVelocity) {
  for (const NamedMotion& m : all_motions()) {
    for (double t = 0.51; t < 25.0; t += 0.37) {
      const Vector3d numeric =
          (m.motion->at(t + kStep).velocity_world - m.motion->at(t - kStep).velocity_world) / (2.0 * kStep);
      EXPECT_LT((m.motion->at(t).acceleration_world - numeric).norm(), kTolerance) << m.name << " at " << t;
    }
  }
}

TEST(Motion, AngularRateIsTheDerivativeOfRotation) {
  for (const NamedMotion& m : all_motions()) {
    for (double t = 0.51; t < 25.0; t += 0.37) {
      const math::Matrix3d R_before_after =
          m.motion->at(t - kStep).T_world_imu.R.transpose() * m.motion->at(t + kStep).T_world_imu.R;
      const Vector3d numeric = math::so3_log(R_before_after) / (2.0 * kStep);
      EXPECT_LT((m.motion->at(t).angular_rate_imu - numeric).norm(), kTolerance) << m.name << " at " << t;
    }
  }
}

// The smoothness that integration of IMU samples relies on: no jump in what the IMU reads.
TEST(Motion, AccelerationHasNoJumps) {
  constexpr double kMaxJerk = 60.0;  // [m/s^3]; steps of a walker at 1.8 Hz have 22
  for (const NamedMotion& m : all_motions()) {
    Vector3d before = m.motion->at(0.0).acceleration_world;
    for (double t = 1e-3; t < 20.0; t += 1e-3) {
      const Vector3d now = m.motion->at(t).acceleration_world;
      ASSERT_LT((now - before).norm(), kMaxJerk * 1e-3) << m.name << " at " << t;
      before = now;
    }
  }
}

TEST(Motion, StandsStillUntilToldToGoAndThenReachesItsSpeed) {
  TrajectoryConfig config;
  config.stand_still = 4.0;
  const auto motion = make_motion(config, {});
  for (const double t : {0.0, 1.0, 3.999}) {
    EXPECT_EQ(motion->at(t).velocity_world.norm(), 0.0);
    EXPECT_EQ(motion->at(t).angular_rate_imu.norm(), 0.0);
    EXPECT_EQ(motion->at(t).acceleration_world.norm(), 0.0);
  }
  EXPECT_GT(motion->at(4.0 + config.ramp).velocity_world.norm(), 0.7 * config.speed);
}

TEST(Motion, StartInMotionMovesFromTheFirstInstant) {
  for (const NamedMotion& m : all_motions()) {
    const double speed = m.motion->at(0.0).velocity_world.norm();
    if (m.config.start_in_motion) {
      EXPECT_GT(speed, 0.4 * m.config.speed) << m.name;
    } else {
      EXPECT_EQ(speed, 0.0) << m.name;
    }
  }
}

TEST(Motion, CarLooksWhereItDrives) {
  const auto config = load_scenario("dev_street32");
  ASSERT_TRUE(config.ok());
  const auto motion = make_motion(config->trajectory, scene_route(config->world));
  const double mount = config->trajectory.mount_yaw_deg * std::numbers::pi / 180.0;
  for (double t = 10.0; t < 60.0; t += 1.7) {
    const Kinematics now = motion->at(t);
    const Vector3d ahead = now.T_world_imu.R * Vector3d(std::cos(mount), -std::sin(mount), 0.0);
    // Roll and pitch of a degree at most.
    EXPECT_GT(ahead.head<2>().normalized().dot(now.velocity_world.head<2>().normalized()), 0.9995);
  }
}

TEST(Course, CruisesOnStraightsAndSlowsDownInCorners) {
  const Course course({{{0, 0}, {120, 0}, {120, 90}, {0, 90}}, {}}, {8.0, 0.5, 1.5});
  double slowest = 1e9;
  double fastest = 0.0;
  for (double t = 0.0; t < course.lap_time(); t += 0.1) {
    const PathPoint at = course.at({t, 1.0, 0.0});
    const double speed = std::hypot(at.x.rate, at.y.rate);
    slowest = std::min(slowest, speed);
    fastest = std::max(fastest, speed);
  }
  EXPECT_NEAR(fastest, 8.0, 0.1);  // rounding to whole control points per lap
  EXPECT_LT(slowest, 4.5);
  EXPECT_GT(slowest, 2.0);
}

TEST(Course, ClosesAndStaysInsideItsPolygon) {
  const Course course({{{0, 0}, {120, 0}, {120, 90}, {0, 90}}, {}}, {8.0, 0.5, 1.5});
  const PathPoint start = course.at({0.0, 1.0, 0.0});
  const PathPoint end = course.at({course.lap_time(), 1.0, 0.0});
  EXPECT_NEAR(start.x.value, end.x.value, 1e-9);
  EXPECT_NEAR(start.y.value, end.y.value, 1e-9);
  for (double t = 0.0; t < course.lap_time(); t += 0.1) {
    const PathPoint at = course.at({t, 1.0, 0.0});
    EXPECT_TRUE(at.x.value > -1e-9 && at.x.value < 120 + 1e-9 && at.y.value > -1e-9 &&
                at.y.value < 90 + 1e-9);
  }
}

}  // namespace
}  // namespace mmlins::sim
