// SPDX-License-Identifier: MIT
#include "mmlins/spatial/plane_map.hpp"

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <numbers>
#include <vector>

#include "mmlins/base/parallel.hpp"
#include "mmlins/math/so3.hpp"
#include "mmlins/sim/random.hpp"

namespace mmlins::spatial {
namespace {

using Eigen::Vector3d;
using Points = std::vector<Vector3d>;

constexpr double kRangeNoise = 0.02;
constexpr double kGate = 1.0;

/// What these tests are about is set here, whatever the defaults are.
PlaneMapConfig one_level(double cell) {
  PlaneMapConfig config;
  config.finest_cell = cell;
  config.num_levels = 1;
  config.reach_in_cells = 1000.0;
  config.offset_noise = 0.0;
  return config;
}

PlaneMapConfig pyramid() {
  PlaneMapConfig config;
  config.finest_cell = 0.25;
  config.num_levels = 4;
  config.reach_in_cells = 100.0;
  return config;
}

/// The plane z = 0 of a frame of its own, placed anywhere.
struct TiltedPlane {
  math::Matrix3d R = math::so3_exp({0.4, -0.7, 0.2});
  Vector3d t{5.0, -3.0, 2.0};

  [[nodiscard]] Vector3d normal() const { return R.col(2); }
  [[nodiscard]] double distance(const Vector3d& point) const { return normal().dot(point - t); }
  [[nodiscard]] Vector3d at(double u, double v, double height) const {
    return R * Vector3d(u, v, height) + t;
  }

