// SPDX-License-Identifier: MIT
#include <gtest/gtest.h>

#include "tests/graph/chains.hpp"

namespace mmlins::graph {
namespace {

constexpr double kDegree = std::numbers::pi / 180.0;

/// The second half of the chain as map 1, in its own frame, without the odometry between the halves.
Chain in_two_maps(const ChainSpec& spec, const SE3& T_world_b) {
  Chain chain = make_chain(spec);
  const int half = spec.num_nodes / 2;
  chain.graph.anchors.push_back({.map = 1, .T_world_map = {}});
  std::erase_if(chain.graph.edges, [half](const Edge& e) { return e.from == half - 1 && e.to == half; });
  const SE3 T_first = chain.graph.nodes[static_cast<std::size_t>(half)].T_map_node;
  const SE3 T_first_true = chain.T_world_node[static_cast<std::size_t>(half)];
  for (int i = half; i < spec.num_nodes; ++i) {
    Node& node = chain.graph.nodes[static_cast<std::size_t>(i)];
    node.map = 1;
    node.T_map_node = T_world_b.inverse() * T_first_true * (T_first.inverse() * node.T_map_node);
  }
  for (Edge& edge : chain.graph.edges) {
    if (edge.from < half && edge.to >= half) edge.kind = EdgeKind::kMerge;
  }
  return chain;
}

const SE3 kFarAway{math::so3_exp({0.0, 0.0, 2.5}), {70.0, -30.0, 3.0}};

TEST(Maps, MergeEdgesFindTheAnchorOfTheSecondMap) {
  const Chain chain = in_two_maps({.rotation_sigma = 0.0, .translation_sigma = 0.0}, kFarAway);
  const auto result = optimize(chain.graph);
  ASSERT_TRUE(result.ok());
  EXPECT_EQ(result->report.status, GraphStatus::kConverged);
  const SE3& T_world_b = result->graph.anchors[1].T_world_map;
  EXPECT_LT((T_world_b.t - kFarAway.t).norm(), 1e-7);
  EXPECT_LT((T_world_b.R - kFarAway.R).norm(), 1e-8);
  EXPECT_EQ(result->report.num_rejected, 0);
  EXPECT_TRUE(result->report.unconnected_maps.empty());
}

TEST(Maps, FalseMergesAreRejectedWithoutAGuessOfTheAnchor) {
  for (std::uint64_t seed = 1; seed <= 5; ++seed) {
    Chain chain = in_two_maps({.seed = seed}, kFarAway);
    math::Random random(seed);
    const std::size_t first_false = chain.graph.edges.size();
    for (int i = 0; i < 4; ++i) {
      Edge edge =
          true_edge(chain, 10 + 20 * i, 190 - 15 * i, EdgeKind::kMerge, diagonal_information(0.002, 0.02));
      edge.T_from_to = {math::so3_exp({0.0, 0.0, random.uniform(-3.0, 3.0)}), 3.0 * random.normal3()};
      chain.graph.edges.push_back(edge);
    }
    const auto result = optimize(chain.graph);
    ASSERT_TRUE(result.ok());
    for (std::size_t e = first_false; e < chain.graph.edges.size(); ++e) {
      EXPECT_EQ(result->report.edges[e].weight, 0.0) << "seed " << seed;
    }
    EXPECT_LE(result->report.num_rejected, 5) << "seed " << seed;
    // Ten merges of 2 cm and 2 mrad, and two chains of some metres between them.
    EXPECT_LT(rms_position_error(poses_of(result->graph), chain.T_world_node), 0.5) << "seed " << seed;
  }
}

TEST(Maps, ShapeOfTheResultDoesNotDependOnWhichAnchorIsFixedOrWhere) {
  Chain chain = in_two_maps({.seed = 4}, kFarAway);
  const auto first = optimize(chain.graph);
  chain.graph.anchors[0].fixed = false;
  chain.graph.anchors[1].fixed = true;
  chain.graph.anchors[1].T_world_map = {math::so3_exp({0.3, -0.4, 1.0}), {-500.0, 20.0, 9.0}};
  const auto second = optimize(chain.graph);
  ASSERT_TRUE(first.ok() && second.ok());
  const std::vector<SE3> a = poses_of(first->graph);
  const std::vector<SE3> b = poses_of(second->graph);
  for (std::size_t i = 1; i < a.size(); ++i) {
    const SE3 difference = (a[0].inverse() * a[i]).inverse() * (b[0].inverse() * b[i]);
    // Both stop within a millionth of the smallest chi2: a thousandth of a standard deviation.
    EXPECT_LT(difference.t.norm(), 1e-4);
    EXPECT_LT(math::so3_log(difference.R).norm(), 1e-5);
  }
  EXPECT_NEAR(first->report.final.total, second->report.final.total, 1e-3);
  EXPECT_EQ(first->report.dof, second->report.dof);
}

TEST(Maps, FixedAnchorStaysToTheBit) {
  const Chain chain = in_two_maps({}, kFarAway);
  const auto result = optimize(chain.graph);
  ASSERT_TRUE(result.ok());
  EXPECT_EQ(result->graph.anchors[0].T_world_map.R, chain.graph.anchors[0].T_world_map.R);
  EXPECT_EQ(result->graph.anchors[0].T_world_map.t, chain.graph.anchors[0].T_world_map.t);
}

TEST(Maps, GapEdgeJoinsMapsAsFarAsItsCovarianceReaches) {
  Chain chain = in_two_maps({.loop_every = 0}, kFarAway);
  Edge gap = true_edge(chain, 99, 100, EdgeKind::kGap, diagonal_information(0.01, 0.5));
  chain.graph.edges.push_back(gap);
  const auto result = optimize(chain.graph);
  ASSERT_TRUE(result.ok());
  // Nothing contradicts the only link, so that it is met exactly.
  EXPECT_LT(result->report.final.of_kind[static_cast<std::size_t>(EdgeKind::kGap)], 1e-9);
  EXPECT_EQ(result->report.dof, 0);
  EXPECT_TRUE(result->report.unconnected_maps.empty());
}

void add_gravity(Chain& chain, int every, double sigma, std::uint64_t seed) {
  math::Random random(seed);
  for (std::size_t i = 0; i < chain.graph.nodes.size(); i += static_cast<std::size_t>(every)) {
    const Vector3d up = chain.T_world_node[i].R.transpose() * Vector3d::UnitZ();
    const Vector3d noisy_up = math::so3_exp(sigma * random.normal3()) * up;
    chain.graph.gravity.push_back({.node = chain.graph.nodes[i].id, .up_node = noisy_up, .sigma = sigma});
  }
}

double largest_tilt_error(const PoseGraph& graph, const std::vector<SE3>& truth) {
  const std::vector<SE3> poses = poses_of(graph);
  double largest = 0.0;
  for (std::size_t i = 0; i < poses.size(); ++i) {
    const Vector3d up = poses[i].R.transpose() * Vector3d::UnitZ();
    largest = std::max(largest, (up - truth[i].R.transpose() * Vector3d::UnitZ()).norm());
  }
  return largest;
}

TEST(Gravity, RemovesTheDriftOfTilt) {
  for (std::uint64_t seed = 1; seed <= 3; ++seed) {
    Chain chain =
        make_chain({.num_nodes = 400, .rotation_sigma = 0.3 * kDegree, .loop_every = 0, .seed = seed});
    const double before = largest_tilt_error(chain.graph, chain.T_world_node);
    add_gravity(chain, 5, 0.4 * kDegree, seed);
    const auto result = optimize(chain.graph);
    ASSERT_TRUE(result.ok());
    EXPECT_GT(before, 3.0 * kDegree);  // 400 steps of 0.3 deg: 6 deg about each axis at the end
    // Between two senses of 0.4 deg lie steps of 0.3 deg: no worse than 0.5 deg per axis; four deviations.
    EXPECT_LT(largest_tilt_error(result->graph, chain.T_world_node), 2.0 * kDegree);
    EXPECT_EQ(result->report.dof, 2 * 80 - 2);  // two directions each; the tilt of the whole is estimated
  }
}

TEST(Gravity, LevelsTheFirstNodeToo) {
  Chain chain = make_chain({.loop_every = 0});
  const SE3 tilted{math::so3_exp({0.05, -0.03, 0.0}), Vector3d::Zero()};
  for (Node& node : chain.graph.nodes) node.T_map_node = tilted * node.T_map_node;
  add_gravity(chain, 1, 1e-4, 1);
  const auto result = optimize(chain.graph);
  ASSERT_TRUE(result.ok());
  EXPECT_LT(largest_tilt_error(result->graph, chain.T_world_node), 5e-4);  // five deviations of the sense
  // Where it is and its heading are nobody's business: the node that holds the graph keeps its place.
  EXPECT_LT((result->graph.nodes[0].T_map_node.t - chain.graph.nodes[0].T_map_node.t).norm(), 1e-12);
}

TEST(Gravity, KeepsTheAnchorsOfMergedMapsLevel) {
  Chain chain = in_two_maps({.rotation_sigma = 0.01, .seed = 2}, kFarAway);
  add_gravity(chain, 2, 0.3 * kDegree, 2);
  const auto result = optimize(chain.graph);
  ASSERT_TRUE(result.ok());
  EXPECT_LT((result->graph.anchors[1].T_world_map.R.col(2) - Vector3d::UnitZ()).norm(), 1e-12);
  EXPECT_LT(largest_tilt_error(result->graph, chain.T_world_node), 2.0 * kDegree);
}

TEST(Gravity, MapWhoseOnlyMergeIsRejectedStaysAndIsReported) {
  Chain chain = in_two_maps(
      {.num_nodes = 60, .rotation_sigma = 0.0, .translation_sigma = 0.0, .loop_every = 0}, kFarAway);
  const SE3 T_world_b{math::so3_exp({0.0, 0.0, -1.0}), {-20.0, 5.0, 1.0}};
  chain.graph.anchors[1].T_world_map = T_world_b;
  for (std::size_t i = 0; i < 60; ++i) {
    // The truth is where the maps stand: noise-free, only the merge is wrong.
    const SE3 T = chain.graph.anchors[i < 30 ? 0 : 1].T_world_map * chain.graph.nodes[i].T_map_node;
    const Vector3d up = T.R.transpose() * Vector3d::UnitZ();
    chain.graph.gravity.push_back(
        {.node = static_cast<std::int64_t>(i), .up_node = up, .sigma = 0.3 * kDegree});
  }
  Edge merge = true_edge(chain, 3, 40, EdgeKind::kMerge, diagonal_information(0.002, 0.02));
  merge.T_from_to.R = merge.T_from_to.R * math::so3_exp({1.0, 0.0, 0.0});  // on its side
  chain.graph.edges.push_back(merge);
  const auto result = optimize(chain.graph);
  ASSERT_TRUE(result.ok());
  EXPECT_EQ(result->report.num_rejected, 1);
  EXPECT_EQ(result->report.unconnected_maps, std::vector<int>{1});
  EXPECT_EQ(result->graph.anchors[1].T_world_map.t, T_world_b.t);
  EXPECT_LT(largest_position_error(poses_of(result->graph), poses_of(chain.graph)), 1e-6);
}

TEST(Maps, GapUnderCauchyYieldsToMerges) {
  Chain chain = in_two_maps({.rotation_sigma = 0.0, .translation_sigma = 0.0}, kFarAway);
  Edge gap = true_edge(chain, 99, 100, EdgeKind::kGap, diagonal_information(1e-4, 1e-3));
  gap.T_from_to.t.x() += 1.0;  // overconfident: a metre at a millimetre
  chain.graph.edges.push_back(gap);
  const auto believed = optimize(chain.graph, {.robust = false});
  const auto doubted = optimize(chain.graph, {.robust = false, .gap_cauchy = 1.0});
  ASSERT_TRUE(believed.ok() && doubted.ok());
  EXPECT_LT(rms_position_error(poses_of(doubted->graph), chain.T_world_node),
            0.1 * rms_position_error(poses_of(believed->graph), chain.T_world_node));
}

}  // namespace
}  // namespace mmlins::graph
