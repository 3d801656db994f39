// SPDX-License-Identifier: MIT
#include "mmlins/mapping/world_merger.hpp"

#include <gtest/gtest.h>

#include <cmath>

namespace mmlins::mapping {
namespace {

using math::Matrix6d;
using math::SE3;
using math::Vector3d;

constexpr int kPerMap = 30;  ///< keyframes, 1 m apart
/// Where the second map truly lies, half a metre beside where it is said to.
const SE3 kTruth{math::Matrix3d::Identity(), {0.0, 0.5, 0.0}};
/// A place that looks like another.
const SE3 kFalse{math::Matrix3d::Identity(), {12.0, 0.5, 0.0}};

SE3 at(double x) { return {math::Matrix3d::Identity(), {x, 0.0, 0.0}}; }

/// Two maps along the same way, and what was found between them.
struct Found {
  explicit Found(bool gap_is_known = false) : worlds(MapGraph({}, {})), merger({}, worlds) {
    std::optional<Matrix6d> gap;
    if (gap_is_known) gap = Matrix6d::Identity();
    worlds.graph.begin_map({0, {}, std::nullopt});
    add_keyframes(0);
    worlds.graph.begin_map({1, {}, gap});
    add_keyframes(1);
  }

  void add_keyframes(int map) {
    for (int i = 0; i < kPerMap; ++i) {
      keyframe::Keyframe kf;
      kf.id = kPerMap * map + i;
      kf.map_id = map;
      kf.T_map_imu = at(i);
      worlds.graph.add(kf, 1e-6 * Matrix6d::Identity());
    }
  }

  /// A submap of the second map is looked at, from keyframe `begin` on with keyframe `middle` in the middle,
  /// and recognised in one of the first.
  void look(int begin, int middle, int target, const SE3& T_world_map = kTruth) {
    Closure closure;
    closure.id = static_cast<int>(worlds.closures.size());
    closure.source = kPerMap + middle;
    closure.source_begin = kPerMap + begin;
    closure.source_map = 1;
    closure.target = target;
    closure.target_begin = target - 5;
    closure.state = ClosureState::kWaiting;
    closure.T_target_source = at(target).inverse() * T_world_map * at(middle);
    closure.information = 1e4 * Matrix6d::Identity();
    closure.overlap = 0.6;
    worlds.closures.push_back(closure);
  }

  [[nodiscard]] ClosureState state(int id) const { return worlds.closure(id).state; }

