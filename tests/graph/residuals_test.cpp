// SPDX-License-Identifier: MIT
#include "mmlins/graph/residuals.hpp"

#include <gtest/gtest.h>

#include <cmath>
#include <limits>

#include "mmlins/math/numerical_jacobian.hpp"
#include "mmlins/math/random.hpp"

namespace mmlins::graph {
namespace {

using Eigen::MatrixXd;
using Eigen::VectorXd;

constexpr double kDifferences = 1e-7;  // central differences of step 1e-6 of values up to ten

SE3 random_pose(math::Random& random) { return {math::so3_exp(random.normal3()), 3.0 * random.normal3()}; }

Matrix6d random_information(math::Random& random, int rank) {
  Matrix6d information = Matrix6d::Zero();
  for (int i = 0; i < rank; ++i) {
    Vector6d row;
    row << 100.0 * random.normal3(), random.normal3();
    information += row * row.transpose();
  }
  return information;
}

TEST(EdgeError, IsZeroWhereTheMeasurementIsMet) {
  math::Random random(1);
  const SE3 A = random_pose(random);
  const SE3 Z = random_pose(random);
  EXPECT_LT(edge_error(A, A * Z, Z).norm(), 1e-13);  // rounding of coordinates up to ten
}

TEST(EdgeError, IsTheStepFromTheMeasuredToTheEstimatedPose) {
  math::Random random(2);
  const SE3 A = random_pose(random);
  const SE3 Z = random_pose(random);
  const Vector6d step = (Vector6d() << 0.1, -0.2, 0.3, 0.4, -0.5, 0.6).finished();
  EXPECT_LT((edge_error(A, A * retract(Z, step), Z) - step).norm(), 1e-13);
}

TEST(EdgeError, JacobiansAreItsDerivatives) {
  math::Random random(3);
  for (int trial = 0; trial < 20; ++trial) {
    const SE3 A = random_pose(random);
    const SE3 B = random_pose(random);
    const SE3 Z = random_pose(random);
    const EdgeError error = linearize_edge(A, B, Z);
    if (error.e.head<3>().norm() > 3.0) continue;  // the logarithm jumps at pi
    EXPECT_LT((error.e - edge_error(A, B, Z)).norm(), 1e-12);
    const auto by_from = [&](const VectorXd& x) -> VectorXd { return edge_error(retract(A, x), B, Z); };
    const auto by_to = [&](const VectorXd& x) -> VectorXd { return edge_error(A, retract(B, x), Z); };
    EXPECT_LT((math::numerical_jacobian(by_from, VectorXd::Zero(6)) - error.J_from).norm(), kDifferences);
    EXPECT_LT((math::numerical_jacobian(by_to, VectorXd::Zero(6)) - error.J_to).norm(), kDifferences);
  }
}

TEST(GravityError, JacobianIsItsDerivative) {
  math::Random random(4);
  for (int trial = 0; trial < 10; ++trial) {
    const SE3 A = random_pose(random);
    const Vector3d up = random.normal3().normalized();
    const auto by_rotation = [&](const VectorXd& w) -> VectorXd {
      return linearize_gravity(A.R * math::so3_exp(Vector3d(w)), up).e;
    };
    const MatrixXd numerical = math::numerical_jacobian(by_rotation, VectorXd::Zero(3));
    EXPECT_LT((numerical - linearize_gravity(A.R, up).J_rotation).norm(), kDifferences);
  }
}

TEST(SquareRoot, TimesItselfIsTheInformationWhateverTheRank) {
  math::Random random(5);
  for (int rank = 0; rank <= 6; ++rank) {
    const Matrix6d information = random_information(random, rank);
    const SquareRoot root = square_root(information);
    EXPECT_EQ(root.rank, rank);
    EXPECT_TRUE(is_information(information));
    EXPECT_LT((root.S.transpose() * root.S - information).norm(), 1e-9 * (1.0 + information.norm()));
  }
}

TEST(SquareRoot, DoesNotMistakeUnitsForIgnorance) {
  Vector6d diagonal;
  diagonal << 1e12, 1e12, 1e12, 1e-4, 1e-4, 1e-4;  // a microradian, a hundred metres
  EXPECT_EQ(square_root(diagonal.asDiagonal()).rank, 6);
}

TEST(Information, WithNegativeEigenvaluesOrNoNumbersIsRefused) {
  Matrix6d negative = Matrix6d::Identity();
  negative(0, 1) = negative(1, 0) = 2.0;
  EXPECT_FALSE(is_information(negative));
  EXPECT_FALSE(is_information(-Matrix6d::Identity()));
  Matrix6d lopsided = Matrix6d::Identity();
  lopsided(0, 1) = 0.5;
  EXPECT_FALSE(is_information(lopsided));
  EXPECT_FALSE(is_information(std::numeric_limits<double>::quiet_NaN() * Matrix6d::Identity()));
}

TEST(Adjoint, CarriesStepsThroughAPose) {
  math::Random random(6);
  const SE3 T = random_pose(random);
  const Vector6d x = (Vector6d() << 0.1, -0.2, 0.3, 0.4, -0.5, 0.6).finished();
  const SE3 left = T * math::se3_exp(x);
  const SE3 right = math::se3_exp(math::adjoint(T) * x) * T;
  EXPECT_LT((left.R - right.R).norm() + (left.t - right.t).norm(), 1e-12);
}

}  // namespace
}  // namespace mmlins::graph
