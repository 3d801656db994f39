// SPDX-License-Identifier: MIT
#include "mmlins/view/tiles.hpp"

#include <gtest/gtest.h>

#include <cstring>
#include <map>
#include <set>

#include "tests/atlas/example.hpp"

namespace mmlins::view {
namespace {

using keyframe::Keyframe;
using keyframe::KeyframePointer;

/// A keyframe, number, and point in it: what tells points apart.
using Identity = std::tuple<int, std::int16_t, std::int16_t, std::int16_t, std::uint16_t>;

std::multiset<Identity> points_of(const BlockTiles& tiles) {
  std::multiset<Identity> points;
  for (const auto& level : tiles.levels) {
    for (const TilePoint& p : level) {
      points.insert({p.keyframe, p.p_imu[0], p.p_imu[1], p.p_imu[2], p.intensity});
    }
  }
  return points;
}

/// A wall of points every 4 cm, seen from three keyframes 1 m apart.
std::vector<KeyframePointer> wall(int first_id) {
  std::vector<KeyframePointer> keyframes;
  for (int k = 0; k < 3; ++k) {
    auto keyframe = std::make_shared<Keyframe>();
    keyframe->id = first_id + k;
    keyframe->T_map_imu.t = {1.0 * k, 0.0, 0.0};
    for (int i = 0; i < 250; ++i) {
      for (int j = 0; j < 50; ++j) {
        keyframe->points_imu.emplace_back(0.04F * static_cast<float>(i), 5.0F, 0.04F * static_cast<float>(j));
        keyframe->intensities.push_back(static_cast<std::uint16_t>(100 * k + j));
      }
    }
    keyframes.push_back(keyframe);
  }
  return keyframes;
}

TEST(Tiles, EveryPointIsInOneLevelAsItWasStored) {
  std::vector<KeyframePointer> keyframes;
  std::multiset<Identity> expected;
  for (int id = 40; id < 45; ++id) {
    const auto keyframe = std::make_shared<Keyframe>(atlas::example_keyframe(id, 1, 400));
    keyframes.push_back(keyframe);
    for (std::size_t i = 0; i < keyframe->points_imu.size(); ++i) {
      const Eigen::Vector3f& p = keyframe->points_imu[i];
      const auto step = [](float x) { return static_cast<std::int16_t>(std::lround(x / 0.004)); };
      const std::uint16_t intensity =
          keyframe->intensities.empty() ? std::uint16_t{0} : keyframe->intensities[i];
      expected.insert({id - 40, step(p.x()), step(p.y()), step(p.z()), intensity});
    }
  }
  EXPECT_EQ(points_of(make_tiles(keyframes, 40)), expected);
}

TEST(Tiles, LevelsHaveOnePointPerCellAndFillAllCells) {
  const auto keyframes = wall(7);
  const BlockTiles tiles = make_tiles(keyframes, 7);
  // Seen from the keyframes the wall is 12 m long and 2 m high: its points lie at most 11.96 m and 1.96 m
  // from its corner.
  std::size_t sum = 0;
  for (std::size_t level = 0; level + 1 < kNumLevels; ++level) {
    const double edge = kLevelCells[level];
    sum += tiles.levels[level].size();
    std::set<std::pair<long, long>> cells;
    for (const TilePoint& p : tiles.levels[level]) {
      const double x = 0.004 * p.p_imu[0] + p.keyframe;
      EXPECT_TRUE(
          cells
              .insert({std::lround(std::floor(x / edge)), std::lround(std::floor(0.004 * p.p_imu[2] / edge))})
              .second);
    }
    if (level == 0) EXPECT_EQ(cells.size(), 24U);
    if (level == 1) EXPECT_LE(cells.size(), 96U);
    // Where a coarse cell has a point, the fine cell around it may do without one of its own.
    EXPECT_GE(static_cast<double>(sum) * edge * edge, 0.75 * 24.0);
  }
}

TEST(Tiles, AnyBeginningOfALevelIsSpreadOverTheBlock) {
  const BlockTiles tiles = make_tiles(wall(0), 0);
  const auto& rest = tiles.levels.back();
  ASSERT_GT(rest.size(), 10000U);
  std::map<int, int> thirds;
  const int beginning = 900;
  for (int i = 0; i < beginning; ++i)
    ++thirds[static_cast<int>(0.004 * rest[static_cast<std::size_t>(i)].p_imu[0] / 3.4)];
  // 300 expected in each; five standard deviations of such a count are 71.
  for (const int third : {0, 1, 2}) EXPECT_NEAR(thirds[third], 300, 71);
}

TEST(Tiles, CentreAndRadiusAreThoseOfThePoints) {
  const BlockTiles tiles = make_tiles(wall(0), 0);
  // In the map the wall reaches from 0 to 11.96 m; the middle keyframe stands at 1 m.
  EXPECT_NEAR(tiles.p_imu_centre.x(), 5.98 - 1.0, 1e-6);
  EXPECT_NEAR(tiles.p_imu_centre.y(), 5.0, 1e-6);
  EXPECT_NEAR(tiles.p_imu_centre.z(), 0.98, 1e-6);
  EXPECT_GT(tiles.radius, 3.5);
  EXPECT_LT(tiles.radius, 6.1);
}

TEST(Tiles, AreTheSameEachTime) {
  const BlockTiles a = make_tiles(wall(0), 0);
  const BlockTiles b = make_tiles(wall(0), 0);
  for (int level = 0; level < kNumLevels; ++level) EXPECT_EQ(encode_tile(a, level), encode_tile(b, level));
}

template <typename T>
T read(const std::string& bytes, std::size_t at) {
  T value;
  std::memcpy(&value, bytes.data() + at, sizeof(value));
  return value;
}

TEST(Tiles, AreSentAsTheFormatSays) {
  const BlockTiles tiles = make_tiles(wall(3), 3);
  for (int level = 0; level < kNumLevels; ++level) {
    const std::string bytes = encode_tile(tiles, level);
    EXPECT_EQ(bytes.substr(0, 4), "MMT1");
    EXPECT_EQ(read<std::uint32_t>(bytes, 4), static_cast<std::uint32_t>(level));
    EXPECT_EQ(read<std::uint32_t>(bytes, 8), 5U);
    for (std::size_t i = 0; i < 5; ++i) {
      EXPECT_EQ(read<std::uint32_t>(bytes, 12 + 8 * i), tiles.levels[i].size());
      EXPECT_EQ(read<float>(bytes, 16 + 8 * i), static_cast<float>(kLevelCells[i]));
    }
    EXPECT_EQ(read<float>(bytes, 64), static_cast<float>(tiles.radius));
    const auto& points = tiles.levels[static_cast<std::size_t>(level)];
    ASSERT_EQ(bytes.size(), 68 + 10 * points.size());
    const std::size_t last = points.size() - 1;
    EXPECT_EQ(read<std::int16_t>(bytes, 68 + 8 * last + 2), points[last].p_imu[1]);
    EXPECT_EQ(read<std::uint16_t>(bytes, 68 + 8 * last + 6), points[last].keyframe);
    EXPECT_EQ(read<std::uint16_t>(bytes, 68 + 8 * points.size() + 2 * last), points[last].intensity);
  }
}

TEST(Tiles, ABlockWithoutPointsIsEmpty) {
  const std::vector<KeyframePointer> keyframes{std::make_shared<Keyframe>()};
  const BlockTiles tiles = make_tiles(keyframes, 0);
  EXPECT_EQ(encode_tile(tiles, 0).size(), 68U);
  EXPECT_EQ(tiles.radius, 0.0);
}

}  // namespace
}  // namespace mmlins::view
