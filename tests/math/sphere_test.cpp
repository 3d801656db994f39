// SPDX-License-Identifier: MIT
#include "mmlins/math/sphere.hpp"

#include <gtest/gtest.h>

#include <cmath>
#include <numbers>
#include <vector>

#include "mmlins/math/numerical_jacobian.hpp"

namespace mmlins::math {
namespace {

constexpr double kRounding = 1e-14;

std::vector<Vector3d> directions() {
  return {{0, 0, -9.81}, {9.81, 0, 0}, {0, -9.81, 0}, {1, 1, 1}, {-3, 1e-9, 2}, {1e-3, 0, 0}};
}

std::vector<Vector2d> tangents() {
  return {{0, 0}, {1e-10, -2e-10}, {1e-5, 1e-5}, {0.1, -0.2}, {-1.5, 1.0}, {0, std::numbers::pi - 1e-3}};
}

TEST(Sphere, BasisIsOrthonormalAndOrthogonalToTheDirection) {
  for (const Vector3d& g : directions()) {
    const Matrix32d B = sphere_basis(g);
    EXPECT_TRUE((B.transpose() * B).isIdentity(kRounding)) << g.transpose();
    EXPECT_LT((B.transpose() * g).norm(), kRounding * g.norm()) << g.transpose();
  }
}

TEST(Sphere, PlusKeepsTheLengthAndTurnsByTheLengthOfTheTangent) {
  for (const Vector3d& g : directions()) {
    for (const Vector2d& d : tangents()) {
      const Vector3d h = sphere_plus(g, d);
      EXPECT_NEAR(h.norm(), g.norm(), kRounding * g.norm());
      EXPECT_NEAR(std::atan2(g.cross(h).norm(), g.dot(h)), d.norm(), kRounding);
    }
  }
}

TEST(Sphere, MinusUndoesPlus) {
  for (const Vector3d& g : directions()) {
    for (const Vector2d& d : tangents()) {
      // Close to the opposite direction (1e-3 rad) the axis is known a thousand times worse.
      const double tolerance = d.norm() > 3.0 ? 1e-11 : kRounding;
      EXPECT_LT((sphere_minus(sphere_plus(g, d), g) - d).norm(), tolerance)
          << g.transpose() << " | " << d.transpose();
    }
  }
}

TEST(Sphere, PlusUndoesMinus) {
  for (const Vector3d& a : directions()) {
    for (const Vector3d& b : directions()) {
      const Vector3d h = a.norm() / b.norm() * b;
      EXPECT_LT((sphere_plus(a, sphere_minus(h, a)) - h).norm(), 1e-13 * a.norm());
    }
  }
}

TEST(Sphere, JacobianOfPlusMatchesNumericalDifferentiation) {
  for (const Vector3d& g : directions()) {
    const auto f = [&](const Eigen::VectorXd& d) -> Eigen::VectorXd { return sphere_plus(g, Vector2d(d)); };
    const Eigen::MatrixXd expected = numerical_jacobian(f, Eigen::Vector2d::Zero());
    // Central differences with step 1e-6: rounding 1e-16 / 1e-6 of the length.
    EXPECT_LT((sphere_plus_jacobian(g) - expected).norm(), 1e-9 * g.norm()) << g.transpose();
  }
}

}  // namespace
}  // namespace mmlins::math
