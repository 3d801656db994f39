// SPDX-License-Identifier: MIT
#include "mmlins/imu/nav_state.hpp"

#include <gtest/gtest.h>

#include "mmlins/math/numerical_jacobian.hpp"
#include "mmlins/sim/random.hpp"

namespace mmlins::imu {
namespace {

// A few dozen operations on numbers of size ten.
constexpr double kRounding = 1e-12;
// Central differences with step 1e-6 on numbers of size ten: truncation 1e-12, rounding 1e-15 / 1e-6.
constexpr double kNumerical = 1e-7;

NavState random_state(sim::Random& random) {
  NavState state;
  state.time = time_from_ns(1700000000000000000);
  state.R_odom_imu = math::so3_exp(random.normal3());
  state.p_odom = 10.0 * random.normal3();
  state.v_odom = 3.0 * random.normal3();
  state.gyro_bias = 0.1 * random.normal3();
  state.accel_bias = 0.5 * random.normal3();
  state.gravity_odom = kGravity * random.normal3().normalized();
  return state;
}

/// An error whose rotations stay far below half a turn.
ErrorVector random_error(sim::Random& random, double size) {
  ErrorVector error;
  for (int i = 0; i < kErrorSize; ++i) error(i) = size * random.uniform(-1.0, 1.0);
  return error;
}

double distance(const NavState& a, const NavState& b) {
  return (a.R_odom_imu - b.R_odom_imu).norm() + (a.p_odom - b.p_odom).norm() + (a.v_odom - b.v_odom).norm() +
         (a.gyro_bias - b.gyro_bias).norm() + (a.accel_bias - b.accel_bias).norm() +
         (a.gravity_odom - b.gravity_odom).norm();
}

TEST(NavState, MinusUndoesPlus) {
  sim::Random random(1);
  for (int i = 0; i < 50; ++i) {
    const NavState state = random_state(random);
    const ErrorVector error = random_error(random, i % 2 == 0 ? 1.0 : 1e-6);
    EXPECT_LT((minus(plus(state, error), state) - error).norm(), kRounding) << i;
  }
}

TEST(NavState, PlusUndoesMinus) {
  sim::Random random(2);
  for (int i = 0; i < 50; ++i) {
    const NavState base = random_state(random);
    const NavState state = plus(base, random_error(random, 1.0));
    EXPECT_LT(distance(plus(base, minus(state, base)), state), 10.0 * kRounding) << i;
  }
}

TEST(NavState, NoErrorLeavesTheStateAndIsTheDifferenceOfEquals) {
  sim::Random random(3);
  const NavState state = random_state(random);
  EXPECT_LT(distance(plus(state, ErrorVector::Zero()), state), kRounding);
  EXPECT_LT(minus(state, state).norm(), kRounding);
}

TEST(NavState, PlusKeepsTimeAndTheLengthOfGravity) {
  sim::Random random(4);
  const NavState state = random_state(random);
  const NavState moved = plus(state, random_error(random, 1.0));
  EXPECT_EQ(moved.time, state.time);
  EXPECT_NEAR(moved.gravity_odom.norm(), kGravity, kRounding);
}

TEST(NavState, MinusJacobianMatchesNumericalDifferentiation) {
  sim::Random random(5);
  // From the same state over the small steps of a converging filter to differences of a radian.
  for (const double size : {0.0, 1e-9, 1e-7, 1e-4, 0.1, 1.0}) {
    const NavState base = random_state(random);
    const NavState state = plus(base, random_error(random, size));
    const auto f = [&](const Eigen::VectorXd& d) -> Eigen::VectorXd { return minus(plus(state, d), base); };
    const Eigen::MatrixXd numerical = math::numerical_jacobian(f, Eigen::VectorXd::Zero(kErrorSize));
    EXPECT_LT((minus_jacobian(state, base) - numerical).cwiseAbs().maxCoeff(), kNumerical) << size;
  }
}

}  // namespace
}  // namespace mmlins::imu
