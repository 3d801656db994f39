// SPDX-License-Identifier: MIT
#include "mmlins/math/so3.hpp"

#include <gtest/gtest.h>

#include <cmath>
#include <numbers>
#include <vector>

#include "mmlins/math/numerical_jacobian.hpp"

namespace mmlins::math {
namespace {

constexpr double kPi = std::numbers::pi;
// A dozen multiplications of numbers of size one.
constexpr double kRounding = 1e-14;
// Central differences with step 1e-6: truncation 1e-12, rounding 1e-16 / 1e-6.
constexpr double kNumerical = 1e-9;

/// Rotation vectors of all sizes, from none over the switch to the series up to nearly pi.
std::vector<Vector3d> rotation_vectors() {
  std::vector<Vector3d> vectors{Vector3d::Zero()};
  for (const Vector3d& axis : {Vector3d(1, 0, 0), Vector3d(0, -1, 0), Vector3d(0, 0, 1), Vector3d(1, 2, -3),
                               Vector3d(-0.2, 0.1, 5.0)}) {
    for (const double angle :
         {1e-12, 1e-8, 0.99e-5, 1.01e-5, 1e-4, 1e-3, 0.1, 1.0, 2.0, 3.0, kPi - 1e-4, kPi - 1e-7}) {
      vectors.push_back(angle * axis.normalized());
    }
  }
  return vectors;
}

TEST(So3, SkewIsTheCrossProduct) {
  const Vector3d a(1, -2, 3);
  const Vector3d b(4, 5, -6);
  EXPECT_EQ(Vector3d(skew(a) * b), a.cross(b));
}

TEST(So3, ExponentialIsARotation) {
  for (const Vector3d& w : rotation_vectors()) {
    const Matrix3d R = so3_exp(w);
    EXPECT_TRUE((R * R.transpose()).isIdentity(kRounding)) << w.transpose();
    EXPECT_NEAR(R.determinant(), 1.0, kRounding) << w.transpose();
  }
}

TEST(So3, ExponentialMatchesRodrigues) {
  for (const Vector3d& w : rotation_vectors()) {
    if (w.norm() == 0.0) continue;
    const Matrix3d expected = Eigen::AngleAxisd(w.norm(), w.normalized()).toRotationMatrix();
    EXPECT_TRUE(so3_exp(w).isApprox(expected, kRounding)) << w.transpose();
  }
}

TEST(So3, GroupAxiomsHold) {
  const Matrix3d A = so3_exp({0.3, -1.0, 2.0});
  const Matrix3d B = so3_exp({-2.5, 0.2, 0.7});
  const Matrix3d C = so3_exp({1e-7, 2e-7, -1e-7});
  EXPECT_TRUE(((A * B) * C).isApprox(A * (B * C), kRounding));
  EXPECT_TRUE((A * so3_exp({-0.3, 1.0, -2.0})).isIdentity(kRounding));
  EXPECT_EQ(so3_exp(Vector3d::Zero()), Matrix3d::Identity());
}

TEST(So3, LogarithmUndoesTheExponentialAtEveryAngle) {
  for (const Vector3d& w : rotation_vectors()) {
    EXPECT_LT((so3_log(so3_exp_quaternion(w)) - w).norm(), 1e-14 + kRounding * w.norm()) << w.transpose();
    // A matrix of entries near one holds a rotation vector only to its last digit.
    EXPECT_LT((so3_log(so3_exp(w)) - w).norm(), 1e-14) << w.transpose();
  }
}

TEST(So3, SmallRotationVectorsKeepAllTheirDigitsAsQuaternions) {
  const Vector3d w(1e-12, -2e-12, 3e-12);
  EXPECT_LT((so3_log(so3_exp_quaternion(w)) - w).norm(), 1e-15 * w.norm() + 1e-27);
}

TEST(So3, HalfATurnComesBackAsOneOfItsTwoVectors) {
  for (const Vector3d& axis :
       {Vector3d(1, 0, 0), Vector3d(0, 1, 0), Vector3d(0, 0, 1), Vector3d(0.6, 0, 0.8)}) {
    const Vector3d w = so3_log(so3_exp(kPi * axis));
    EXPECT_NEAR(w.norm(), kPi, kRounding);
    EXPECT_NEAR(std::abs(w.dot(axis)), kPi, kRounding);
  }
}

TEST(So3, LogarithmDoesNotDependOnTheSignOfTheQuaternion) {
  const Eigen::Quaterniond q = so3_exp_quaternion({0.4, -0.5, 2.0});
  const Eigen::Quaterniond minus_q(-q.w(), -q.x(), -q.y(), -q.z());
  EXPECT_EQ(so3_log(q), so3_log(minus_q));
  EXPECT_EQ(so3_log(Eigen::Quaterniond(-1.0, 0.0, 0.0, 0.0)).norm(), 0.0);
}

TEST(So3, RightJacobianMatchesNumericalDifferentiation) {
  for (const Vector3d& w : rotation_vectors()) {
    const auto f = [&](const Eigen::VectorXd& d) -> Eigen::VectorXd {
      return so3_log(Matrix3d(so3_exp(w).transpose() * so3_exp(w + Vector3d(d))));
    };
    const Eigen::MatrixXd expected = numerical_jacobian(f, Eigen::Vector3d::Zero());
    EXPECT_LT((so3_right_jacobian(w) - expected).norm(), kNumerical) << w.transpose();
  }
}

TEST(So3, InverseJacobianMatchesNumericalDifferentiation) {
  for (const Vector3d& w : rotation_vectors()) {
    if (w.norm() > kPi - 1e-3) continue;  // the differences would cross the jump of the logarithm
    const auto f = [&](const Eigen::VectorXd& d) -> Eigen::VectorXd {
      return so3_log(Matrix3d(so3_exp(w) * so3_exp(Vector3d(d))));
    };
    const Eigen::MatrixXd expected = numerical_jacobian(f, Eigen::Vector3d::Zero());
    EXPECT_LT((so3_right_jacobian_inverse(w) - expected).norm(), kNumerical) << w.transpose();
  }
}

TEST(So3, TheTwoJacobiansAreInverses) {
  for (const Vector3d& w : rotation_vectors()) {
    EXPECT_TRUE((so3_right_jacobian(w) * so3_right_jacobian_inverse(w)).isIdentity(1e-13)) << w.transpose();
  }
}

TEST(So3, JacobiansDoNotJumpWhereTheSeriesBegins) {
  const Vector3d axis = Vector3d(1, 2, -3).normalized();
  const Matrix3d below = so3_right_jacobian(0.9999999e-5 * axis);
  const Matrix3d above = so3_right_jacobian(1.0000001e-5 * axis);
  EXPECT_LT((above - below).norm(), 3e-12);  // the true change over 2e-12 rad
  EXPECT_LT(
      (so3_right_jacobian_inverse(0.9999999e-5 * axis) - so3_right_jacobian_inverse(1.0000001e-5 * axis))
          .norm(),
      3e-12);
}

TEST(So3, NearestRotationKeepsRotationsAndRepairsOthers) {
  const Matrix3d R = so3_exp({0.3, -1.0, 2.0});
  EXPECT_TRUE(nearest_rotation(R).isApprox(R, kRounding));
  EXPECT_TRUE(nearest_rotation(2.5 * R).isApprox(R, kRounding));
  const Matrix3d repaired = nearest_rotation(R + 0.01 * Matrix3d::Ones());
  EXPECT_TRUE((repaired * repaired.transpose()).isIdentity(kRounding));
  EXPECT_NEAR(nearest_rotation(-R).determinant(), 1.0, kRounding);
}

}  // namespace
}  // namespace mmlins::math
