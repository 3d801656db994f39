// SPDX-License-Identifier: MIT
#include "mmlins/mapping/map_graph.hpp"

#include <gtest/gtest.h>

#include <Eigen/Cholesky>
#include <algorithm>
#include <cmath>

namespace mmlins::mapping {
namespace {

using math::Matrix6d;
using math::SE3;
using math::Vector3d;

const SE3 kTurned{math::so3_exp({0.0, 0.0, 0.3}), {1.0, 2.0, 0.0}};
const Matrix6d kGap = Vector3d(0.25, 0.25, 0.25).replicate<2, 1>().asDiagonal();

SE3 at(double x) { return {math::Matrix3d::Identity(), {x, 0.0, 0.0}}; }

double apart(const SE3& a, const SE3& b) { return math::se3_log(a.inverse() * b).norm(); }

keyframe::Keyframe keyframe_of(int id, int map, const SE3& T_map_imu) {
  keyframe::Keyframe kf;
  kf.id = id;
  kf.map_id = map;
  kf.T_map_imu = T_map_imu;
  return kf;
}

/// A graph that grows keyframe by keyframe, 1 m apart.
struct Grown {
  explicit Grown(const LinkConfig& link = {}) : graph(link, {}) {}
  void add(int count, int map) {
    for (int i = 0; i < count; ++i) {
      graph.add(keyframe_of(graph.num_keyframes(), map, at(i)), 1e-6 * Matrix6d::Identity());
    }
  }
  MapGraph graph;
};

int count_of(const MapGraph& graph, graph::EdgeKind kind) {
  const auto& edges = graph.graph().edges;
  return static_cast<int>(
      std::count_if(edges.begin(), edges.end(), [&](const graph::Edge& e) { return e.kind == kind; }));
}

Closure closure_between(int source, int target, const SE3& T_target_source, const MapGraph& graph) {
  Closure closure;
  closure.id = 17;
  closure.source = source;
  closure.target = target;
  closure.source_map = graph.map_of(source);
  closure.target_map = graph.map_of(target);
  closure.T_target_source = T_target_source;
  closure.information = 1e6 * Matrix6d::Identity();
  return closure;
}

TEST(MapGraph, LinksKeyframesOfOneMap) {
  Grown grown;
  grown.graph.begin_map({0, {}, std::nullopt});
  grown.add(4, 0);
  EXPECT_EQ(count_of(grown.graph, graph::EdgeKind::kOdometry), 3);
  EXPECT_NEAR(grown.graph.odometer(3), 3.0, 1e-12);
  EXPECT_LT(apart(grown.graph.graph().edges[1].T_from_to, at(1)), 1e-12);
  EXPECT_LT(apart(grown.graph.T_world_keyframe(3), at(3)), 1e-12);
}

TEST(MapGraph, JoinsMapsByTheGapBetweenThem) {
  LinkConfig link;
  link.gap_factor = 3.0;
  Grown grown(link);
  grown.graph.begin_map({0, {}, std::nullopt});
  grown.add(3, 0);
  grown.graph.begin_map({1, kTurned, kGap});
  grown.add(2, 1);
  ASSERT_EQ(count_of(grown.graph, graph::EdgeKind::kGap), 1);
  const graph::Edge& gap = grown.graph.graph().edges[2];
  EXPECT_EQ(gap.kind, graph::EdgeKind::kGap);
  EXPECT_EQ(gap.from, 2);
  EXPECT_EQ(gap.to, 3);
  EXPECT_LT(apart(gap.T_from_to, at(2).inverse() * kTurned), 1e-12);
  // Three times the deviation.
  EXPECT_LT((gap.information.inverse() - 9.0 * kGap).norm(), 1e-9);
  EXPECT_FALSE(gap.robust);
  EXPECT_TRUE(grown.graph.are_connected(0, 1));
  EXPECT_EQ(grown.graph.world_of(1), 1);
  EXPECT_LT(apart(grown.graph.T_world_keyframe(4), kTurned * at(1)), 1e-12);
}

TEST(MapGraph, HasNoEdgeWhereTheImuWasSilent) {
  Grown grown;
  grown.graph.begin_map({0, {}, std::nullopt});
  grown.add(2, 0);
  grown.graph.begin_map({1, kTurned, std::nullopt});
  grown.add(2, 1);
  EXPECT_EQ(count_of(grown.graph, graph::EdgeKind::kGap), 0);
  EXPECT_FALSE(grown.graph.are_connected(0, 1));
}

TEST(MapGraph, AddsUpGapsAroundAMapThatSawNothing) {
  LinkConfig link;
  link.gap_factor = 1.0;
  Grown grown(link);
  grown.graph.begin_map({0, {}, std::nullopt});
  grown.add(2, 0);
  grown.graph.begin_map({1, at(5), kGap});
  grown.graph.begin_map({2, kTurned, 2.0 * kGap});
  grown.add(1, 2);
  ASSERT_EQ(count_of(grown.graph, graph::EdgeKind::kGap), 1);
  const graph::Edge& gap = grown.graph.graph().edges.back();
  EXPECT_EQ(gap.from, 1);
  EXPECT_EQ(gap.to, 2);
  EXPECT_LT((gap.information.inverse() - 3.0 * kGap).norm(), 1e-9);
  EXPECT_LT(apart(gap.T_from_to, at(1).inverse() * kTurned), 1e-12);
}

TEST(MapGraph, SaysWhyItCannotBeOptimised) {
  Grown grown;
  grown.graph.begin_map({0, {}, std::nullopt});
  grown.add(3, 0);
  EXPECT_EQ(grown.graph.optimize().error, "");
  grown.graph.add(keyframe_of(3, 0, at(3)), std::nan("") * Matrix6d::Identity());
  const MapGraph::Solution solution = grown.graph.optimize();
  EXPECT_FALSE(solution.solved);
  EXPECT_NE(solution.error.find("edge 2 -> 3"), std::string::npos) << solution.error;
}

TEST(MapGraph, TakesAlongWhatFollowsAKeyframeThatHasBeenMoved) {
  Grown grown;
  grown.graph.begin_map({0, {}, std::nullopt});
  grown.add(11, 0);
  // Keyframe 10 turns out to lie 0.1 m beside where the odometry had it.
  const SE3 found{math::so3_exp({0.0, 0.0, 0.01}), {10.0, 0.1, 0.0}};
  grown.graph.add_closure(closure_between(10, 0, found, grown.graph));
  ASSERT_TRUE(grown.graph.optimize().solved);
  const SE3 T_world_last = grown.graph.T_world_keyframe(10);
  EXPECT_GT(apart(T_world_last, at(10)), 0.05);
  grown.graph.add(keyframe_of(11, 0, at(11)), 1e-6 * Matrix6d::Identity());
  EXPECT_LT(apart(grown.graph.T_world_keyframe(11), T_world_last * at(1)), 1e-9);
  // And so does the map that comes next.
  grown.graph.begin_map({1, at(12), kGap});
  grown.add(1, 1);
  EXPECT_LT(apart(grown.graph.T_world_keyframe(12), T_world_last * at(2)), 1e-9);
}

TEST(MapGraph, BelievesALinkNoMoreThanTheImuThatCarriedThePose) {
  LinkConfig link;
  link.gap_factor = 2.0;
  Grown grown(link);
  grown.graph.begin_map({0, {}, std::nullopt});
  grown.add(2, 0);
  grown.graph.bridge(kGap);
  grown.graph.add(keyframe_of(2, 0, at(2)), Matrix6d::Zero());
  grown.graph.add(keyframe_of(3, 0, at(3)), Matrix6d::Zero());
  const auto& edges = grown.graph.graph().edges;
  ASSERT_EQ(edges.size(), 3U);
  const Matrix6d usual = link_covariance(at(1), Matrix6d::Zero(), link);
  EXPECT_LT((edges[1].information.inverse() - usual - 4.0 * kGap).norm(), 1e-9);
  EXPECT_LT((edges[2].information.inverse() - usual).norm(), 1e-9);  // and no other
  EXPECT_TRUE(grown.graph.is_bridged(1, 2));
  EXPECT_FALSE(grown.graph.is_bridged(0, 1));
  EXPECT_FALSE(grown.graph.is_bridged(2, 3));
}

TEST(MapGraph, ForgetsABridgeThatEndsInAnotherMap) {
  Grown grown;
  grown.graph.begin_map({0, {}, std::nullopt});
  grown.add(2, 0);
  grown.graph.bridge(kGap);
  grown.graph.begin_map({1, at(5), kGap});
  grown.add(2, 1);
  const graph::Edge& link = grown.graph.graph().edges.back();
  EXPECT_LT((link.information.inverse() - link_covariance(at(1), 1e-6 * Matrix6d::Identity(), {})).norm(), 1e-9);
}

TEST(MapGraph, HoldsWhatAClosureConfirms) {
  Grown grown;
  grown.graph.begin_map({0, {}, std::nullopt});
  grown.add(3, 0);
  grown.graph.bridge(kGap);
  for (int i = 3; i < 6; ++i) grown.graph.add(keyframe_of(i, 0, at(i)), 1e-6 * Matrix6d::Identity());
  Closure near = closure_between(4, 1, at(3.02), grown.graph);
  grown.graph.hold(near, covariance_of(0.2, 0.05));
  ASSERT_TRUE(grown.graph.optimize().solved);
  for (int i = 0; i < 6; ++i) EXPECT_LT(apart(grown.graph.T_world_keyframe(i), at(i)), 1e-6);
  // The 5 cm to which it holds, the links beside it and its own 1 mm.
  const KeyframePair across{2, 3};
  EXPECT_LT(std::sqrt(grown.graph.predict({&across, 1})[0]->covariance(3, 3)), 0.06);
}

TEST(MapGraph, MovesAndJoinsWorlds) {
  Grown grown;
  for (int map = 0; map < 3; ++map) {
    grown.graph.begin_map({map, at(100.0 * map), std::nullopt});
    grown.add(2, map);
  }
  grown.graph.join(2, 1);
  EXPECT_EQ(grown.graph.world_of(2), 1);
  grown.graph.move_world(1, kTurned);
  EXPECT_LT(apart(grown.graph.T_world_keyframe(0), at(0)), 1e-12);
  EXPECT_LT(apart(grown.graph.T_world_keyframe(2), kTurned * at(100)), 1e-12);
  EXPECT_LT(apart(grown.graph.T_world_keyframe(5), kTurned * at(201)), 1e-12);
  EXPECT_TRUE(grown.graph.are_connected(1, 2));
  EXPECT_FALSE(grown.graph.are_connected(0, 2));
}

TEST(MapGraph, PutsAMapBackThatWasJoined) {
  for (const bool has_gap : {true, false}) {
    Grown grown;
    grown.graph.begin_map({0, {}, std::nullopt});
    grown.add(4, 0);
    grown.graph.begin_map({1, at(10), has_gap ? std::optional<Matrix6d>(kGap) : std::nullopt});
    grown.add(4, 1);
    grown.graph.begin_map({2, at(20), kGap});
    grown.add(4, 2);
    const MapGraph before = grown.graph;
    // Half a metre off: the optimisation has something to do.
    grown.graph.move_world(1, kTurned * at(-9.5));
    grown.graph.join(1, 0);
    const SE3 T_target_source = at(2).inverse() * kTurned * at(1);
    grown.graph.add_closure(closure_between(5, 2, T_target_source, grown.graph));
    ASSERT_TRUE(grown.graph.optimize().solved);
    EXPECT_LT(apart(grown.graph.T_world_keyframe(5), kTurned * at(1)), 0.01);
    const std::vector<int> moved{1};
    grown.graph.separate(moved, before.T_world_map(1));
    ASSERT_TRUE(grown.graph.optimize().solved);
    EXPECT_EQ(grown.graph.world_of(1), 1);
    EXPECT_EQ(grown.graph.world_of(2), 2);
    EXPECT_EQ(grown.graph.are_connected(0, 1), has_gap);
    EXPECT_TRUE(grown.graph.are_connected(1, 2));
    EXPECT_EQ(count_of(grown.graph, graph::EdgeKind::kMerge), 0);
    // To the tolerance of the optimiser.
    for (int id = 0; id < 12; ++id) {
      EXPECT_LT(apart(grown.graph.T_world_keyframe(id), before.T_world_keyframe(id)), 1e-5) << id << has_gap;
    }
  }
}

TEST(MapGraph, MeasuresGravityOnceInAStretch) {
  LinkConfig link;
  link.gravity_every = 5;
  Grown grown(link);
  grown.graph.begin_map({0, {}, std::nullopt});
  grown.add(12, 0);  // stretches of 5, 5 and 2
  grown.graph.begin_map({1, at(20), kGap});
  grown.add(3, 1);
  const auto& gravity = grown.graph.graph().gravity;
  ASSERT_EQ(gravity.size(), 4U);
  // The latest keyframe of each stretch.
  EXPECT_EQ(gravity[0].node, 4);
  EXPECT_EQ(gravity[1].node, 9);
  EXPECT_EQ(gravity[2].node, 11);
  EXPECT_EQ(gravity[3].node, 14);
  EXPECT_LT((gravity[0].up_node - Vector3d::UnitZ()).norm(), 1e-12);
}

TEST(MapGraph, LeavesGravityOutIfAsked) {
  LinkConfig link;
  link.gravity_every = 0;
  Grown grown(link);
  grown.graph.begin_map({0, {}, std::nullopt});
  grown.add(3, 0);
  EXPECT_TRUE(grown.graph.graph().gravity.empty());
}

TEST(MapGraph, PredictsWhatTheChainSaysAndKnowsLessTheLongerItIs) {
  Grown grown;
  grown.graph.begin_map({0, {}, std::nullopt});
  grown.add(9, 0);
  grown.graph.begin_map({1, at(20), std::nullopt});
  grown.add(1, 1);
  const std::vector<KeyframePair> pairs{{0, 2}, {0, 8}, {0, 9}};
  const auto priors = grown.graph.predict(pairs);
  ASSERT_TRUE(priors[0] && priors[1]);
  EXPECT_LT(apart(priors[0]->T_target_source, at(2)), 1e-9);
  EXPECT_LT(apart(priors[1]->T_target_source, at(8)), 1e-9);
  EXPECT_GT(priors[1]->covariance(5, 5), priors[0]->covariance(5, 5));
  EXPECT_FALSE(priors[2]);  // nothing leads there
}

TEST(LinkCovariance, GrowsWithTheWayAndWithWhatTheFilterDoesNotKnow) {
  LinkConfig link;
  link.position = 0.01;
  link.position_per_m = 0.02;
  link.rotation_deg = 0.0;
  link.rotation_deg_per_m = 0.0;
  link.weak_length = 10.0;
  Matrix6d pose = Matrix6d::Zero();
  pose(3, 3) = 0.5;
  const Matrix6d covariance = link_covariance(at(2), pose, link);
  // (1 cm + 2 m 2 cm/m)^2, and of the filter's own variance a fifth.
  EXPECT_NEAR(covariance(4, 4), 0.05 * 0.05, 1e-12);
  EXPECT_NEAR(covariance(3, 3), 0.05 * 0.05 + 0.1, 1e-12);
}

}  // namespace
}  // namespace mmlins::mapping