  Worlds worlds;
  WorldMerger merger;
};

TEST(WorldMerger, CountsPlacesAndNotHowOftenTheyWereLookedAt) {
  Found found;
  found.look(0, 2, 8);
  found.look(0, 7, 8);  // the same submap, grown
  found.look(0, 7, 15);
  EXPECT_FALSE(found.merger.try_to_merge(0, 1).has_value());
  found.look(8, 15, 15);
  const auto merge = found.merger.try_to_merge(0, 1);
  ASSERT_TRUE(merge.has_value());
  // What was seen of the place at last is what counts.
  EXPECT_EQ(merge->closures, (std::vector<int>{1, 2, 3}));
  EXPECT_EQ(found.state(0), ClosureState::kConfirmed);
  for (const int id : merge->closures) EXPECT_EQ(found.state(id), ClosureState::kCounts);
  EXPECT_LT((found.worlds.graph.T_world_keyframe(kPerMap).t - kTruth.t).norm(), 0.01);
}

TEST(WorldMerger, CountsTwoPlacesOnceWhicheverLooksAtTheOther) {
  Found found;
  found.look(0, 7, 8);
  found.look(8, 15, 15);
  found.look(8, 15, 15);
  Closure& back = found.worlds.closure(2);
  std::swap(back.source, back.target);
  std::swap(back.source_begin, back.target_begin);
  std::swap(back.source_map, back.target_map);
  back.T_target_source = back.T_target_source.inverse();
  EXPECT_FALSE(found.merger.try_to_merge(0, 1).has_value());
}

TEST(WorldMerger, JoinsAYoungMapThatGrewBetweenTwoLooks) {
  Found found(true);
  found.look(0, 1, 8);
  found.look(0, 3, 8);
  EXPECT_FALSE(found.merger.try_to_merge(0, 1).has_value());
  found.look(0, 3, 15);
  EXPECT_TRUE(found.merger.try_to_merge(0, 1).has_value());
}

TEST(WorldMerger, IsNotHeldUpByAFalsePlaceThatWasLookedAtOften) {
  Found found;
  for (const int middle : {1, 3, 5, 7}) found.look(0, middle, 22, kFalse);
  found.look(0, 7, 8);
  found.look(8, 15, 15);
  found.look(15, 22, 22);
  const auto merge = found.merger.try_to_merge(0, 1);
  ASSERT_TRUE(merge.has_value());
  EXPECT_EQ(merge->closures, (std::vector<int>{4, 5, 6}));
  EXPECT_EQ(found.state(0), ClosureState::kWaiting);
}

TEST(Worlds, CallAClosureRejectedNoLongerThanTheGraphDoes) {
  Found found;
  for (const int middle : {5, 15, 25}) {
    found.look(middle - 5, middle, middle);
    found.worlds.graph.add_closure(found.worlds.closures.back());
  }
  found.worlds.closure(1).state = ClosureState::kRejected;
  found.look(10, 12, 20, kFalse);
  found.worlds.closure(3).state = ClosureState::kCounts;
  found.worlds.graph.add_closure(found.worlds.closure(3));
  ASSERT_TRUE(found.worlds.solve(found.worlds.graph));
  EXPECT_EQ(found.state(1), ClosureState::kCounts);
  EXPECT_EQ(found.state(3), ClosureState::kRejected);
}

TEST(Worlds, KeepWhyTheirGraphCouldNotBeOptimised) {
  Found found;
  EXPECT_TRUE(found.worlds.solve(found.worlds.graph));
  EXPECT_EQ(found.worlds.error, "");
  const MapGraph before = found.worlds.graph;
  found.look(0, 7, 8);
  found.worlds.closure(0).information *= std::nan("");
  found.worlds.graph.add_closure(found.worlds.closure(0));
  EXPECT_FALSE(found.worlds.solve(before));
  EXPECT_NE(found.worlds.error.find("edge 8 -> 37"), std::string::npos) << found.worlds.error;
}

/// Joined by three closures at `T_world_map`.
void join(Found& found, const SE3& T_world_map) {
  found.look(0, 7, 8, T_world_map);
  found.look(8, 15, 15, T_world_map);
  found.look(15, 22, 22, T_world_map);
  found.worlds.merges.push_back(found.merger.try_to_merge(0, 1).value());
}

/// Another look, that verification refused.
Closure& refused(Found& found, int begin, int middle) {
  found.look(begin, middle, 8 + begin);
  found.worlds.closures.back().state = ClosureState::kRefused;
  return found.worlds.closures.back();
}

TEST(WorldMerger, TakesAMergeBackForThreePlacesThatSeeThroughWallsAndNotForOneSeenThrice) {
  Found found;
  join(found, kTruth);
  const auto see_through = [&](int begin, int middle) {
    refused(found, begin, middle).crossing_share = 0.9;
    found.merger.review(0);
    return found.worlds.merges.front().undone.has_value();
  };
  for (const int middle : {1, 3, 7}) EXPECT_FALSE(see_through(0, middle));
  EXPECT_FALSE(see_through(8, 15));
  EXPECT_TRUE(see_through(15, 22));
}

TEST(WorldMerger, TakesAMergeBackForThreePlacesThatAgreeElsewhereAndNotForOneSeenThrice) {
  Found found;
  join(found, kFalse);
  const auto contradict = [&](int begin, int middle) {
    refused(found, begin, middle).contradicts = true;
    found.merger.review(0);
    return found.worlds.merges.front().undone.has_value();
  };
  for (const int middle : {1, 3, 7}) EXPECT_FALSE(contradict(0, middle));
  EXPECT_FALSE(contradict(8, 15));
  EXPECT_TRUE(contradict(15, 22));
  EXPECT_NE(found.worlds.merges.front().why_undone.find("12.00 m elsewhere"), std::string::npos);
  const MapGraph& graph = found.worlds.graph;
  EXPECT_EQ(graph.world_of(1), 1);
  EXPECT_FALSE(graph.are_connected(0, 1));
  // Both are as their own odometry has them again.
  for (int i = 0; i < kPerMap; ++i)
    EXPECT_LT((graph.T_world_keyframe(kPerMap + i).t - at(i).t).norm(), 1e-6) << i;
}

}  // namespace
}  // namespace mmlins::mapping
