// SPDX-License-Identifier: MIT
#include "mmlins/mapping/point_icp.hpp"

#include <gtest/gtest.h>

#include <cmath>

#include "mmlins/math/random.hpp"

namespace mmlins::mapping {
namespace {

using Points = std::vector<Eigen::Vector3f>;

Points scattered(int count, std::uint64_t seed) {
  math::Random random(seed);
  Points points;
  for (int i = 0; i < count; ++i) {
    points.emplace_back(random.uniform(-10.0, 10.0), random.uniform(-10.0, 10.0), random.uniform(-2.0, 2.0));
  }
  return points;
}

Points moved(const Points& points, const math::SE3& T) {
  Points out;
  for (const Eigen::Vector3f& p : points) out.push_back((T * p.cast<double>()).cast<float>());
  return out;
}

TEST(NearestPoint, IsTheOneThatLookingAtAllOfThemFinds) {
  const Points points = scattered(500, 1);
  const NearestPoint nearest(points);
  for (const Eigen::Vector3f& query : scattered(300, 2)) {
    float least = std::numeric_limits<float>::infinity();
    for (const Eigen::Vector3f& p : points) least = std::min(least, (p - query).squaredNorm());
    const NearestPoint::Found found = nearest.find(query);
    EXPECT_EQ(found.distance2, least);
    EXPECT_EQ((found.point - query).squaredNorm(), least);
  }
}

TEST(NearestPoint, OfNoPointsIsInfinitelyFar) {
  EXPECT_TRUE(std::isinf(NearestPoint({}).find({1, 2, 3}).distance2));
}

TEST(PointIcp, FindsHowPointsWereMoved) {
  // Points 1 m apart on average, moved by less than that.
  const Points target = scattered(800, 3);
  const math::SE3 T_target_source{math::so3_exp({0.01, -0.02, 0.03}), {0.2, -0.1, 0.15}};
  const Points source = moved(target, T_target_source.inverse());
  const IcpResult result = register_points(source, NearestPoint(target), {}, {.reach = 5.0});
  EXPECT_TRUE(result.converged);
  const math::Vector6d error = math::se3_log(T_target_source.inverse() * result.T_target_source);
  EXPECT_LT(error.norm(), 1e-5);  // points are floats
  EXPECT_LT(result.fitness, 1e-10);
}

TEST(PointIcp, FitnessIsTheMeanSquaredDistanceOfAllPoints) {
  // Ten points fit exactly; two are 1 m and 3 m from the nearest, and too far away to take part.
  Points target = {{0, 0, 0}, {9, 0, 0}, {0, 7, 0}, {0, 0, 8},  {9, 7, 0},
                   {9, 0, 8}, {0, 7, 8}, {9, 7, 8}, {4, 3, 20}, {5, 20, 3}};
  Points source = target;
  source.emplace_back(-1, 0, 0);
  source.emplace_back(0, -3, 0);
  const IcpResult result = register_points(source, NearestPoint(target), {}, {.reach = 0.5});
  EXPECT_LT(math::se3_log(result.T_target_source).norm(), 1e-6);
  EXPECT_NEAR(result.fitness, 10.0 / 12.0, 1e-6);
}

TEST(PointIcp, DoesNotMoveWithoutPairs) {
  const Points target = scattered(100, 4);
  const math::SE3 far{math::Matrix3d::Identity(), {500.0, 0.0, 0.0}};
  const IcpResult result = register_points(target, NearestPoint(target), far, {.reach = 10.0});
  EXPECT_EQ(result.iterations, 0);
  EXPECT_FALSE(result.converged);
  EXPECT_EQ(result.T_target_source.t, far.t);
}

}  // namespace
}  // namespace mmlins::mapping
