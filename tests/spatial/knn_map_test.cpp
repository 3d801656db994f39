// SPDX-License-Identifier: MIT
#include "mmlins/spatial/knn_map.hpp"

#include <gtest/gtest.h>

#include <cmath>
#include <vector>

#include "mmlins/math/so3.hpp"
#include "mmlins/sim/random.hpp"

namespace mmlins::spatial {
namespace {

using Eigen::Vector3d;
using Points = std::vector<Vector3d>;

constexpr double kGate = 1.0;

KnnMapConfig config() {
  KnnMapConfig config;
  config.cell = 0.5;
  config.min_spacing = 0.1;
  config.max_neighbour_distance = 1.0;
  config.max_plane_error = 0.1;
  return config;
}

const math::Matrix3d kR = math::so3_exp({0.4, -0.7, 0.2});

/// A point of a tilted plane through the origin, lifted off it by `height`.
Vector3d on_plane(double u, double v, double height = 0.0) { return kR * Vector3d(u, v, height); }

Points plane_points(int count) {
  sim::Random random(1);
  Points points;
  for (int i = 0; i < count; ++i) points.push_back(on_plane(random.uniform(-5, 5), random.uniform(-5, 5)));
  return points;
}

TEST(KnnMap, FindsAnExactPlaneExactly) {
  KnnMap map(config(), 0.02);
  map.insert(plane_points(20000), Vector3d::Zero());
  sim::Random random(2);
  for (int i = 0; i < 100; ++i) {
    const PlaneMatch match = map.match(on_plane(random.uniform(-4, 4), random.uniform(-4, 4), 0.07), kGate);
    ASSERT_TRUE(match.found);
    // The direct eigenvalue solver keeps about half of the digits.
    EXPECT_LT(match.normal.cross(kR.col(2)).norm(), 1e-5);
    EXPECT_NEAR(std::abs(match.distance), 0.07, 1e-5);
  }
}

TEST(KnnMap, PointsTooCloseToAnotherAreNotStored) {
  KnnMap map(config(), 0.02);
  // Five points would make a plane, but these lie within the spacing of the first.
  Points cluster;
  for (int i = 0; i < 50; ++i) cluster.emplace_back(1.0 + 1e-3 * i, 1.0 + 5e-4 * (i % 7), 1.0);
  map.insert(cluster, Vector3d::Zero());
  EXPECT_FALSE(map.match(Vector3d(1.0, 1.0, 1.0), kGate).found);
}

TEST(KnnMap, ScatteredPointsAreNoPlane) {
  sim::Random random(3);
  Points points;
  for (int i = 0; i < 3000; ++i) {
    points.emplace_back(random.uniform(-3, 3), random.uniform(-3, 3), random.uniform(-3, 3));
  }
  KnnMapConfig strict = config();
  strict.max_plane_error = 0.002;
  KnnMap map(strict, 0.02);
  map.insert(points, Vector3d::Zero());
  int found = 0;
  for (int i = 0; i < 500; ++i) found += map.match(points[static_cast<std::size_t>(i)], kGate).found;
  // Five points within 0.4 m of each other lie within 2 mm of a plane in some hundredths of all cases.
  EXPECT_LT(found, 50);
}

TEST(KnnMap, PointsBeyondTheGateOrFarFromEverythingHaveNoMatch) {
  KnnMap map(config(), 0.02);
  map.insert(plane_points(20000), Vector3d::Zero());
  EXPECT_TRUE(map.match(on_plane(0, 0, 0.08), 0.1).found);
  EXPECT_FALSE(map.match(on_plane(0, 0, 0.12), 0.1).found);
  EXPECT_FALSE(map.match(on_plane(20, 0), kGate).found);
}

TEST(KnnMap, EvictionBoundsTheNumberOfCellsAndKeepsWhatIsNear) {
  KnnMap map(config(), 0.02);
  sim::Random random(4);
  std::size_t early = 0;
  std::size_t late = 0;
  for (int step = 0; step < 400; ++step) {
    Points points;
    for (int i = 0; i < 500; ++i)
      points.emplace_back(step + random.uniform(-15, 15), random.uniform(-3, 3), 0.0);
    map.insert(points, Vector3d(step, 0, 1));
    map.evict_beyond(Vector3d(step, 0, 1), 20.0);
    if (step >= 50 && step < 150) early = std::max(early, map.num_cells());
    if (step >= 300) late = std::max(late, map.num_cells());
  }
  EXPECT_LT(static_cast<double>(late), 1.05 * static_cast<double>(early));
  EXPECT_TRUE(map.match(Vector3d(399.0, 0.0, 0.0), kGate).found);
}

}  // namespace
}  // namespace mmlins::spatial
