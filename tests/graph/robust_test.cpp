// SPDX-License-Identifier: MIT
#include <gtest/gtest.h>

#include "mmlins/graph/gnc.hpp"
#include "tests/graph/chains.hpp"

namespace mmlins::graph {
namespace {

Edge false_loop(int num_nodes, const Matrix6d& information, math::Random& random) {
  Edge edge;
  edge.from = static_cast<std::int64_t>(random.uniform(0.0, num_nodes / 2));
  edge.to = static_cast<std::int64_t>(random.uniform(num_nodes / 2 + 1, num_nodes));
  edge.T_from_to = {math::so3_exp({0.0, 0.0, random.uniform(-3.0, 3.0)}), 2.0 * random.normal3()};
  edge.information = information;
  edge.kind = EdgeKind::kLoop;
  edge.robust = true;
  return edge;
}

TEST(Gnc, WeightsBeginNearlyEqualAndPartAtTheLimit) {
  const double width = first_width(100.0);
  EXPECT_NEAR(graduated_weight(100.0, width), 4.0 / 9.0, 1e-12);
  EXPECT_NEAR(graduated_weight(0.0, width), 1.0, 1e-12);
  EXPECT_NEAR(graduated_weight(1.0, 1.0), 0.25, 1e-12);
  EXPECT_GT(graduated_weight(0.1, 1.0), 0.8);
  EXPECT_LT(graduated_weight(100.0, 1.0), 1e-4);
}

TEST(Gnc, LimitIsExceededOnceInAThousandTimes) {
  constexpr int kDraws = 200000;
  math::Random random(1);
  for (int rank = 1; rank <= 6; ++rank) {
    int exceeded = 0;
    for (int i = 0; i < kDraws; ++i) {
      double chi2 = 0.0;
      for (int k = 0; k < rank; ++k) chi2 += std::pow(random.normal(), 2);
      exceeded += chi2 > chi2_limit(rank) ? 1 : 0;
    }
    EXPECT_NEAR(exceeded, 200, 60) << rank;  // four deviations of sqrt(200)
  }
}

TEST(Robust, ThirtyPercentFalseLoopsAreRejectedAndTrueOnesKept) {
  for (std::uint64_t seed = 1; seed <= 5; ++seed) {
    Chain chain = make_chain({.num_nodes = 300, .nodes_per_lap = 60, .loop_every = 4, .seed = seed});
    const std::size_t first_false = chain.graph.edges.size();
    const std::size_t num_true = first_false - 299;
    const std::size_t num_false = num_true * 3 / 7;
    const PoseGraph clean = chain.graph;
    math::Random random(100 + seed);
    const Matrix6d information = diagonal_information(0.002, 0.02);
    for (std::size_t i = 0; i < num_false; ++i)
      chain.graph.edges.push_back(false_loop(300, information, random));

    const auto result = optimize(chain.graph);
    ASSERT_TRUE(result.ok());
    int num_true_rejected = 0;
    for (std::size_t e = 0; e < chain.graph.edges.size(); ++e) {
      const bool rejected = result->report.edges[e].weight < 0.5;
      if (e < first_false) {
        num_true_rejected += rejected ? 1 : 0;
      } else {
        EXPECT_TRUE(rejected) << "seed " << seed << ", false loop " << e - first_false;
      }
    }
    // A true edge is rejected once in a thousand times; of 60, twice once in five hundred runs.
    EXPECT_LE(num_true_rejected, 1) << "seed " << seed;
    // The same poses as if the false loops had never been there.
    const auto without = optimize(clean);
    ASSERT_TRUE(without.ok());
    EXPECT_LT(largest_position_error(poses_of(result->graph), poses_of(without->graph)), 1e-3)
        << "seed " << seed;
  }
}

TEST(Robust, LoopsOverALongDriftAreNotTakenForFalseBecauseOfAFewThatAre) {
  Chain chain = make_chain({.num_nodes = 1500, .nodes_per_lap = 300, .loop_every = 10, .seed = 2});
  const std::size_t first_false = chain.graph.edges.size();
  math::Random random(11);
  for (int i = 0; i < 3; ++i)
    chain.graph.edges.push_back(false_loop(1500, diagonal_information(0.002, 0.02), random));
  const auto result = optimize(chain.graph);
  ASSERT_TRUE(result.ok());
  EXPECT_GT(result->report.initial.total / static_cast<double>(chain.graph.edges.size()), 1000.0);
  for (std::size_t e = first_false; e < chain.graph.edges.size(); ++e) {
    EXPECT_EQ(result->report.edges[e].weight, 0.0);
  }
  EXPECT_LE(result->report.num_rejected, 3 + 2);  // of 120 true ones, once in a thousand each
}

TEST(Robust, OdometryIsNeverRejectedEvenIfFlagged) {
  Chain chain = make_chain({});
  Edge& odometry = chain.graph.edges[50];
  odometry.robust = true;
  odometry.T_from_to.t.x() += 5.0;
  const auto result = optimize(chain.graph);
  ASSERT_TRUE(result.ok());
  EXPECT_EQ(result->report.edges[50].weight, 1.0);
}

TEST(Robust, EdgesNotFlaggedAreBelieved) {
  Chain chain = make_chain({});
  chain.graph.edges.back().robust = false;
  chain.graph.edges.back().T_from_to.t.x() += 5.0;
  const auto result = optimize(chain.graph);
  ASSERT_TRUE(result.ok());
  EXPECT_EQ(result->report.edges.back().weight, 1.0);
}

TEST(Robust, MapsJoinedByContradictingEdgesAloneStayWhereTheyAre) {
  Chain chain = make_chain({.num_nodes = 100, .loop_every = 0});
  const SE3 T_world_b{math::so3_exp({0.0, 0.0, 1.0}), {40.0, 0.0, 0.0}};
  chain.graph.anchors.push_back({.map = 1, .T_world_map = T_world_b});
  for (std::size_t i = 50; i < 100; ++i) {
    chain.graph.nodes[i].map = 1;
    chain.graph.nodes[i].T_map_node = T_world_b.inverse() * chain.graph.nodes[i].T_map_node;
  }
  chain.graph.edges.erase(chain.graph.edges.begin() + 49);  // 49 -> 50
  // Merges that contradict each other.
  Edge merge{.from = 10, .to = 60, .T_from_to = {}, .information = diagonal_information(0.01, 0.1)};
  merge.kind = EdgeKind::kMerge;
  merge.robust = true;
  for (int i = 0; i < 4; ++i) {
    merge.to = 60 + 5 * i;
    merge.T_from_to = {math::so3_exp({0.0, 0.0, 1.5 * i}), {30.0 * i, -20.0 * i, 5.0 * i}};
    chain.graph.edges.push_back(merge);
  }
  const auto result = optimize(chain.graph);
  ASSERT_TRUE(result.ok());
  // Any one of the four can be believed alone, never two.
  EXPECT_GE(result->report.num_rejected, 3);
  if (result->report.num_rejected == 4) {
    EXPECT_EQ(result->report.unconnected_maps, std::vector<int>{1});
    EXPECT_LT((result->graph.anchors[1].T_world_map.t - T_world_b.t).norm(), 1e-12);
  }
}

}  // namespace
}  // namespace mmlins::graph
