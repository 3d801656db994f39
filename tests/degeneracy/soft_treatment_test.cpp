// SPDX-License-Identifier: MIT
#include "mmlins/degeneracy/soft_treatment.hpp"

#include <gtest/gtest.h>

#include <Eigen/Cholesky>
#include <Eigen/Eigenvalues>
#include <cmath>

#include "mmlins/math/random.hpp"

namespace mmlins::degeneracy {
namespace {

using math::Matrix6d;
using math::Vector3d;
using math::Vector6d;

// Products of numbers up to a few thousand.
constexpr double kRounding = 1e-9;

Vector6d some_vector(math::Random& random) {
  Vector6d v;
  for (int i = 0; i < 6; ++i) v(i) = random.normal();
  return v;
}

/// A scan whose rotation and position are coupled as in a real one, and its pull towards `minimum`.
Quadratic some_scan(math::Random& random, const Vector6d& minimum) {
  Quadratic scan;
  for (int i = 0; i < 40; ++i) {
    const Vector6d J = some_vector(random);
    scan.H += 100.0 * J * J.transpose();
  }
  scan.b = -scan.H * minimum;
  return scan;
}

/// The directions of the scan, with shares set by hand, the weakest direction of each block first.
Observability with_shares(const Quadratic& scan, const Vector3d& translation, const Vector3d& rotation) {
  Observability result = analyse_observability({scan.H, Matrix6d::Zero()}, {});
  for (std::size_t i = 0; i < 3; ++i) {
    result.translation[i].noise_share = translation(static_cast<int>(i));
    result.rotation[i].noise_share = rotation(static_cast<int>(i));
  }
  return result;
}

double information(const Direction& direction) { return 1.0 / (direction.std * direction.std); }

TEST(KeptShare, IsAllUpToTheLimitAndBeyondItWhatIsNotFeigned) {
  ObservabilityConfig config;
  config.weak_noise_share = 0.25;
  const auto kept = [&](double noise_share) {
    Direction direction;
    direction.noise_share = noise_share;
    return kept_share(direction, config);
  };
  EXPECT_EQ(kept(0.0), 1.0);
  EXPECT_EQ(kept(0.25), 1.0);
  EXPECT_EQ(kept(0.5), 0.5);
  EXPECT_EQ(kept(0.875), 0.125);
  EXPECT_EQ(kept(1.0), 0.0);
}

TEST(Soften, TakesFromADoubtfulDirectionItsShareAndFromTheOthersNothing) {
  math::Random random(1);
  const Quadratic scan = some_scan(random, some_vector(random));
  const Observability before = with_shares(scan, Vector3d(0.8, 0.4, 0.0), Vector3d::Zero());
  const Quadratic soft = soften(scan, before, {});
  const Observability after = analyse_observability({soft.H, Matrix6d::Zero()}, {});
  const double expected[] = {0.2, 0.6, 1.0};
  for (std::size_t i = 0; i < 3; ++i) {
    // The order may change: what was second may now be the weakest.
    double found = 0.0;
    for (const Direction& direction : after.translation) {
      if (std::abs(direction.axis.dot(before.translation[i].axis)) > 1.0 - kRounding)
        found = information(direction);
    }
    EXPECT_NEAR(found, expected[i] * information(before.translation[i]),
                kRounding * information(before.translation[i]));
  }
}

TEST(Soften, DoesTheSameToRotations) {
  math::Random random(2);
  const Quadratic scan = some_scan(random, some_vector(random));
  const Observability before = with_shares(scan, Vector3d::Zero(), Vector3d(0.9, 0.0, 0.0));
  const Observability after = analyse_observability({soften(scan, before, {}).H, Matrix6d::Zero()}, {});
  EXPECT_NEAR(information(after.rotation[0]), 0.1 * information(before.rotation[0]),
              kRounding * information(before.rotation[0]));
  EXPECT_NEAR(std::abs(after.rotation[0].axis.dot(before.rotation[0].axis)), 1.0, kRounding);
}

TEST(Soften, LeavesTheMinimumWhereItWas) {
  math::Random random(3);
  const Vector6d minimum = some_vector(random);
  const Quadratic scan = some_scan(random, minimum);
  const Quadratic soft =
      soften(scan, with_shares(scan, Vector3d(0.99, 0.5, 0.2), Vector3d(0.9, 0.3, 0.0)), {});
  EXPECT_GT((soft.b - scan.b).norm(), 1.0);
  EXPECT_LT((soft.H.ldlt().solve(-soft.b) - minimum).norm(), kRounding);
}

TEST(Soften, LeavesAScanWithoutDoubtfulDirectionsUntouchedToTheBit) {
  math::Random random(4);
  const Quadratic scan = some_scan(random, some_vector(random));
  const double limit = ObservabilityConfig{}.weak_noise_share;
  const Quadratic soft =
      soften(scan, with_shares(scan, Vector3d::Constant(limit), Vector3d::Constant(limit)), {});
  EXPECT_EQ(soft.H, scan.H);
  EXPECT_EQ(soft.b, scan.b);
}

TEST(Soften, NeverTakesMoreThanThereIs) {
  math::Random random(5);
  for (int trial = 0; trial < 50; ++trial) {
    const Quadratic scan = some_scan(random, some_vector(random));
    const Quadratic soft = soften(scan, with_shares(scan, Vector3d::Ones(), Vector3d::Ones()), {});
    const Eigen::SelfAdjointEigenSolver<Matrix6d> left(soft.H);
    const Eigen::SelfAdjointEigenSolver<Matrix6d> taken(scan.H - soft.H);
    EXPECT_GT(left.eigenvalues()(0), -kRounding * scan.H.norm());
    EXPECT_GT(taken.eigenvalues()(0), -kRounding * scan.H.norm());
  }
}

// A tunnel along x: all that the scan says about x is feigned, and says that we are a metre ahead of the
// prediction.
TEST(Soften, LeavesAFeignedDirectionToThePrediction) {
  Quadratic scan;
  scan.H.diagonal() << 4e4, 4e4, 4e4, 1e4, 1e6, 1e6;
  const Vector6d minimum = (Vector6d() << 0.0, 0.0, 0.0, 1.0, 0.02, -0.01).finished();
  scan.b = -scan.H * minimum;
  const Observability observability = with_shares(scan, Vector3d(1.0, 0.0, 0.0), Vector3d::Zero());
  const Matrix6d prediction = 1e4 * Matrix6d::Identity();
  const auto fused = [&](const Quadratic& q) { return Vector6d((prediction + q.H).ldlt().solve(-q.b)); };
  EXPECT_NEAR(fused(scan)(3), 0.5, kRounding);
  const Quadratic soft = soften(scan, observability, {});
  EXPECT_NEAR(fused(soft)(3), 0.0, kRounding);
  EXPECT_NEAR(fused(soft)(4), fused(scan)(4), kRounding);
  EXPECT_NEAR(fused(soft)(5), fused(scan)(5), kRounding);
}

TEST(Soften, TakesNothingFromNothing) {
  const Quadratic soft = soften({}, with_shares({}, Vector3d::Ones(), Vector3d::Ones()), {});
  EXPECT_EQ(soft.H, Matrix6d::Zero());
  EXPECT_EQ(soft.b, Vector6d::Zero());
}

}  // namespace
}  // namespace mmlins::degeneracy
