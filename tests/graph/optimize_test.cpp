// SPDX-License-Identifier: MIT
#include "mmlins/graph/optimize.hpp"

#include <gtest/gtest.h>

#include <cstring>

#include "tests/graph/chains.hpp"

namespace mmlins::graph {
namespace {

OptimizedGraph optimized(const PoseGraph& graph, const OptimizerConfig& config = {}) {
  Result<OptimizedGraph> result = optimize(graph, config);
  EXPECT_TRUE(result.ok()) << (result.ok() ? "" : result.error().message);
  return std::move(result).value();
}

TEST(Optimize, NoiseFreeLoopIsRecoveredExactly) {
  Chain chain = make_chain({.rotation_sigma = 0.0, .translation_sigma = 0.0});
  math::Random random(7);
  for (std::size_t i = 1; i < chain.graph.nodes.size(); ++i) {
    Vector6d step;
    step << 0.05 * random.normal3(), 0.5 * random.normal3();
    chain.graph.nodes[i].T_map_node = retract(chain.graph.nodes[i].T_map_node, step);
  }
  const OptimizedGraph result = optimized(chain.graph);
  EXPECT_EQ(result.report.status, GraphStatus::kConverged);
  EXPECT_GT(result.report.initial.total, 1e6);
  EXPECT_EQ(result.report.num_rejected, 0);
  // Gauss-Newton ends quadratically; what is left is rounding along two hundred poses.
  EXPECT_LT(result.report.final.total, 1e-9);
  EXPECT_LT(largest_position_error(poses_of(result.graph), chain.T_world_node), 1e-7);
  EXPECT_LT(largest_rotation_error(poses_of(result.graph), chain.T_world_node), 1e-8);
}

TEST(Optimize, NoisyChainHasChi2OfItsDegreesOfFreedomAndBeatsOdometry) {
  double chi2 = 0.0;
  double dof = 0.0;
  for (std::uint64_t seed = 1; seed <= 5; ++seed) {
    const Chain chain = make_chain({.num_nodes = 400, .loop_every = 2, .seed = seed});
    const OptimizedGraph result = optimized(chain.graph);
    EXPECT_EQ(result.report.status, GraphStatus::kConverged);
    // 399 odometry edges and 175 loops of six directions for 399 poses.
    ASSERT_EQ(result.report.dof + 6 * result.report.num_rejected, 6 * 175);
    chi2 += result.report.final.total;
    dof += result.report.dof;
    const double before = rms_position_error(poses_of(chain.graph), chain.T_world_node);
    const double after = rms_position_error(poses_of(result.graph), chain.T_world_node);
    EXPECT_LT(after, 0.8 * before) << "seed " << seed;
  }
  // chi2 / dof over 5250 degrees deviates by sqrt(2 / 5250) = 0.02; four deviations.
  EXPECT_NEAR(chi2 / dof, 1.0, 0.08);
}

TEST(Optimize, ReportsChi2OfEveryKindAndEdge) {
  const Chain chain = make_chain({});
  const GraphReport report = optimized(chain.graph).report;
  double initial = 0.0;
  double last = 0.0;
  for (const EdgeReport& edge : report.edges) {
    initial += edge.initial_chi2;
    last += edge.weight * edge.chi2;
  }
  EXPECT_NEAR(initial, report.initial.total, 1e-9 * initial);
  EXPECT_NEAR(last, report.final.total, 1e-9 * initial);
  EXPECT_NEAR(report.final.of_kind[0] + report.final.of_kind[1], report.final.total, 1e-9 * initial);
  // The nodes begin where odometry puts them: only loops disagree.
  EXPECT_LT(report.initial.of_kind[0], 1e-12);
  EXPECT_EQ(report.num_of_kind[0], 199);
  EXPECT_EQ(report.num_of_kind[1], 30 - report.num_rejected);
}

TEST(Optimize, SameInputGivesTheSameBits) {
  Chain chain = make_chain({.seed = 3});
  chain.graph.edges.back().T_from_to.t.x() += 20.0;  // so that the robust part is run
  const OptimizedGraph first = optimized(chain.graph);
  const OptimizedGraph second = optimized(chain.graph);
  EXPECT_GT(first.report.gnc_rounds, 0);
  for (std::size_t i = 0; i < first.graph.nodes.size(); ++i) {
    const SE3& a = first.graph.nodes[i].T_map_node;
    const SE3& b = second.graph.nodes[i].T_map_node;
    ASSERT_EQ(std::memcmp(a.R.data(), b.R.data(), sizeof(double) * 9), 0);
    ASSERT_EQ(std::memcmp(a.t.data(), b.t.data(), sizeof(double) * 3), 0);
  }
}

// A corridor along x, whose closure sees everything but the way along it.
TEST(Optimize, ClosureWithoutInformationAlongACorridorCorrectsOnlyAcross) {
  PoseGraph graph;
  graph.anchors = {{.map = 0, .T_world_map = {}, .fixed = true}};
  const Matrix6d information = diagonal_information(1e-3, 1e-2);
  const SE3 T_odometry{math::Matrix3d::Identity(), {1.1, 0.02, -0.01}};  // true: 1 m along x
  for (int i = 0; i <= 30; ++i) {
    graph.nodes.push_back({.id = i, .T_map_node = {math::Matrix3d::Identity(), i * T_odometry.t}});
    if (i == 0) continue;
    graph.edges.push_back({.from = i - 1, .to = i, .T_from_to = T_odometry, .information = information});
  }
  Edge closure{.from = 0, .to = 30, .T_from_to = {math::Matrix3d::Identity(), {30.0, 0.0, 0.0}}};
  closure.information = diagonal_information(1e-6, 1e-6);
  closure.information(3, 3) = 0.0;
  closure.kind = EdgeKind::kLoop;
  graph.edges.push_back(closure);

  const OptimizedGraph result = optimized(graph);
  const Vector3d end = result.graph.nodes.back().T_map_node.t;
  EXPECT_EQ(result.report.edges.back().rank, 5);
  EXPECT_NEAR(end.y(), 0.0, 1e-3);
  EXPECT_NEAR(end.z(), 0.0, 1e-3);
  // Sideways bending by 0.6 m over 33 m shortens the way by (0.6 / 33)^2 / 2 of it; nothing else may change
  // x.
  EXPECT_NEAR(end.x(), 33.0, 0.02);
}

TEST(Optimize, UnconnectedNodesAndMapsStayAndAreReported) {
  Chain chain = make_chain({.num_nodes = 100, .nodes_per_lap = 30});
  const SE3 elsewhere{math::so3_exp({0.1, 0.2, 0.3}), {5.0, 6.0, 7.0}};
  chain.graph.nodes.push_back({.id = 1000, .map = 0, .T_map_node = elsewhere});
  chain.graph.anchors.push_back({.map = 4, .T_world_map = elsewhere});
  chain.graph.nodes.push_back({.id = 2000, .map = 4, .T_map_node = elsewhere});
  chain.graph.nodes.push_back({.id = 2001, .map = 4, .T_map_node = elsewhere});
  Edge edge{.from = 2000, .to = 2001, .T_from_to = {math::Matrix3d::Identity(), {1.0, 0.0, 0.0}}};
  chain.graph.edges.push_back(edge);

  const OptimizedGraph result = optimized(chain.graph);
  EXPECT_EQ(result.report.unconnected_nodes, (std::vector<std::int64_t>{1000, 2000, 2001}));
  EXPECT_EQ(result.report.unconnected_maps, std::vector<int>{4});
  const auto moved = [&](std::size_t i) {
    return (result.graph.nodes[i].T_map_node.t - elsewhere.t).norm() +
           (result.graph.nodes[i].T_map_node.R - elsewhere.R).norm();
  };
  constexpr double kRounding = 1e-13;
  EXPECT_LT(moved(100), kRounding);
  EXPECT_LT(moved(101), kRounding);
  EXPECT_LT((result.graph.anchors[1].T_world_map.t - elsewhere.t).norm(), kRounding);
  // Among themselves the nodes of the unconnected map are optimised.
  EXPECT_LT((elsewhere.inverse() * result.graph.nodes[102].T_map_node.t - Vector3d(1, 0, 0)).norm(), 1e-6);
}

TEST(Optimize, HeldNodesStay) {
  Chain chain = make_chain({});
  chain.graph.nodes[70].held = true;
  chain.graph.nodes[70].T_map_node.t.z() += 0.5;
  const OptimizedGraph result = optimized(chain.graph);
  EXPECT_LT((result.graph.nodes[70].T_map_node.t - chain.graph.nodes[70].T_map_node.t).norm(), 1e-13);
  EXPECT_GT(result.graph.nodes[69].T_map_node.t.z(), chain.graph.nodes[69].T_map_node.t.z() + 0.2);
}

TEST(Optimize, WithNothingToEstimateLeavesTheGraphAsItWas) {
  PoseGraph graph;
  graph.anchors = {{.map = 0, .T_world_map = {}, .fixed = true}};
  EXPECT_EQ(optimized(graph).report.status, GraphStatus::kNothingToEstimate);
  graph.nodes.push_back({.id = 5, .T_map_node = {}});
  EXPECT_EQ(optimized(graph).report.status, GraphStatus::kNothingToEstimate);
}

TEST(Optimize, NamesTheFaultOfAGraphThatDoesNotHoldTogether) {
  const Chain chain = make_chain({});
  const auto message = [&](const auto& spoil) {
    PoseGraph graph = chain.graph;
    spoil(graph);
    const auto result = optimize(graph);
    return result.ok() ? "accepted" : result.error().message;
  };
  using G = PoseGraph;
  EXPECT_NE(message([](G& g) { g.edges[3].to = 999; }).find("there is no node 999"), std::string::npos);
  EXPECT_NE(message([](G& g) { g.nodes[3].id = 4; }).find("two nodes have the id 4"), std::string::npos);
  EXPECT_NE(message([](G& g) { g.nodes[3].map = 9; }).find("map 9"), std::string::npos);
  EXPECT_NE(message([](G& g) { g.nodes[3].T_map_node.t.x() = NAN; }).find("node 3"), std::string::npos);
  EXPECT_NE(message([](G& g) { g.edges[3].information *= -1.0; }).find("edge 3 -> 4"), std::string::npos);
  EXPECT_NE(message([](G& g) { g.anchors[0].fixed = false; }).find("fix exactly one"), std::string::npos);
  EXPECT_NE(message([](G& g) { g.gravity.push_back({.node = 3, .sigma = 0.0}); }).find("node 3"),
            std::string::npos);
}

}  // namespace
}  // namespace mmlins::graph
