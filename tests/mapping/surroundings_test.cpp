// SPDX-License-Identifier: MIT
#include "mmlins/mapping/surroundings.hpp"

#include <gtest/gtest.h>

#include <algorithm>

namespace mmlins::mapping {
namespace {

using math::Matrix6d;
using math::SE3;

SE3 at(double x, double y = 0.0) { return {math::Matrix3d::Identity(), {x, y, 0.0}}; }

/// A graph that grows keyframe by keyframe, and the poses that the odometry gave.
struct Grown {
  void begin_map(int map, const SE3& T_world_map) { graph.begin_map({map, T_world_map, std::nullopt}); }
  void add(int map, const SE3& T) {
    keyframe::Keyframe kf;
    kf.id = graph.num_keyframes();
    kf.map_id = map;
    kf.T_map_imu = T;
    graph.add(kf, 1e-6 * Matrix6d::Identity());
    T_map_imu.push_back(T);
  }
  [[nodiscard]] Surroundings around() const {
    return surroundings_of_latest(graph, T_map_imu, place_world(graph, T_map_imu, std::nullopt, config),
                                  config);
  }

  MapGraph graph{LinkConfig{}, {}};
  std::vector<SE3> T_map_imu;
  RebuildConfig config;
};

std::vector<int> ids_of(const std::vector<PlacedKeyframe>& keyframes) {
  std::vector<int> ids;
  for (const auto& one : keyframes) ids.push_back(one.id);
  return ids;
}

TEST(Surroundings, OfAWayThatNeverLeavesAreAllInTheMapAlready) {
  Grown grown;
  grown.begin_map(0, {});
  for (int i = 0; i < 200; ++i) grown.add(0, at(i % 20));
  const Surroundings around = grown.around();
  EXPECT_TRUE(around.known.empty());
  EXPECT_EQ(around.recent.back(), 199);
  EXPECT_TRUE(std::is_sorted(around.recent.begin(), around.recent.end()));
}

TEST(Surroundings, ThatTheRobotComesBackToAreKnown) {
  Grown grown;
  grown.begin_map(0, {});
  for (int i = 0; i <= 100; ++i) grown.add(0, at(i));
  for (int i = 100; i >= 0; --i) grown.add(0, at(i, 5.0));
  const Surroundings around = grown.around();
  // The first pass within 50 m; the second one lies within the last 50 m of way.
  ASSERT_FALSE(around.known.empty());
  EXPECT_EQ(around.known.front().id, 0);
  EXPECT_EQ(around.known.back().id, 49);  // sqrt(49^2 + 5^2) < 50 < sqrt(50^2 + 5^2)
  EXPECT_EQ(around.recent.front(), 201 - 50);
}

TEST(Surroundings, OfAnotherMapCountOnceItIsJoinedAndLieWhereTheRobotSeesThem) {
  Grown grown;
  grown.begin_map(0, {});
  for (int i = 0; i < 10; ++i) grown.add(0, at(i));
  const SE3 T_world_second{math::so3_exp({0.0, 0.0, 0.5}), {3.0, 2.0, 0.0}};
  grown.begin_map(1, T_world_second);
  for (int i = 0; i < 10; ++i) grown.add(1, at(i));
  EXPECT_TRUE(grown.around().known.empty());
  grown.graph.join(1, 0);
  const Surroundings around = grown.around();
  EXPECT_EQ(ids_of(around.known), (std::vector<int>{0, 1, 2, 3, 4, 5, 6, 7, 8, 9}));
  for (const PlacedKeyframe& one : around.known) {
    // Seen from the robot they lie as they do in the world.
    const SE3 seen = grown.T_map_imu.back().inverse() * one.T_map_imu;
    const SE3 truth = grown.graph.T_world_keyframe(19).inverse() * grown.graph.T_world_keyframe(one.id);
    EXPECT_LT(math::se3_log(seen.inverse() * truth).norm(), 1e-12);
  }
}

TEST(Surroundings, SeenBeforeTheImuAloneCarriedThePoseAreNotTakenForTheMapThatGrew) {
  Grown grown;
  grown.begin_map(0, {});
  for (int i = 0; i < 10; ++i) grown.add(0, at(i));
  grown.graph.bridge(Matrix6d::Identity());
  for (int i = 10; i < 20; ++i) grown.add(0, at(i));
  const Surroundings around = grown.around();
  EXPECT_EQ(around.known.size(), 10U);
  EXPECT_EQ(around.recent.front(), 10);
}

TEST(Surroundings, LieWhereTheyWereLaidBeforeAsLongAsThatIsRight) {
  Grown grown;
  grown.begin_map(0, {});
  grown.add(0, at(3));
  const SE3 near{math::so3_exp({0.0, 0.0, 0.001}), {0.02, 0.0, 0.0}};
  const SE3 far = at(0.2);
  const auto laid = [&](const std::optional<SE3>& before) {
    return place_world(grown.graph, grown.T_map_imu, before, grown.config);
  };
  EXPECT_EQ(laid(near).t, near.t);
  EXPECT_LT(laid(far).t.norm(), 1e-12);
  EXPECT_LT(laid(std::nullopt).t.norm(), 1e-12);
}

TEST(Surroundings, AreNoMoreThanAsked) {
  Grown grown;
  grown.config.max_keyframes = 5;
  grown.begin_map(0, {});
  for (int i = 0; i < 10; ++i) grown.add(0, at(i));
  grown.begin_map(1, {});
  for (int i = 0; i < 10; ++i) grown.add(1, at(i));
  grown.graph.join(1, 0);
  const Surroundings around = grown.around();
  EXPECT_EQ(ids_of(around.known), (std::vector<int>{5, 6, 7, 8, 9}));  // nearest to the robot, at 9 m
  EXPECT_EQ(around.recent, (std::vector<int>{15, 16, 17, 18, 19}));
}

}  // namespace
}  // namespace mmlins::mapping
