// SPDX-License-Identifier: MIT
#include "mmlins/odometry/startup.hpp"

#include <gtest/gtest.h>

#include <Eigen/Eigenvalues>

#include "mmlins/odometry/inertial_alignment.hpp"
#include "mmlins/sim/random.hpp"

namespace mmlins::odometry {
namespace {

using imu::NavState;
using math::Matrix3d;
using math::Vector3d;

const Time kStart = time_from_ns(1700000000000000000);
// Sums over a few hundred numbers of size ten.
constexpr double kRounding = 1e-11;

/// Two seconds of readings of an IMU at rest, tilted by `R_odom_imu`, without noise.
sensor::ImuSamples at_rest(const Matrix3d& R_odom_imu, const Vector3d& gyro_bias) {
  sensor::ImuSamples samples;
  for (int i = 0; i <= 400; ++i) {
    samples.push_back({kStart + from_seconds(0.005 * i), gyro_bias,
                       R_odom_imu.transpose() * Vector3d(0, 0, imu::kGravity)});
  }
  return samples;
}

/// Readings of a lively motion.
sensor::ImuSamples in_motion() {
  sim::Random random(1);
  sensor::ImuSamples samples;
  for (int i = 0; i <= 400; ++i) {
    samples.push_back({kStart + from_seconds(0.005 * i), random.normal3(), 3.0 * random.normal3()});
  }
  return samples;
}

TEST(StartPrior, LevelsATiltedImuWithHeadingZero) {
  const Matrix3d R = (Eigen::AngleAxisd(0.3, Vector3d::UnitY()) * Eigen::AngleAxisd(-0.5, Vector3d::UnitX()))
                         .toRotationMatrix();
  for (const bool rest : {true, false}) {
    const NavState state = start_prior(at_rest(R, Vector3d::Zero()), OdometryConfig{}, {}, rest).state;
    EXPECT_EQ(state.time, kStart);
    EXPECT_LT((state.R_odom_imu.transpose() * Vector3d::UnitZ() - R.transpose() * Vector3d::UnitZ()).norm(),
              kRounding);
    EXPECT_NEAR(std::atan2(state.R_odom_imu(1, 0), state.R_odom_imu(0, 0)), 0.0, kRounding);
    EXPECT_LT((state.gravity_odom - Vector3d(0, 0, -imu::kGravity)).norm(), kRounding);
    EXPECT_LT(state.v_odom.norm() + state.p_odom.norm(), kRounding);
  }
}

TEST(StartPrior, AtRestTheMeanAngularRateIsTheBias) {
  const Vector3d bias(0.01, -0.02, 0.005);
  const NavState state = start_prior(at_rest(Matrix3d::Identity(), bias), OdometryConfig{}, {}, true).state;
  EXPECT_LT((state.gyro_bias - bias).norm(), kRounding);
}

TEST(StartPrior, TiesGravityToTheAccelerometersBias) {
  const initialization::BiasDeviation biases{0.01, 0.1};
  const imu::Estimate prior = start_prior(at_rest(Matrix3d::Identity(), Vector3d::Zero()), OdometryConfig{}, biases, true);
  EXPECT_GE(Eigen::SelfAdjointEigenSolver<imu::ErrorMatrix>(prior.P).eigenvalues()(0), -1e-15);
  // A bias of 0.1 m/s^2 may hide a tilt of 0.1 / 9.81 rad, and neither can be told from the other.
  const double tilt = std::sqrt(prior.P(imu::kGravityDirection, imu::kGravityDirection));
  EXPECT_NEAR(tilt, biases.accel / imu::kGravity, 0.1 * biases.accel / imu::kGravity);
  const Eigen::Matrix<double, 3, 2> cross = prior.P.block<3, 2>(imu::kAccelBias, imu::kGravityDirection);
  EXPECT_GT(cross.col(0).norm() / (tilt * biases.accel), 0.9);
}

TEST(StartPrior, InMotionItIsWiderThanAtRest) {
  const auto samples = at_rest(Matrix3d::Identity(), Vector3d::Zero());
  const auto rest = start_prior(samples, OdometryConfig{}, {}, true).P;
  const auto motion = start_prior(samples, OdometryConfig{}, {}, false).P;
  for (const int i : {imu::kVelocity, imu::kGyroBias, imu::kGravityDirection})
    EXPECT_GT(motion(i, i), rest(i, i));
}

TEST(ImuIsQuiet, AtRestButNotWhenTurningOrShaking) {
  const StartConfig config;
  const auto quiet = at_rest(Matrix3d::Identity(), Vector3d(0.001, 0.0, 0.0));
  EXPECT_TRUE(imu_is_quiet(quiet, config, {}));
  EXPECT_FALSE(imu_is_quiet(in_motion(), config, {}));
  EXPECT_FALSE(
      imu_is_quiet(at_rest(Matrix3d::Identity(), Vector3d(0.5, 0.0, 0.0)), config, {}));  // turns steadily
  EXPECT_FALSE(imu_is_quiet({}, config, {}));
}

TEST(CarriedBack, UndoesWhatTheImuIntegrated) {
  const sensor::ImuSamples samples = in_motion();
  sensor::ImuBuffer imu;
  for (const auto& sample : samples) ASSERT_EQ(imu.add(sample), sensor::ImuAdmission::kAccepted);
  NavState begin;
  begin.time = samples.front().time;
  begin.v_odom = {7.0, -1.0, 0.4};
  begin.accel_bias = {0.05, 0.0, -0.02};
  const imu::ImuNoise noise{1e-3, 1e-2, 1e-5, 1e-4};
  const auto way = imu::propagate({begin, imu::ErrorMatrix::Zero()}, samples, noise);
  const std::vector<Time> times{samples[0].time, samples[137].time, samples[300].time};
  const imu::Estimate end{way.estimate.state, 1e-4 * imu::ErrorMatrix::Identity()};
  const auto back = carried_back(end, times, imu, noise);
  ASSERT_EQ(back.size(), times.size());
  // The midpoint rule takes its attitude from where the step begins, so that there and back differs by rounding only.
  for (std::size_t i = 0; i < times.size(); ++i) {
    const auto truth = *math::pose_at(way.T_odom_imu, times[i], from_seconds(0.01));
    EXPECT_EQ(back[i].state.time, times[i]);
    EXPECT_LT((back[i].state.p_odom - truth.t).norm(), 1e-9) << i;
    EXPECT_LT((back[i].state.R_odom_imu - truth.R).norm(), 1e-9) << i;
  }
  EXPECT_LT((back[0].state.v_odom - begin.v_odom).norm(), 1e-9);
  // The farther back, the less is known.
  EXPECT_GT(back[0].P(imu::kPosition, imu::kPosition), back[2].P(imu::kPosition, imu::kPosition));
}

TEST(InertialAlignment, RecoversVelocityAndGravityFromPositions) {
  NavState truth;
  truth.time = kStart;
  truth.v_odom = {7.0, -1.0, 0.4};
  truth.gyro_bias = {0.01, 0.02, -0.01};
  truth.gravity_odom = imu::kGravity * Vector3d(0.1, -0.2, -1.0).normalized();
  truth.p_odom = {3.0, 2.0, 1.0};
  const sensor::ImuSamples samples = in_motion();
  const auto poses = imu::propagate({truth, imu::ErrorMatrix::Zero()}, samples, {}).T_odom_imu;
  math::Trajectory seldom;
  for (std::size_t i = 17; i < poses.size(); i += 20) seldom.push_back(poses[i]);
  NavState begin = truth;  // attitude and biases are known, the rest is not
  begin.v_odom.setZero();
  begin.p_odom.setZero();
  begin.gravity_odom = {0.0, 0.0, -imu::kGravity};
  const auto aligned = align_inertially(samples, seldom, begin);
  ASSERT_TRUE(aligned);
  // Positions of 15 m, with rounding of 1e-15 each, and a parabola over two seconds.
  EXPECT_LT((aligned->v_odom - truth.v_odom).norm(), 1e-10);
  EXPECT_LT((aligned->gravity_odom - truth.gravity_odom).norm(), 1e-10);
}

TEST(InertialAlignment, NeedsFourPoses) {
  const sensor::ImuSamples samples = in_motion();
  NavState begin;
  begin.time = kStart;
  math::Trajectory poses = imu::propagate({begin, imu::ErrorMatrix::Zero()}, samples, {}).T_odom_imu;
  poses.resize(3);
  EXPECT_FALSE(align_inertially(samples, poses, begin));
}

}  // namespace
}  // namespace mmlins::odometry
