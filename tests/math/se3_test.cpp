// SPDX-License-Identifier: MIT
#include "mmlins/math/se3.hpp"

#include <gtest/gtest.h>

#include <cmath>
#include <numbers>
#include <vector>

#include "mmlins/math/trajectory.hpp"

namespace mmlins::math {
namespace {

constexpr double kRounding = 1e-13;  // a dozen multiplications of numbers up to ten

std::vector<Vector6d> tangents() {
  std::vector<Vector6d> all;
  for (const double angle : {0.0, 1e-9, 1e-5, 1e-3, 0.5, 2.0, std::numbers::pi - 1e-6}) {
    Vector6d x;
    x << angle * Vector3d(2, -1, 2) / 3.0, 4.0, -5.0, 6.0;
    all.push_back(x);
  }
  return all;
}

bool near(const SE3& A, const SE3& B, double tolerance = kRounding) {
  return (A.R - B.R).norm() < tolerance && (A.t - B.t).norm() < 10.0 * tolerance;
}

SE3 power(SE3 T, int doublings) {
  for (int i = 0; i < doublings; ++i) T = T * T;
  return T;
}

TEST(Se3, GroupAxiomsHold) {
  for (const Vector6d& x : tangents()) {
    const SE3 A = se3_exp(x);
    const SE3 B = se3_exp(0.3 * x.reverse());
    const SE3 C{so3_exp({0.1, 0.2, -0.3}), {1.0, 2.0, 3.0}};
    EXPECT_TRUE(near((A * B) * C, A * (B * C)));
    EXPECT_TRUE(near(A * A.inverse(), SE3{}));
    EXPECT_TRUE(near(A.inverse() * A, SE3{}));
    EXPECT_TRUE(near(A * SE3{}, A));
  }
}

TEST(Se3, ProductsActOnPointsOneAfterTheOther) {
  const SE3 A{so3_exp({0.1, 0.2, -0.3}), {1.0, 2.0, 3.0}};
  const SE3 B{so3_exp({-1.0, 0.5, 2.0}), {-4.0, 0.0, 1.0}};
  const Vector3d p(7.0, -8.0, 9.0);
  EXPECT_LT(((A * B) * p - A * (B * p)).norm(), kRounding);
}

TEST(Se3, LogarithmUndoesTheExponential) {
  // Close to half a turn the inverse Jacobian enlarges the rounding of the rotation by the size of t.
  for (const Vector6d& x : tangents()) EXPECT_LT((se3_log(se3_exp(x)) - x).norm(), 1e-12) << x.transpose();
}

TEST(Se3, NegatedTangentIsTheInverse) {
  for (const Vector6d& x : tangents()) EXPECT_TRUE(near(se3_exp(-x), se3_exp(x).inverse()));
}

// Exp(x) = Exp(x / 2^n)^(2^n), and for tiny arguments Exp(x) = I + x: the definition of the exponential.
TEST(Se3, ExponentialIsTheLimitOfManySmallSteps) {
  constexpr int kDoublings = 24;
  for (const Vector6d& x : tangents()) {
    const Vector6d step = x / static_cast<double>(1 << kDoublings);
    const SE3 T = power({so3_exp(step.head<3>()), step.tail<3>()}, kDoublings);
    // The error of one step is |w| |u| / 2 / 4^24, times 2^24 steps; and 24 doublings of rounding.
    EXPECT_TRUE(near(T, se3_exp(x), 2e-7)) << x.transpose();
  }
}

TEST(Se3, InterpolationHitsTheEndsAndTurnsEvenly) {
  const SE3 from{so3_exp({0.1, 0.2, -0.3}), {1.0, 2.0, 3.0}};
  const Vector3d turn(0.5, -1.0, 0.7);
  const SE3 to{from.R * so3_exp(turn), {5.0, 0.0, 3.0}};
  EXPECT_TRUE(near(interpolate(from, to, 0.0), from));
  EXPECT_TRUE(near(interpolate(from, to, 1.0), to));
  EXPECT_TRUE(near(interpolate(from, to, 0.25), {from.R * so3_exp(0.25 * turn), {2.0, 1.5, 3.0}}));
}

TEST(Trajectory, PosesAreFoundBetweenStampsButNotOutsideOrAcrossHoles) {
  const auto at = [](std::int64_t ms) { return time_from_ns(ms * 1'000'000); };
  const Trajectory trajectory{{at(0), {Matrix3d::Identity(), {0, 0, 0}}},
                              {at(100), {Matrix3d::Identity(), {1, 0, 0}}},
                              {at(1100), {Matrix3d::Identity(), {2, 0, 0}}}};
  const Duration max_gap = from_seconds(0.5);
  EXPECT_NEAR(pose_at(trajectory, at(25), max_gap)->t.x(), 0.25, kRounding);
  EXPECT_EQ(pose_at(trajectory, at(0), max_gap)->t.x(), 0.0);
  EXPECT_EQ(pose_at(trajectory, at(100), max_gap)->t.x(), 1.0);
  EXPECT_EQ(pose_at(trajectory, at(1100), max_gap)->t.x(), 2.0);
  EXPECT_FALSE(pose_at(trajectory, at(600), max_gap).has_value());
  EXPECT_FALSE(pose_at(trajectory, at(-1), max_gap).has_value());
  EXPECT_FALSE(pose_at(trajectory, at(1101), max_gap).has_value());
  EXPECT_FALSE(pose_at({}, at(0), max_gap).has_value());
}

}  // namespace
}  // namespace mmlins::math
