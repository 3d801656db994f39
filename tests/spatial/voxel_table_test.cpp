// SPDX-License-Identifier: MIT
#include "mmlins/spatial/voxel_table.hpp"

#include <gtest/gtest.h>

#include <array>
#include <map>

#include "mmlins/sim/random.hpp"

namespace mmlins::spatial {
namespace {

CellIndex random_index(sim::Random& random, int reach) {
  const auto part = [&] { return static_cast<int>(random.uniform(-reach, reach)); };
  return {part(), part(), part()};
}

std::array<int, 3> key_of(const CellIndex& index) { return {index.x(), index.y(), index.z()}; }

TEST(VoxelTable, FindsWhatWasAddedAndNothingElse) {
  VoxelTable<int> table(0.5);
  std::map<std::array<int, 3>, int> expected;
  sim::Random random(1);
  for (int i = 0; i < 20000; ++i) {
    // Many repetitions, and enough cells to grow the table several times.
    const CellIndex index = random_index(random, 15);
    ++table.payloads()[table.find_or_add(index)];
    ++expected[key_of(index)];
  }
  EXPECT_EQ(table.payloads().size(), expected.size());
  for (int i = 0; i < 5000; ++i) {
    const CellIndex index = random_index(random, 20);
    const auto found = expected.find(key_of(index));
    const std::int64_t id = table.find(index);
    ASSERT_EQ(id >= 0, found != expected.end());
    if (id < 0) continue;
    EXPECT_EQ(table.payloads()[static_cast<std::size_t>(id)], found->second);
  }
}

TEST(VoxelTable, KeepsExactlyTheCellsThatItIsToldTo) {
  VoxelTable<int> table(1.0);
  for (int x = -50; x < 50; ++x) {
    for (int y = -50; y < 50; ++y) table.payloads()[table.find_or_add({x, y, -x})] = x * y;
  }
  table.keep_if([](const CellIndex& index, int payload) {
    EXPECT_EQ(payload, index.x() * index.y());
    return index.x() >= 10 && payload % 2 == 0;
  });
  for (int x = -50; x < 50; ++x) {
    for (int y = -50; y < 50; ++y) {
      const std::int64_t id = table.find({x, y, -x});
      ASSERT_EQ(id >= 0, x >= 10 && x * y % 2 == 0) << x << ' ' << y;
      if (id < 0) continue;
      EXPECT_EQ(table.payloads()[static_cast<std::size_t>(id)], x * y);
    }
  }
  // It can be filled again.
  const std::uint32_t again = table.find_or_add({-50, 0, 50});
  EXPECT_EQ(table.find({-50, 0, 50}), again);
}

TEST(VoxelTable, PointsLieInTheirCells) {
  const VoxelTable<int> table(0.3);
  sim::Random random(2);
  for (int i = 0; i < 1000; ++i) {
    const Eigen::Vector3d point = 100.0 * random.normal3();
    const Eigen::Vector3d from_centre = point - table.centre_of(table.index_of(point));
    EXPECT_LE(from_centre.cwiseAbs().maxCoeff(), 0.15 + 1e-9);
  }
}

TEST(VoxelTable, IndicesFarFromTheOriginStayApart) {
  VoxelTable<int> table(1.0);
  constexpr int kFar = 1000000;
  for (const int x : {-kFar, kFar}) {
    for (const int y : {-kFar, kFar}) {
      for (const int z : {-kFar, kFar}) table.find_or_add({x, y, z});
    }
  }
  EXPECT_EQ(table.payloads().size(), 8U);
}

}  // namespace
}  // namespace mmlins::spatial
