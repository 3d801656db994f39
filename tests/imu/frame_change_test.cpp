// SPDX-License-Identifier: MIT
#include "mmlins/imu/frame_change.hpp"

#include <gtest/gtest.h>

#include "mmlins/sim/random.hpp"

namespace mmlins::imu {
namespace {

NavState some_state() {
  NavState state;
  state.R_odom_imu = math::so3_exp(Vector3d(0.3, -0.2, 1.1));
  state.p_odom = Vector3d(4.0, -7.0, 1.0);
  state.v_odom = Vector3d(1.5, 0.4, -0.2);
  state.gravity_odom = math::so3_exp(Vector3d(0.02, -0.03, 0.0)) * Vector3d(0.0, 0.0, -kGravity);
  return state;
}

ErrorMatrix some_covariance() {
  sim::Random random(5);
  ErrorMatrix A;
  for (int i = 0; i < kErrorSize; ++i) {
    for (int j = 0; j < kErrorSize; ++j) A(i, j) = 0.01 * random.normal();
  }
  return A * A.transpose() + 1e-6 * ErrorMatrix::Identity();
}

// Central differences of smooth functions with values up to ten.
constexpr double kStep = 1e-5;
constexpr double kDifferenceError = 1e-7;

TEST(FrameChange, CarriesTheCovarianceWithTheState) {
  const math::SE3 T{math::so3_exp(Vector3d(0.1, 0.2, -2.0)), Vector3d(3.0, 2.0, -1.0)};
  const Estimate estimate{some_state(), some_covariance()};
  ErrorMatrix J;
  for (int i = 0; i < kErrorSize; ++i) {
    const ErrorVector d = kStep * ErrorVector::Unit(i);
    const NavState base = transformed(T, estimate.state);
    J.col(i) = (minus(transformed(T, plus(estimate.state, d)), base) - minus(transformed(T, plus(estimate.state, -d)), base)) /
               (2.0 * kStep);
  }
  EXPECT_LT((transformed(T, estimate).P - J * estimate.P * J.transpose()).norm(), kDifferenceError);
}

TEST(FrameChange, AndBackChangesNothing) {
  const math::SE3 T{math::so3_exp(Vector3d(0.1, 0.2, -2.0)), Vector3d(3.0, 2.0, -1.0)};
  const Estimate estimate{some_state(), some_covariance()};
  const Estimate back = transformed(T.inverse(), transformed(T, estimate));
  EXPECT_LT(minus(back.state, estimate.state).norm(), 1e-12);
  EXPECT_LT((back.P - estimate.P).norm(), 1e-12);
}

// Somebody who calls his attitude R although it is R Exp(e) sees velocity and gravity turned the other way.
TEST(PoseTakenForGranted, TurnsDoubtOfTheAttitudeIntoDoubtOfVelocityAndGravity) {
  const Estimate estimate{some_state(), some_covariance()};
  const auto as_seen = [&](const NavState& truth) {
    NavState seen = estimate.state;
    const Matrix3d R_seen_truth = estimate.state.R_odom_imu * truth.R_odom_imu.transpose();
    seen.v_odom = R_seen_truth * truth.v_odom;
    seen.gravity_odom = R_seen_truth * truth.gravity_odom;
    seen.gyro_bias = truth.gyro_bias;
    seen.accel_bias = truth.accel_bias;
    return seen;
  };
  ErrorMatrix J;
  for (int i = 0; i < kErrorSize; ++i) {
    const ErrorVector d = kStep * ErrorVector::Unit(i);
    J.col(i) = (minus(as_seen(plus(estimate.state, d)), estimate.state) - minus(as_seen(plus(estimate.state, -d)), estimate.state)) /
               (2.0 * kStep);
  }
  const Estimate granted = with_pose_taken_for_granted(estimate);
  const ErrorMatrix expected = J * estimate.P * J.transpose();
  EXPECT_LT((granted.P - expected).bottomRightCorner(11, 11).norm(), kDifferenceError);
  EXPECT_LT(granted.P.topLeftCorner(6, 6).norm(), 1e-9);
  EXPECT_LT(minus(granted.state, estimate.state).norm(), 1e-15);
}

}  // namespace
}  // namespace mmlins::imu
