// SPDX-License-Identifier: MIT
#include "mmlins/initialization/paper_initializer.hpp"

#include <gtest/gtest.h>

#include "tests/initialization/simulated_window.hpp"

namespace mmlins::initialization {
namespace {

using math::Vector3d;

// The midpoint rule at 200 Hz over 0.1 s: the third derivative of a motion of 1 m/s^2 at 6 rad/s, 36 m/s^4,
// times dt^2 / 12 is 8e-5 m/s^2, which four frames magnify as they do any acceleration; squared attitudes
// likewise.
constexpr double kIntegration = 2e-3;

Motion lively(std::uint64_t seed) {
  math::Random random(seed);
  return random_motion(random, 1.0);
}

SimulatedWindow exact_window(const Motion& motion, const Vector3d& gyro_bias, int frames) {
  math::Random random(1);
  SimulatedWindow simulated =
      simulate_window(motion, {gyro_bias, Vector3d::Zero()}, frames, {0.0, 0.0}, random);
  math::Random none(1);
  simulated.window.samples =
      read_imu(motion, {gyro_bias, Vector3d::Zero()}, {}, 0.0, kScanPeriod * (frames - 1), none);
  return simulated;
}

TEST(PaperInitializer, WithoutNoiseItFindsVelocityGravityAndGyroBias) {
  for (std::uint64_t seed = 1; seed <= 5; ++seed) {
    const Vector3d gyro_bias(0.01, -0.02, 0.015);
    const Motion motion = lively(seed);
    const SimulatedWindow simulated = exact_window(motion, gyro_bias, 4);
    const PaperSolution solution = solve_paper(simulated.window);
    ASSERT_EQ(solution.status, PaperStatus::kSolved);
    ASSERT_EQ(solution.v_odom.size(), 4u);
    // A bias of 0.03 rad/s over 0.1 s: the linearised quaternion errs by its cube.
    EXPECT_LT((solution.gyro_bias - gyro_bias).norm(), 2e-4);
    EXPECT_LT((solution.gravity_odom - simulated.last.gravity_odom).norm(), kIntegration * 10.0);
    EXPECT_NEAR(solution.gravity_odom.norm(), imu::kGravity, 1e-12);
    for (int k = 0; k < 4; ++k) {
      const Vector3d v = motion.R(0.0).transpose() * motion.v(kScanPeriod * k);
      EXPECT_LT((solution.v_odom[static_cast<std::size_t>(k)] - v).norm(), kIntegration)
          << seed << ", frame " << k;
    }
  }
}

TEST(PaperInitializer, EstimateIsTheStateAtTheLastFrame) {
  const SimulatedWindow simulated = exact_window(lively(2), Vector3d::Zero(), 6);
  const imu::Estimate estimate = solve_paper(simulated.window).estimate;
  EXPECT_EQ(estimate.state.time, simulated.last.time);
  EXPECT_LT(imu::minus(estimate.state, simulated.last).norm(), 5e-3);
}

TEST(PaperInitializer, LeverArmIsTakenOutOfLidarPoses) {
  const math::SE3 T_imu_lidar{math::so3_exp(Vector3d(0.1, -0.2, 1.5)), Vector3d(0.3, -0.1, 0.5)};
  const Motion motion = lively(3);
  math::Trajectory T_first_lidar;
  const math::SE3 T_world_lidar0 = motion.pose(0.0) * T_imu_lidar;
  for (int k = 0; k < 4; ++k) {
    T_first_lidar.push_back(
        {at(kScanPeriod * k), T_world_lidar0.inverse() * motion.pose(kScanPeriod * k) * T_imu_lidar});
  }
  const math::Trajectory T_first_imu = imu_motion(T_first_lidar, T_imu_lidar);
  for (int k = 0; k < 4; ++k) {
    const math::SE3 truth = motion.pose(0.0).inverse() * motion.pose(kScanPeriod * k);
    const math::SE3& pose = T_first_imu[static_cast<std::size_t>(k)].pose;
    EXPECT_LT((pose.t - truth.t).norm() + (pose.R - truth.R).norm(), 1e-14);
  }
}

TEST(PaperInitializer, RefusesFewerThanFourFramesAndNoImu) {
  SimulatedWindow simulated = exact_window(lively(4), Vector3d::Zero(), 4);
  Window three = simulated.window;
  three.poses.pop_back();
  EXPECT_EQ(solve_paper(three).status, PaperStatus::kTooFewFrames);
  simulated.window.samples.clear();
  EXPECT_EQ(solve_paper(simulated.window).status, PaperStatus::kNoImu);
}

TEST(PaperInitializer, AccelerometerBiasGoesWhollyIntoGravity) {
  // The paper has no accelerometer bias. Without turning, it cannot be told from gravity: tilt = b / G.
  Motion straight;
  straight.yaw_rate = 0.0;
  math::Random random(1);
  SimulatedWindow simulated = simulate_window(straight, {}, 4, {0.0, 0.0}, random);
  for (auto& sample : simulated.window.samples) {
    sample.gyro.setZero();
    sample.accel = Vector3d(0.1, 0.0, imu::kGravity);
  }
  const PaperSolution solution = solve_paper(simulated.window);
  EXPECT_NEAR(tilt_error(solution.estimate.state, simulated.last), std::atan(0.1 / imu::kGravity), 1e-9);
}

}  // namespace
}  // namespace mmlins::initialization
