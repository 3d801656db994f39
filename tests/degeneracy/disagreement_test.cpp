// SPDX-License-Identifier: MIT
#include "mmlins/degeneracy/disagreement.hpp"

#include <gtest/gtest.h>

#include <Eigen/Cholesky>
#include <cmath>

#include "mmlins/math/random.hpp"

namespace mmlins::degeneracy {
namespace {

using math::Matrix6d;
using math::Vector6d;

Vector6d noise(math::Random& random) {
  Vector6d v;
  for (int i = 0; i < 6; ++i) v(i) = random.normal();
  return v;
}

/// Any positive definite matrix with eigenvalues of the size of `scale`.
Matrix6d some_matrix(math::Random& random, double scale) {
  Matrix6d A;
  for (int i = 0; i < 6; ++i) A.col(i) = noise(random);
  return scale * (A * A.transpose() + Matrix6d::Identity());
}

/// From the prediction to the best estimate, when the scan alone would put the pose at `scan` from the
/// prediction.
Vector6d fused_shift(const Vector6d& scan, const Matrix6d& P_prior, const Matrix6d& H) {
  return (P_prior.inverse() + H).ldlt().solve(H * scan);
}

TEST(InnovationChi2, IsTheDistanceOfThePredictionFromTheScanInTheirJointUncertainty) {
  math::Random random(1);
  for (int trial = 0; trial < 20; ++trial) {
    const Matrix6d P = some_matrix(random, 1e-3);
    const Matrix6d H = some_matrix(random, 500.0);
    const Vector6d scan = noise(random);
    const double expected = scan.dot((P + Matrix6d(H.inverse())).inverse() * scan);
    // Condition numbers are some thousands.
    EXPECT_NEAR(innovation_chi2(fused_shift(scan, P, H), P, H), expected, 1e-9 * expected);
  }
}

TEST(InnovationChi2, IsNilIfTheScanAgrees) {
  math::Random random(2);
  EXPECT_EQ(innovation_chi2(Vector6d::Zero(), some_matrix(random, 1e-3), some_matrix(random, 500.0)), 0.0);
}

// Both are right on average: mean 6, variance 12. With 5000 trials the mean has a deviation of 0.05, and the
// variance, by the fourth moment of chi-squared (6), one of 0.34.
TEST(InnovationChi2, HasSixDegreesOfFreedomIfBothAreRight) {
  math::Random random(3);
  const Matrix6d P = some_matrix(random, 1e-3);
  const Matrix6d H = some_matrix(random, 500.0);
  const Matrix6d root_P = P.llt().matrixL();
  const Matrix6d root_scan = Matrix6d(H.inverse()).llt().matrixL();
  double sum = 0.0;
  double sum_squares = 0.0;
  constexpr int kTrials = 5000;
  for (int trial = 0; trial < kTrials; ++trial) {
    const Vector6d scan = root_scan * noise(random) - root_P * noise(random);
    const double chi2 = innovation_chi2(fused_shift(scan, P, H), P, H);
    sum += chi2 / kTrials;
    sum_squares += chi2 * chi2 / kTrials;
  }
  EXPECT_NEAR(sum, 6.0, 0.2);
  EXPECT_NEAR(sum_squares - sum * sum, 12.0, 1.5);
}

TEST(InnovationChi2, ADirectionThatTheScanDoesNotSeeCannotDisagree) {
  math::Random random(4);
  const Matrix6d P = 0.01 * Matrix6d::Identity();
  using Matrix5d = Eigen::Matrix<double, 5, 5>;
  const Matrix5d H_seen = some_matrix(random, 500.0).topLeftCorner<5, 5>();
  Matrix6d H = Matrix6d::Zero();
  H.topLeftCorner<5, 5>() = H_seen;
  Vector6d scan = noise(random);
  const Matrix5d joint = 0.01 * Matrix5d::Identity() + Matrix5d(H_seen.inverse());
  const double expected = scan.head<5>().dot(joint.inverse() * scan.head<5>());
  EXPECT_NEAR(innovation_chi2(fused_shift(scan, P, H), P, H), expected, 1e-9 * expected);
  scan(5) += 100.0;
  EXPECT_NEAR(innovation_chi2(fused_shift(scan, P, H), P, H), expected, 1e-9 * expected);
  EXPECT_EQ(innovation_chi2(Vector6d::Zero(), P, Matrix6d::Zero()), 0.0);
}

}  // namespace
}  // namespace mmlins::degeneracy
