// SPDX-License-Identifier: MIT
#include "mmlins/sim/world.hpp"

#include <gtest/gtest.h>

#include <cmath>
#include <numbers>

#include "mmlins/math/numerical_jacobian.hpp"
#include "mmlins/sim/random.hpp"

namespace mmlins::sim {
namespace {

using Eigen::Vector3d;

constexpr double kFar = 500.0;  // [m]

Ray ray(const Vector3d& origin, const Vector3d& towards) { return {origin, (towards - origin).normalized()}; }

Vector3d random_place(Random& random, double half_size) {
  const double x = random.uniform(-half_size, half_size);
  const double y = random.uniform(-half_size, half_size);
  return {x, y, random.uniform(-half_size, half_size)};
}

std::vector<Shape> random_shapes(int count, double half_size) {
  Random random(3);
  std::vector<Shape> shapes;
  for (int i = 0; i < count; ++i) {
    const Vector3d place = random_place(random, half_size);
    if (random.chance(0.5)) {
      const Vector3d size = random_place(random, 4.0).cwiseAbs() + Vector3d::Constant(0.05);
      shapes.push_back(make_box(place, size, random.uniform(-3.0, 3.0), 0.5));
    } else {
      shapes.push_back(make_cylinder(place, random.uniform(0.05, 2.0), random.uniform(0.2, 8.0), 0.5));
    }
  }
  return shapes;
}

TEST(Shape, BoxIsHitAtTheDistanceOfItsTurnedFace) {
  // Turned by 30 degrees: its front face is 1 m in front of the centre, along the turned axis.
  const double yaw = std::numbers::pi / 6.0;
  const Shape box = make_box({10, 0, 1}, {2, 4, 3}, yaw, 0.5);
  const Vector3d axis(std::cos(yaw), std::sin(yaw), 0.0);
  const Vector3d origin = box.center - 7.5 * axis;
  const auto hit = intersect(box, {origin, axis});
  ASSERT_TRUE(hit.has_value());
  EXPECT_NEAR(hit->range, 6.5, 1e-12);
  EXPECT_EQ(hit->face, 0);
  EXPECT_FALSE(intersect(box, {origin, -axis}).has_value());
  // A slanted ray: range = distance to the plane / cosine.
  const Vector3d slanted = Eigen::AngleAxisd(0.1, Vector3d::UnitZ()) * axis;
  EXPECT_NEAR(intersect(box, {origin, slanted})->range, 6.5 / std::cos(0.1), 1e-12);
}

TEST(Shape, CylinderIsHitOnItsSideAndOnItsTop) {
  const Shape pole = make_cylinder({5, 2, 0}, 0.5, 3.0, 0.5);
  EXPECT_NEAR(intersect(pole, {{0, 2, 1}, {1, 0, 0}})->range, 4.5, 1e-12);
  // Off the middle by 0.3: half the chord is 0.4.
  EXPECT_NEAR(intersect(pole, {{0, 2.3, 1}, {1, 0, 0}})->range, 4.6, 1e-12);
  EXPECT_FALSE(intersect(pole, {{0, 2.6, 1}, {1, 0, 0}}).has_value());
  EXPECT_NEAR(intersect(pole, {{5.1, 2.1, 8}, {0, 0, -1}})->range, 5.0, 1e-12);
}

TEST(Bvh, FindsTheSameShapeAsTryingAll) {
  const std::vector<Shape> shapes = random_shapes(300, 40.0);
  const Bvh bvh(shapes);
  Random random(4);
  int num_hits = 0;
  for (int i = 0; i < 5000; ++i) {
    const Ray shot = ray(random_place(random, 45.0), random_place(random, 45.0));
    double nearest = kFar;
    for (const Shape& shape : shapes) {
      const auto hit = intersect(shape, shot);
      if (hit) nearest = std::min(nearest, hit->range);
    }
    const auto found = bvh.first_hit(shot, kFar);
    EXPECT_EQ(found ? found->range : kFar, nearest);
    num_hits += found.has_value();
  }
  EXPECT_GT(num_hits, 1000);  // otherwise nothing was compared
}

TEST(ShapeWorld, EvenGroundAndWallsAreHitAtTheirClosedFormDistances) {
  const ShapeWorld world({make_box({20, 0, 5}, {2, 40, 12}, 0.0, 0.5)}, {});
  EXPECT_NEAR(world.cast({{0, 0, 1.5}, {1, 0, 0}}, kFar)->range, 19.0, 1e-9);
  const double down = 0.3;  // [rad]
  const auto ground = world.cast({{0, 0, 1.5}, {std::cos(down), 0, -std::sin(down)}}, kFar);
  EXPECT_NEAR(ground->range, 1.5 / std::sin(down), 1e-9);
  EXPECT_NEAR(ground->normal.z(), 1.0, 1e-12);
  EXPECT_FALSE(world.cast({{0, 0, 1.5}, {-1, 0, 0.01}}, kFar).has_value());
  EXPECT_FALSE(world.cast({{0, 0, 1.5}, {1, 0, 0}}, 18.0).has_value());
}

TEST(ShapeWorld, HitsLieOnTheUnevenSurfaces) {
  const ShapeWorld world(random_shapes(200, 30.0), {0.012, 0.05, 9});
  Random random(5);
  int num_hits = 0;
  for (int i = 0; i < 5000; ++i) {
    Vector3d origin = random_place(random, 30.0);
    origin.z() = std::abs(origin.z()) + 0.5;
    const Ray shot = ray(origin, random_place(random, 30.0));
    const auto hit = world.cast(shot, kFar);
    if (!hit) continue;
    ++num_hits;
    EXPECT_LT(std::abs(world.distance(shot.origin + hit->range * shot.direction, hit->surface)), 1e-6);
    EXPECT_LT(hit->normal.dot(shot.direction), 0.0);
  }
  EXPECT_GT(num_hits, 2000);
}

// The unevenness is geometry: the same place is the same from wherever it is seen.
TEST(ShapeWorld, TheSamePlaceLooksTheSameFromElsewhere) {
  const ShapeWorld world({make_box({20, 0, 5}, {2, 60, 12}, 0.2, 0.5)}, {0.012, 0.05, 9});
  Random random(6);
  for (int i = 0; i < 200; ++i) {
    const Vector3d first(0, random.uniform(-5, 5), 2);
    const Ray shot = ray(first, {19, random.uniform(-15, 15), random.uniform(0.5, 8)});
    const auto hit = world.cast(shot, kFar);
    if (!hit) continue;
    const Vector3d place = shot.origin + hit->range * shot.direction;
    const Ray again = ray({4, random.uniform(-8, 8), 3}, place);
    const auto second = world.cast(again, kFar);
    ASSERT_TRUE(second.has_value());
    EXPECT_LT((again.origin + second->range * again.direction - place).norm(), 1e-6);
  }
}

TEST(Relief, GradientIsTheDerivativeOfTheHeight) {
  const Relief relief({0.01, 1.0, 3.0, false}, 8);
  Random random(7);
  for (int i = 0; i < 100; ++i) {
    const Vector3d p = random_place(random, 100.0);
    const auto height = [&](const Eigen::VectorXd& x) {
      return Eigen::VectorXd::Constant(1, relief.at(x).height);
    };
    const Eigen::MatrixXd numeric = math::numerical_jacobian(height, p);
    EXPECT_LT((numeric.transpose() - relief.at(p).gradient).norm(), 1e-6);
  }
}

TEST(Relief, HeightHasTheDeclaredDeviation) {
  const Relief relief({0.01, 1.0, 3.0, false}, 8);
  Random random(9);
  constexpr int kNumPlaces = 20'000;  // the deviation of a bounded height scatters by less than 1 %
  double sum = 0.0;
  double square = 0.0;
  for (int i = 0; i < kNumPlaces; ++i) {
    const double height = relief.at(random_place(random, 200.0)).height;
    sum += height;
    square += height * height;
  }
  EXPECT_NEAR(sum / kNumPlaces, 0.0, 3e-4);
  EXPECT_NEAR(std::sqrt(square / kNumPlaces), 0.01, 3e-4);
}

}  // namespace
}  // namespace mmlins::sim
