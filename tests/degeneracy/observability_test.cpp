// SPDX-License-Identifier: MIT
#include "mmlins/degeneracy/observability.hpp"

#include <gtest/gtest.h>

#include <cmath>
#include <random>
#include <vector>

namespace mmlins::degeneracy {
namespace {

using math::Matrix3d;
using math::Vector3d;

struct Sample {
  Vector3d p;
  Vector3d normal;
};
using Surface = std::vector<Sample>;

constexpr double kWeight = 1.0 / (0.02 * 0.02);  // residuals of 2 cm

/// Information of perfect matches on a surface whose normals are uncertain by `tilt` radians both ways.
ScanInformation information_of(const Surface& surface, double tilt = 0.0) {
  ScanInformation sum;
  for (const auto& [p, n] : surface) {
    const auto row = [&p = p](const Vector3d& direction) {
      math::Vector6d J;
      J << p.cross(direction), direction;
      return J;
    };
    const Vector3d a = n.unitOrthogonal();
    const Vector3d b = n.cross(a);
    sum.H += kWeight * row(n) * row(n).transpose();
    sum.spurious += kWeight * tilt * tilt * (row(a) * row(a).transpose() + row(b) * row(b).transpose());
  }
  return sum;
}

Surface tunnel_along_x(double radius) {
  Surface surface;
  for (double x = -20.0; x <= 20.0; x += 0.5) {
    for (int i = 0; i < 36; ++i) {
      const Vector3d n(0.0, std::cos(i * M_PI / 18.0), std::sin(i * M_PI / 18.0));
      surface.push_back({Vector3d(x, 0, 0) + radius * n, -n});
    }
  }
  return surface;
}

Surface box(double size) {
  Surface surface;
  for (int axis = 0; axis < 3; ++axis) {
    for (const double side : {-1.0, 1.0}) {
      for (double u = -size; u <= size; u += size / 10) {
        for (double v = -size; v <= size; v += size / 10) {
          Vector3d p;
          p(axis) = side * size;
          p((axis + 1) % 3) = u;
          p((axis + 2) % 3) = v;
          surface.push_back({p, -side * Vector3d::Unit(axis)});
        }
      }
    }
  }
  return surface;
}

Surface ground() {
  Surface surface;
  for (double x = -20.0; x <= 20.0; x += 1.0) {
    for (double y = -20.0; y <= 20.0; y += 1.0) surface.push_back({{x, y, -1.5}, Vector3d::UnitZ()});
  }
  return surface;
}

Surface moved(Surface surface, const Matrix3d& R) {
  for (auto& [p, n] : surface) {
    p = R * p;
    n = R * n;
  }
  return surface;
}

TEST(Observability, ClosedRoomIsFullyObserved) {
  EXPECT_EQ(analyse_observability(information_of(box(5.0)), {}).num_weak(), 0);
}

TEST(Observability, RoundTunnelHidesSlidingAndRollingAlongItsAxis) {
  const Observability seen = analyse_observability(information_of(tunnel_along_x(3.0)), {});
  EXPECT_EQ(seen.num_weak(), 2);
  EXPECT_TRUE(seen.translation[0].weak);
  EXPECT_TRUE(seen.rotation[0].weak);
  EXPECT_NEAR(std::abs(seen.translation[0].axis.x()), 1.0, 1e-6);
  EXPECT_NEAR(std::abs(seen.rotation[0].axis.x()), 1.0, 1e-6);
}

TEST(Observability, OpenFieldHidesMovingOverItAndTurningAboutItsNormal) {
  const Observability seen = analyse_observability(information_of(ground()), {});
  EXPECT_EQ(seen.num_weak(), 3);
  EXPECT_TRUE(seen.translation[1].weak);
  EXPECT_NEAR(std::abs(seen.translation[2].axis.z()), 1.0, 1e-6);
  EXPECT_NEAR(std::abs(seen.rotation[0].axis.z()), 1.0, 1e-6);
}

// The answer may not depend on how the sensor is mounted.
TEST(Observability, VerdictTurnsWithTheScene) {
  for (const double angle : {0.3, 1.1, 2.7}) {
    const Matrix3d R = math::so3_exp(angle * Vector3d(1, 2, 3).normalized());
    const Observability seen = analyse_observability(information_of(moved(tunnel_along_x(3.0), R)), {});
    EXPECT_EQ(seen.num_weak(), 2);
    EXPECT_NEAR(std::abs(seen.translation[0].axis.dot(R.col(0))), 1.0, 1e-6);
  }
}

// H of noisy normals holds information about the tunnel's axis that is not there: more of it the more points
// there are. Its share tells.
TEST(Observability, NoisyNormalsDoNotHideATunnelHoweverManyPointsThereAre) {
  std::mt19937_64 random(1);
  std::normal_distribution<double> normal;
  for (const double tilt : {0.02, 0.05}) {
    for (const int copies : {1, 10}) {
      ScanInformation sum;
      for (int copy = 0; copy < copies; ++copy) {
        Surface surface = tunnel_along_x(3.0);
        const ScanInformation noise_free = information_of(surface, tilt);
        for (auto& [p, n] : surface) {
          n = (n + tilt * (normal(random) * n.unitOrthogonal() + normal(random) * n.cross(n.unitOrthogonal()))).normalized();
        }
        sum += {information_of(surface).H, noise_free.spurious};
      }
      const Observability seen = analyse_observability(sum, {});
      EXPECT_TRUE(seen.translation[0].weak);
      // Random tilts of 2916 points scatter the share by sqrt(2/2916) = 3 %.
      EXPECT_NEAR(seen.translation[0].noise_share, 1.0, 0.12) << "tilt " << tilt << ", copies " << copies;
      EXPECT_LT(seen.translation[1].noise_share, 0.05);
    }
  }
}

TEST(Observability, StandardDeviationsAreThoseOfTheInverse) {
  const ScanInformation information = information_of(box(5.0));
  const Observability seen = analyse_observability(information, {});
  const math::Matrix6d P = information.H.inverse();
  for (const Direction& direction : seen.translation) {
    const double variance = direction.axis.dot(P.bottomRightCorner<3, 3>() * direction.axis);
    EXPECT_NEAR(direction.std, std::sqrt(variance), 1e-9);
  }
}

TEST(Observability, WithoutMatchesEverythingIsWeak) {
  EXPECT_EQ(analyse_observability({}, {}).num_weak(), 6);
}

}  // namespace
}  // namespace mmlins::degeneracy
