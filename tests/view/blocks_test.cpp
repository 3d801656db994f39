// SPDX-License-Identifier: MIT
#include "mmlins/view/blocks.hpp"

#include <gtest/gtest.h>

namespace mmlins::view {
namespace {

std::vector<atlas::KeyframeRow> rows(int count, int num_points, double step = 1.0) {
  std::vector<atlas::KeyframeRow> all;
  for (int id = 0; id < count; ++id) {
    atlas::KeyframeRow row;
    row.id = id;
    row.num_points = num_points;
    row.T_map_imu.t.x() = step * id;
    all.push_back(row);
  }
  return all;
}

TEST(Blocks, EveryKeyframeAndPointIsInOneBlock) {
  const auto blocks = make_blocks(rows(100, 7000));
  int next = 0;
  std::int64_t num_points = 0;
  for (const Block& block : blocks) {
    EXPECT_EQ(block.first, next);
    EXPECT_LE(block.num_points, 120'000);
    next = block.last + 1;
    num_points += block.num_points;
  }
  EXPECT_EQ(next, 100);
  EXPECT_EQ(num_points, 700'000);
}

TEST(Blocks, EndWithTheirMapAndWhereNumbersAreMissing) {
  auto all = rows(12, 100);
  for (int i = 5; i < 12; ++i) all[static_cast<std::size_t>(i)].map_id = 1;
  all.erase(all.begin() + 8);
  const auto blocks = make_blocks(all);
  ASSERT_EQ(blocks.size(), 3U);
  EXPECT_EQ(blocks[0].last, 4);
  EXPECT_EQ(blocks[1].first, 5);
  EXPECT_EQ(blocks[1].last, 7);
  EXPECT_EQ(blocks[1].map_id, 1);
  EXPECT_EQ(blocks[2].first, 9);
}

TEST(Blocks, OnlyTheLastOneChangesWhenKeyframesFollow) {
  const auto all = rows(60, 9000);
  const auto before = make_blocks(std::span(all).first(37));
  const auto after = make_blocks(all);
  for (std::size_t i = 0; i + 1 < before.size(); ++i) {
    EXPECT_EQ(before[i].first, after[i].first);
    EXPECT_EQ(before[i].last, after[i].last);
  }
}

TEST(Blocks, AreShortUnlessTheyHaveHardlyAnyPoints) {
  for (const Block& block : make_blocks(rows(200, 5000))) EXPECT_LE(block.last - block.first, 25);
  EXPECT_EQ(make_blocks(rows(200, 10)).size(), 1U);
  EXPECT_TRUE(make_blocks({}).empty());
}

TEST(Blocks, AKeyframeThatIsTooLargeHasABlockOfItsOwn) {
  const auto blocks = make_blocks(rows(3, 200'000));
  EXPECT_EQ(blocks.size(), 3U);
}

}  // namespace
}  // namespace mmlins::view
