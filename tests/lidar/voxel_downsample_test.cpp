// SPDX-License-Identifier: MIT
#include "mmlins/lidar/voxel_downsample.hpp"

#include <gtest/gtest.h>

#include <array>
#include <cmath>
#include <map>

#include "mmlins/sim/random.hpp"

namespace mmlins::lidar {
namespace {

// A power of two, so that dividing by it is exact and the test's cells are those of the code.
constexpr double kLeaf = 0.5;

Cloud random_cloud(int count) {
  sim::Random random(1);
  Cloud cloud;
  for (int i = 0; i < count; ++i) {
    cloud.points.push_back(random.normal3().cast<float>());
    cloud.source.push_back(static_cast<std::uint32_t>(7 * i));
  }
  return cloud;
}

/// The plain way: an ordered map from cells to the first point in each.
std::vector<std::uint32_t> first_of_each_cell(const Cloud& cloud) {
  std::map<std::array<int, 3>, bool> seen;
  std::vector<std::uint32_t> sources;
  for (std::size_t i = 0; i < cloud.size(); ++i) {
    const auto cell = [&](int axis) { return static_cast<int>(std::floor(cloud.points[i][axis] / kLeaf)); };
    if (!seen.emplace(std::array{cell(0), cell(1), cell(2)}, true).second) continue;
    sources.push_back(cloud.source[i]);
  }
  return sources;
}

TEST(VoxelDownsample, KeepsTheFirstPointOfEachCellInOrder) {
  const Cloud cloud = random_cloud(5000);
  const Cloud kept = voxel_downsample(cloud, kLeaf);
  EXPECT_EQ(kept.source, first_of_each_cell(cloud));
  EXPECT_LT(kept.size(), cloud.size() / 2);
  for (std::size_t i = 0; i < kept.size(); ++i) EXPECT_EQ(kept.points[i], cloud.points[kept.source[i] / 7]);
}

TEST(VoxelDownsample, AThinnedCloudStaysAsItIs) {
  const Cloud once = voxel_downsample(random_cloud(5000), kLeaf);
  EXPECT_EQ(voxel_downsample(once, kLeaf).source, once.source);
}

TEST(VoxelDownsample, CellsOnBothSidesOfTheOriginAreDifferent) {
  Cloud cloud;
  for (const float x : {-0.1F, 0.1F}) {
    for (const float y : {-0.1F, 0.1F}) {
      for (const float z : {-0.1F, 0.1F}) cloud.points.emplace_back(x, y, z);
    }
  }
  cloud.source.resize(8);
  EXPECT_EQ(voxel_downsample(cloud, kLeaf).size(), 8U);
}

TEST(VoxelDownsample, ManyPointsInOneCellLeaveOne) {
  Cloud cloud;
  cloud.points.assign(1000, Eigen::Vector3f(0.2F, 0.2F, 0.2F));
  cloud.source.resize(1000);
  EXPECT_EQ(voxel_downsample(cloud, kLeaf).size(), 1U);
  EXPECT_EQ(voxel_downsample(Cloud{}, kLeaf).size(), 0U);
}

/// Points on a square of 20 m: a surface, as scans see them.
Cloud surface() {
  sim::Random random(2);
  Cloud cloud;
  for (int i = 0; i < 100000; ++i) {
    cloud.points.emplace_back(static_cast<float>(random.uniform(-10, 10)),
                              static_cast<float>(random.uniform(-10, 10)), 0);
    cloud.source.push_back(static_cast<std::uint32_t>(i));
  }
  return cloud;
}

TEST(AdaptLeaf, BringsASurfaceToTheTargetInAFewScans) {
  const Cloud cloud = surface();
  constexpr std::size_t kTarget = 2000;
  double leaf = 1.0;
  std::size_t count = 0;
  for (int scan = 0; scan < 4; ++scan) {
    count = voxel_downsample(cloud, leaf).size();
    leaf = adapt_leaf(leaf, count, kTarget, {0.01, 10.0});
  }
  // Whole cells only and cells cut by the edge: 90 by 90 half-cells of 0.45 m would already miss by 5 %.
  EXPECT_NEAR(static_cast<double>(count), kTarget, 0.1 * kTarget);
}

TEST(AdaptLeaf, MorePointsThanWantedMakeItLargerFewerSmaller) {
  const LeafLimits limits{0.01, 10.0};
  EXPECT_GT(adapt_leaf(0.3, 3000, 2000, limits), 0.3);
  EXPECT_LT(adapt_leaf(0.3, 1000, 2000, limits), 0.3);
  EXPECT_DOUBLE_EQ(adapt_leaf(0.3, 2000, 2000, limits), 0.3);
}

TEST(AdaptLeaf, StaysWithinItsLimitsEvenWithoutPoints) {
  const LeafLimits limits{0.1, 1.0};
  EXPECT_EQ(adapt_leaf(0.3, 0, 2000, limits), 0.1);
  EXPECT_EQ(adapt_leaf(0.3, 1000000, 2000, limits), 1.0);
}

}  // namespace
}  // namespace mmlins::lidar
