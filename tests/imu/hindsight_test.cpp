// SPDX-License-Identifier: MIT
#include "mmlins/imu/hindsight.hpp"

#include <gtest/gtest.h>

#include <Eigen/LU>

#include "mmlins/imu/frame_change.hpp"

namespace mmlins::imu {
namespace {

constexpr int kSeen = kErrorSize - kVelocity;
using SeenVector = Eigen::Matrix<double, kSeen, 1>;
using SeenMatrix = Eigen::Matrix<double, kSeen, kSeen>;
const ImuNoise kNoise{4e-4, 2e-2, 2e-5, 2e-4};

/// 20 s in the dark, driving round bends: from a state known as well as a filter knows it.
Estimate carried() {
  ErrorVector deviation;
  deviation << Vector3d::Constant(1e-3), Vector3d::Constant(0.005), Vector3d::Constant(0.01), Vector3d::Constant(2e-4),
      Vector3d::Constant(0.01), Eigen::Vector2d::Constant(2e-3);
  Estimate start;
  start.P = deviation.cwiseAbs2().asDiagonal();
  start.state.v_odom = Vector3d(1.5, 0.0, 0.0);
  sensor::ImuSamples samples;
  for (int i = 0; i <= 4000; ++i) {
    const double t = 0.005 * i;
    samples.push_back({Time(from_seconds(t)), Vector3d(0.0, 0.0, 0.3 * std::sin(0.4 * t)),
                       Vector3d(0.2 * std::cos(t), 0.45 * std::sin(0.4 * t), kGravity)});
  }
  return propagate(start, samples, kNoise).estimate;
}

Eigen::Matrix<double, kSeen, kErrorSize> seen_of(const Estimate& estimate) {
  return jacobian_of_granted_pose(estimate.state).bottomRows<kSeen>();
}

/// What somebody finds who measures `z` (of what is seen) with covariance R, and takes the carried state for its prior.
Estimate found_from(const Estimate& before, const SeenVector& z, const SeenMatrix& R) {
  const Estimate granted = with_pose_taken_for_granted(before);
  const SeenMatrix Q = granted.P.bottomRightCorner<kSeen, kSeen>();
  const SeenMatrix gain = Q * (Q + R).inverse();
  ErrorVector shift = ErrorVector::Zero();
  shift.tail<kSeen>() = gain * z;
  Estimate found{plus(granted.state, shift), granted.P};
  found.P.bottomRightCorner<kSeen, kSeen>() = Q - gain * Q;
  return found;
}

SeenMatrix as_a_trial_sees() {
  SeenVector deviation;
  deviation << Vector3d::Constant(0.02), Vector3d::Constant(1e-3), Vector3d::Constant(0.05), Eigen::Vector2d::Constant(3e-3);
  return deviation.cwiseAbs2().asDiagonal();
}

// A drift of the tilt that shows in the velocity: within what the IMU may have done.
SeenVector some_surprise() {
  SeenVector z = SeenVector::Zero();
  z << 0.9, -0.6, 0.05, 1e-4, -1e-4, 5e-5, 0.004, 0.002, 0.001, 0.006, -0.004;
  return z;
}

TEST(Hindsight, IsWhatAFilterSaysThatSawItAll) {
  const Estimate before = carried();
  const auto A = seen_of(before);
  const SeenMatrix R = as_a_trial_sees();
  const Eigen::Matrix<double, kErrorSize, kSeen> K =
      before.P * A.transpose() * (A * before.P * A.transpose() + R).inverse();
  const ErrorVector shift = K * some_surprise();
  const ErrorMatrix P = before.P - K * A * before.P;

  const auto after = in_hindsight(before, found_from(before, some_surprise(), R));
  ASSERT_TRUE(after);
  // Metres; two inversions of matrices with deviations from 1e-4 to 10.
  EXPECT_LT((minus(after->state, before.state) - shift).norm(), 1e-6);
  EXPECT_LT((after->P - P).norm(), 1e-6 * before.P.norm());
}

TEST(Hindsight, KnowsThePlaceFarBetter) {
  const Estimate before = carried();
  const auto after = in_hindsight(before, found_from(before, some_surprise(), as_a_trial_sees()));
  ASSERT_TRUE(after);
  const auto deviation = [](const Estimate& estimate) { return std::sqrt(pose_covariance(estimate).bottomRightCorner<3, 3>().trace()); };
  EXPECT_GT(deviation(before), 3.0);
  EXPECT_LT(deviation(*after), 0.5 * deviation(before));
}

TEST(Hindsight, DoesNotDependOnTheFrameInWhichThingsWereFound) {
  const Estimate before = carried();
  const Estimate found = found_from(before, some_surprise(), as_a_trial_sees());
  const math::SE3 elsewhere{math::so3_exp(Vector3d(0.05, -0.02, 2.0)), Vector3d(30.0, -4.0, 2.0)};
  const auto here = in_hindsight(before, found), there = in_hindsight(before, transformed(elsewhere, found));
  ASSERT_TRUE(here && there);
  EXPECT_LT(minus(here->state, there->state).norm(), 1e-8);
  EXPECT_LT((here->P - there->P).norm(), 1e-8);
}

TEST(Hindsight, ChangesNothingWhereNothingNewWasFound) {
  const Estimate before = carried();
  const auto after = in_hindsight(before, with_pose_taken_for_granted(before));
  ASSERT_TRUE(after);
  EXPECT_LT(minus(after->state, before.state).norm(), 1e-9);
  // A pose that is taken for granted counts as known to 1e-5 rad and m, not to nothing.
  EXPECT_LT((after->P - before.P).norm(), 1e-6 * before.P.norm());
}

TEST(Hindsight, IsNoneWhereTheImuCannotHaveLedThere) {
  const Estimate before = carried();
  SeenVector z = some_surprise();
  z(2) = 8.0;  // a velocity upwards that nothing felt
  EXPECT_FALSE(in_hindsight(before, found_from(before, z, as_a_trial_sees())));
}

}  // namespace
}  // namespace mmlins::imu