  /// Points on a square of edge 2 * `reach`, with noise across it.
  [[nodiscard]] Points sample(int count, double reach, std::uint64_t seed) const {
    sim::Random random(seed);
    Points points;
    for (int i = 0; i < count; ++i) {
      const double u = random.uniform(-reach, reach);
      const double v = random.uniform(-reach, reach);
      points.push_back(at(u, v, kRangeNoise * random.normal()));
    }
    return points;
  }
};

Vector3d viewpoint() { return Vector3d(5.0, -3.0, 6.0); }

TEST(PlaneMap, FindsThePlaneOfManyPointsWithinTheirNoise) {
  const TiltedPlane plane;
  PlaneMap map(one_level(2.0), kRangeNoise);
  map.insert(plane.sample(20000, 5.0, 1), viewpoint());
  sim::Random random(2);
  int found = 0;
  double tilt2 = 0.0;
  for (int i = 0; i < 200; ++i) {
    const Vector3d point = plane.at(random.uniform(-3, 3), random.uniform(-3, 3), 0.05);
    const PlaneMatch match = map.match(point, kGate);
    if (!match.found) continue;  // the corner of a cell that only touches the plane
    ++found;
    EXPECT_NEAR(match.normal.norm(), 1.0, 1e-6);
    const double sign = match.normal.dot(plane.normal()) > 0.0 ? 1.0 : -1.0;
    tilt2 += match.normal.cross(plane.normal()).squaredNorm();
    EXPECT_NEAR(sign * match.distance, plane.distance(point), 5.0 * std::sqrt(match.plane_variance));
  }
  EXPECT_GT(found, 180);
  // Most cells have some 200 points spread by 0.5 m, so a tilt of 0.02 m / sqrt(200) / 0.5 m = 3 mrad about
  // either axis; cells that the plane cuts at an edge are narrower.
  EXPECT_LT(std::sqrt(tilt2 / found), 0.015);
}

TEST(PlaneMap, PlaneVarianceIsThatOfTheErrorsMade) {
  const TiltedPlane plane;
  PlaneMapConfig config = one_level(1.0);
  config.max_points = 1000;
  sim::Random random(3);
  double sum = 0.0;
  int count = 0;
  // Many maps of the same place, each from other noise.
  for (std::uint64_t seed = 0; seed < 200; ++seed) {
    PlaneMap map(config, kRangeNoise);
    map.insert(plane.sample(400, 1.5, 100 + seed), viewpoint());
    const Vector3d point = plane.at(random.uniform(-1, 1), random.uniform(-1, 1), 0.0);
    const PlaneMatch match = map.match(point, kGate);
    if (!match.found) continue;
    sum += match.distance * match.distance / match.plane_variance;
    ++count;
  }
  ASSERT_GT(count, 150);
  // A mean of n squares of normal numbers deviates by sqrt(2/n) = 0.1. The surface's variance is never taken
  // below that of the range, although a fit makes it up to a tenth smaller: that alone may lower the mean.
  EXPECT_NEAR(sum / count, 1.0, 0.4);
}

TEST(PlaneMap, SurfaceVarianceIsThatOfRoughSurfacesAndNeverBelowTheRangeNoise) {
  const TiltedPlane plane;
  const Points points = plane.sample(20000, 5.0, 4);
  for (const double range_noise : {0.005, 0.05}) {
    PlaneMapConfig config = one_level(2.0);
    config.max_thickness = 0.2;
    config.min_width_sigmas = 1.0;
    PlaneMap map(config, range_noise);
    map.insert(points, viewpoint());
    const PlaneMatch match = map.match(plane.at(0.1, 0.2, 0.0), kGate);
    ASSERT_TRUE(match.found);
    // At least 50 points in the cell: their variance is known to a fifth, three times that.
    const double expected = std::max(range_noise, kRangeNoise);
    EXPECT_NEAR(match.surface_variance / (expected * expected), 1.0, 0.6);
    EXPECT_GE(match.surface_variance, 0.999 * range_noise * range_noise);
  }
}

/// Points of one turn of one laser over the plane z = -1.5 below it, with noise along the beams.
Points ring_on_floor(double elevation_deg, std::uint64_t seed) {
  sim::Random random(seed);
  const double elevation = elevation_deg * std::numbers::pi / 180.0;
  Points points;
  for (double azimuth = 0.0; azimuth < 2.0 * std::numbers::pi; azimuth += 0.002) {
    const Vector3d beam(std::cos(elevation) * std::cos(azimuth), std::cos(elevation) * std::sin(azimuth),
                        std::sin(elevation));
    points.push_back(beam * (1.5 / -beam.z() + kRangeNoise * random.normal()));
  }
  return points;
}

int count_matches(const PlaneMap& map, const Points& points) {
  int count = 0;
  for (const Vector3d& point : points) count += map.match(point, kGate).found;
  return count;
}

TEST(PlaneMap, ASingleRingIsNoPlane) {
  const Points ring = ring_on_floor(-15.0, 5);
  const auto matches_with = [&](double min_width_sigmas) {
    PlaneMapConfig config = one_level(0.5);
    config.min_width_sigmas = min_width_sigmas;
    config.min_incidence_deg = 0.0;
    PlaneMap map(config, kRangeNoise);
    map.insert(ring, Vector3d::Zero());
    return count_matches(map, ring);
  };
  // In a cell of 0.5 m an arc of 5.6 m radius departs from its chord by 6 mm: that is no width either.
  EXPECT_EQ(matches_with(3.0), 0);
  // Without the rule the cone that the beam sweeps would pass for a wall nearly everywhere.
  EXPECT_GT(matches_with(0.0), static_cast<int>(ring.size() / 2));
}

TEST(PlaneMap, SeveralRingsAreTheFloorAndNotTheConeOfTheBeams) {
  PlaneMapConfig config = one_level(0.5);
  config.min_width_sigmas = 3.0;
  PlaneMap map(config, kRangeNoise);
  for (int i = 0; i < 16; ++i) {
    map.insert(ring_on_floor(-15.0 - 0.2 * i, 6 + static_cast<std::uint64_t>(i)), Vector3d::Zero());
  }
  const Points ring = ring_on_floor(-15.5, 5);
  EXPECT_GT(count_matches(map, ring), static_cast<int>(ring.size() / 2));
  for (const Vector3d& point : ring) {
    const PlaneMatch match = map.match(point, kGate);
    // Noise along beams that hit at 15 degrees is 5 mm across the floor; cells are 0.5 m wide.
    EXPECT_TRUE(!match.found || std::abs(match.normal.z()) > 0.99) << match.normal.transpose();
  }
}

/// Points of one turn of one laser in the corner of the walls x = 6 and y = 5, seen from the origin.
Points ring_in_a_corner(double elevation_deg, std::uint64_t seed) {
  sim::Random random(seed);
  const double elevation = elevation_deg * std::numbers::pi / 180.0;
  Points points;
  for (double azimuth = 0.2; azimuth < 1.3; azimuth += 0.002) {
    const Vector3d beam(std::cos(elevation) * std::cos(azimuth), std::cos(elevation) * std::sin(azimuth),
                        std::sin(elevation));
    const double range = std::min(6.0 / beam.x(), 5.0 / beam.y());
    points.push_back(beam * (range + kRangeNoise * random.normal()));
  }
  return points;
}

TEST(PlaneMap, ASingleRingRoundACornerIsNoPlaneThoughItIsFlatAndWide) {
  const Points ring = ring_in_a_corner(5.0, 11);
  const auto matches_across = [&](double min_incidence_deg) {
    PlaneMapConfig config = one_level(2.0);
    config.min_incidence_deg = min_incidence_deg;
    PlaneMap map(config, kRangeNoise);
    map.insert(ring, Vector3d::Zero());
    int count = 0;
    for (const Vector3d& point : ring) {
      const PlaneMatch match = map.match(point, kGate);
      count += match.found && std::abs(match.normal.z()) > 0.9;
    }
    return count;
  };
  EXPECT_EQ(matches_across(2.0), 0);
  // Without the rule a level surface that is not there would hold the sensor at its height and tilt.
  EXPECT_GT(matches_across(0.0), 50);
}

TEST(PlaneMap, PointsBeyondTheGateHaveNoMatch) {
  const TiltedPlane plane;
  PlaneMap map(one_level(2.0), kRangeNoise);
  map.insert(plane.sample(20000, 5.0, 7), viewpoint());
  EXPECT_TRUE(map.match(plane.at(0, 0, 0.08), 0.1).found);
  EXPECT_FALSE(map.match(plane.at(0, 0, 0.12), 0.1).found);
  EXPECT_FALSE(map.match(plane.at(50, 0, 0.0), 0.1).found);
}

TEST(PlaneMap, PointsOfOneCellShareAPlaneAndOthersDoNot) {
  const TiltedPlane plane;
  PlaneMap map(one_level(2.0), kRangeNoise);
  map.insert(plane.sample(20000, 5.0, 8), viewpoint());
  const PlaneMatch a = map.match(plane.at(0.0, 0.0, 0.0), kGate);
  const PlaneMatch near_a = map.match(plane.at(1e-4, 0.0, 0.0), kGate);
  const PlaneMatch b = map.match(plane.at(3.9, 0.0, 0.0), kGate);
  ASSERT_TRUE(a.found && near_a.found && b.found);
  EXPECT_EQ(a.plane_id, near_a.plane_id);
  EXPECT_NE(a.plane_id, b.plane_id);
}

/// A corridor seen while driving along it: walls, floor and clutter.
Points corridor_around(double x, std::uint64_t seed) {
  sim::Random random(seed);
  Points points;
  for (int i = 0; i < 500; ++i) {
    const double along = x + random.uniform(-15.0, 15.0);
    points.emplace_back(along, random.chance(0.5) ? 2.0 : -2.0, random.uniform(0.0, 3.0));
    points.emplace_back(along, random.uniform(-2.0, 2.0), 0.0);
    points.emplace_back(along, random.uniform(-2.0, 2.0), random.uniform(0.0, 3.0));
  }
  return points;
}

TEST(PlaneMap, EvictionBoundsTheNumberOfCells) {
  PlaneMap map(pyramid(), kRangeNoise);
  std::size_t early = 0;
  std::size_t late = 0;
  for (int step = 0; step < 400; ++step) {
    const Vector3d position(step, 0.0, 1.0);
    map.insert(corridor_around(step, 1000 + static_cast<std::uint64_t>(step)), position);
    map.evict_beyond(position, 20.0);
    // 50 m is longer than what is kept: from then on as much goes as comes.
    if (step >= 50 && step < 150) early = std::max(early, map.num_cells());
    if (step >= 300) late = std::max(late, map.num_cells());
  }
  EXPECT_LT(static_cast<double>(late), 1.05 * static_cast<double>(early));
}

TEST(PlaneMap, EvictionKeepsWhatIsNearAndForgetsWhatIsFar) {
  const TiltedPlane plane;
  PlaneMap map(pyramid(), kRangeNoise);
  map.insert(plane.sample(20000, 5.0, 9), viewpoint());
  for (int i = 0; i < 8; ++i) map.evict_beyond(viewpoint(), 20.0);  // a level at a time
  EXPECT_TRUE(map.match(plane.at(0, 0, 0), kGate).found);
  for (int i = 0; i < 8; ++i) map.evict_beyond(Vector3d(100, 0, 0), 20.0);
  EXPECT_EQ(map.num_cells(), 0U);
  EXPECT_FALSE(map.match(plane.at(0, 0, 0), kGate).found);
}

TEST(PlaneMap, GivesTheSameBitsWhateverTheNumberOfThreads) {
  const auto matches_with = [](int threads) {
    parallel::set_num_threads(threads);
    PlaneMap map(pyramid(), kRangeNoise);
    for (int step = 0; step < 10; ++step) {
      map.insert(corridor_around(step, static_cast<std::uint64_t>(step)), Vector3d(step, 0, 1));
      map.evict_beyond(Vector3d(step, 0, 1), 12.0);
    }
    std::vector<PlaneMatch> matches;
    for (const Vector3d& point : corridor_around(9.0, 77)) matches.push_back(map.match(point, 0.3));
    parallel::set_num_threads(0);
    return matches;
  };
  const auto one = matches_with(1);
  const auto four = matches_with(4);
  int found = 0;
  for (std::size_t i = 0; i < one.size(); ++i) {
    ASSERT_EQ(one[i].found, four[i].found);
    if (!one[i].found) continue;
    ++found;
    EXPECT_EQ(one[i].plane_id, four[i].plane_id);
    EXPECT_EQ(one[i].normal, four[i].normal);
    EXPECT_EQ(one[i].distance, four[i].distance);
    EXPECT_EQ(one[i].surface_variance, four[i].surface_variance);
    EXPECT_EQ(one[i].plane_variance, four[i].plane_variance);
  }
  EXPECT_GT(found, 100);
}

TEST(PlaneMap, PrecisionDoesNotDependOnTheDistanceFromTheOrigin) {
  // Moments are kept in single precision, which at 2 km resolves only 0.1 mm.
  const TiltedPlane here;
  TiltedPlane there = here;
  there.t += Vector3d(2000.0, -1500.0, 100.0);
  PlaneMap map(one_level(2.0), kRangeNoise);
  map.insert(there.sample(20000, 5.0, 10), there.at(0.0, 0.0, 4.0));
  const Vector3d point = there.at(0.3, 0.3, 0.05);
  const PlaneMatch match = map.match(point, kGate);
  ASSERT_TRUE(match.found);
  EXPECT_NEAR(std::abs(match.distance), 0.05, 5.0 * std::sqrt(match.plane_variance));
  EXPECT_LT(match.normal.cross(there.normal()).norm(), 0.03);
}

TEST(PlaneMap, AnEmptyMapMatchesNothing) {
  const PlaneMap map(pyramid(), kRangeNoise);
  EXPECT_FALSE(map.match(Vector3d::Zero(), kGate).found);
  EXPECT_EQ(map.num_cells(), 0U);
}

}  // namespace
}  // namespace mmlins::spatial
