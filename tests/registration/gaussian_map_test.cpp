// SPDX-License-Identifier: MIT
#include "mmlins/registration/gaussian_map.hpp"

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>

#include "tests/registration/drawn_submaps.hpp"

namespace mmlins::registration {
namespace {

using math::Vector3d;

GaussianMap map_of(const Points& points, double cell_size) {
  std::vector<Eigen::Vector3f> single;
  for (const Vector3d& p : points) single.push_back(p.cast<float>());
  return {single, cell_size, SurfaceConfig{}};
}

TEST(GaussianMap, GivesTheDistanceFromAWall) {
  Points points;
  add_wall(points, {-5, 2}, {5, 2});
  const GaussianMap map = map_of(points, 1.0);
  const auto match = map.match({0.3, 1.8, 0.4}, 1.0, 0.5);
  ASSERT_TRUE(match.has_value());
  EXPECT_EQ(match->cell->num_thin, 1);
  EXPECT_NEAR(match->distance, 0.2, 1e-5);  // single precision
  EXPECT_NEAR(std::abs(match->cell->axes.col(0).y()), 1.0, 1e-5);
}

TEST(GaussianMap, FindsNothingBeyondTheGateOrBeyondTheEndOfAWall) {
  Points points;
  add_wall(points, {-5, 2}, {5, 2});
  const GaussianMap map = map_of(points, 1.0);
  EXPECT_FALSE(map.match({0.3, 1.5, 0.4}, 0.4, 1.0).has_value());
  EXPECT_FALSE(map.match({8.0, 2.0, 0.4}, 1.0, 1.0).has_value());
}

TEST(GaussianMap, APoleHoldsAcrossButNotAlong) {
  Points points;
  for (double z = 0.0; z < 3.0; z += 0.1) points.emplace_back(1.0, 2.0, z);
  const GaussianMap map = map_of(points, 1.0);
  const auto match = map.match({1.1, 2.0, 1.4}, 1.0, 0.5);
  ASSERT_TRUE(match.has_value());
  EXPECT_EQ(match->cell->num_thin, 2);
  EXPECT_NEAR(match->distance, 0.1, 1e-5);
}

// A scanner draws circles on the ground; taken for edges, they would hold a pose that nothing holds.
TEST(GaussianMap, ALineThatLiesIsNoSurface) {
  Points points;
  for (double x = 0.0; x < 10.0; x += 0.1) points.emplace_back(x, 2.0, 0.0);
  EXPECT_FALSE(map_of(points, 1.0).match({5.0, 2.0, 0.0}, 1.0, 1.0).has_value());
}

TEST(GaussianMap, PointsAllOverACellAreNoSurface) {
  math::Random random(3);
  Points points;
  for (int i = 0; i < 3000; ++i)
    points.emplace_back(3 * random.uniform(), 3 * random.uniform(), 3 * random.uniform());
  const GaussianMap map = map_of(points, 1.0);
  for (const SurfaceCell& cell : map.cells()) {
    // Few points may be flat by chance; of more than forty at least some are anywhere.
    EXPECT_TRUE(cell.num_points <= 40 || cell.num_thin == 0);
  }
}

/// What match() promises, by the book.
const SurfaceCell* nearest_of_all(const GaussianMap& map, const Vector3d& point, double gate) {
  const SurfaceCell* best = nullptr;
  double least = gate * gate;
  for (const SurfaceCell& cell : map.cells()) {
    const Vector3d d = cell.axes.transpose() * (point - cell.mean);
    const double across = d.head(cell.num_thin).norm(), along = d.tail(3 - cell.num_thin).norm();
    const double beyond = std::max(0.0, along - 0.75 * map.cell_size());
    const double cost = across * across + beyond * beyond;
    if (cost >= least) continue;
    least = cost;
    best = &cell;
  }
  return best;
}

// A cell farther off than its neighbours begins a cell away, a quarter of one beyond the end of its surface:
// with a gate of less than that, only neighbours can match.
TEST(GaussianMap, FindsAmongNeighboursWhatALookAtAllSurfacesFinds) {
  const GaussianMap map(drawn_submap(drawn_room(), {}, 0.01, 1).points, 1.0, {});
  math::Random random(7);
  int matched = 0;
  for (int i = 0; i < 3000; ++i) {
    const Vector3d point(random.uniform(-12, 12), random.uniform(-12, 12), random.uniform(-3, 5));
    const auto match = map.match(point, 0.2, 1.0);
    const SurfaceCell* nearest = nearest_of_all(map, point, 0.2);
    ASSERT_EQ(match ? match->cell : nullptr, nearest) << point.transpose();
    matched += nearest != nullptr ? 1 : 0;
  }
  EXPECT_GT(matched, 100);
}

TEST(GaussianMap, KnowsTheCellOfEachOfItsSurfaces) {
  const GaussianMap map(drawn_submap(drawn_room(), {}, 0.01, 1).points, 1.0, {});
  ASSERT_GT(map.cells().size(), 100U);
  for (const SurfaceCell& cell : map.cells()) EXPECT_EQ(map.at(cell.mean), &cell);
  EXPECT_EQ(map.at({500, 500, 0}), nullptr);
}

}  // namespace
}  // namespace mmlins::registration
