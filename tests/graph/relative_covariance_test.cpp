// SPDX-License-Identifier: MIT
#include "mmlins/graph/relative_covariance.hpp"

#include <gtest/gtest.h>

#include "tests/graph/chains.hpp"

namespace mmlins::graph {
namespace {

RelativeCovariance covariance_of(const PoseGraph& graph, std::int64_t i, std::int64_t j) {
  const auto result = relative_covariance(graph, i, j);
  EXPECT_TRUE(result.ok());
  return *result;
}

/// Every edge's covariance, carried to the last node by the adjoint of what lies between.
Matrix6d carried_along(const PoseGraph& graph, int from, int to) {
  Matrix6d sum = Matrix6d::Zero();
  for (int k = from; k < to; ++k) {
    const SE3 T_last_k = graph.nodes[static_cast<std::size_t>(to)].T_map_node.inverse() *
                         graph.nodes[static_cast<std::size_t>(k + 1)].T_map_node;
    const Matrix6d Ad = math::adjoint(T_last_k);
    sum += Ad * graph.edges[static_cast<std::size_t>(k)].information.inverse() * Ad.transpose();
  }
  return sum;
}

TEST(RelativeCovariance, OfAChainIsTheSumOfItsEdges) {
  const Chain chain = make_chain({.num_nodes = 60, .loop_every = 0});
  for (const auto& [i, j] : {std::pair{0, 1}, {0, 59}, {10, 40}}) {
    const RelativeCovariance result = covariance_of(chain.graph, i, j);
    const Matrix6d expected = carried_along(chain.graph, i, j);
    ASSERT_EQ(result.status, CovarianceStatus::kKnown);
    EXPECT_LT((result.covariance - expected).norm(), 1e-8 * expected.norm());
  }
}

TEST(RelativeCovariance, OfTwoEqualChainsIsHalfOfOne) {
  Chain chain = make_chain({.num_nodes = 40, .loop_every = 0});
  const Matrix6d one = covariance_of(chain.graph, 3, 30).covariance;
  const std::vector<Edge> edges = chain.graph.edges;
  chain.graph.edges.insert(chain.graph.edges.end(), edges.begin(), edges.end());
  EXPECT_LT((covariance_of(chain.graph, 3, 30).covariance - 0.5 * one).norm(), 1e-8 * one.norm());
}

TEST(RelativeCovariance, SeenFromTheOtherEndIsCarriedByTheAdjoint) {
  const Chain chain = make_chain({});
  const RelativeCovariance there = covariance_of(chain.graph, 20, 130);
  const RelativeCovariance back = covariance_of(chain.graph, 130, 20);
  const Matrix6d Ad = math::adjoint(there.T_i_j);
  EXPECT_LT((Ad * there.covariance * Ad.transpose() - back.covariance).norm(), 1e-8 * back.covariance.norm());
}

TEST(RelativeCovariance, DoesNotDependOnTheGauge) {
  Chain chain = make_chain({});
  const Matrix6d first = covariance_of(chain.graph, 20, 130).covariance;
  std::reverse(chain.graph.nodes.begin(), chain.graph.nodes.end());  // now the last node is held
  EXPECT_LT((covariance_of(chain.graph, 20, 130).covariance - first).norm(), 1e-8 * first.norm());
}

TEST(RelativeCovariance, GravityMakesTiltKnownAndLeavesHeadingOpen) {
  Chain chain = make_chain({.num_nodes = 100, .loop_every = 0});
  const Matrix6d without = covariance_of(chain.graph, 0, 99).covariance;
  for (int i = 0; i < 100; ++i) {
    const Vector3d up =
        chain.graph.nodes[static_cast<std::size_t>(i)].T_map_node.R.transpose() * Vector3d::UnitZ();
    chain.graph.gravity.push_back({.node = i, .up_node = up, .sigma = 1e-4});
  }
  const Matrix6d with = covariance_of(chain.graph, 0, 99).covariance;
  const Vector3d up = chain.graph.gravity.back().up_node;
  const Vector3d side = up.unitOrthogonal();
  EXPECT_LT(side.dot(with.topLeftCorner<3, 3>() * side), 4e-8);  // two senses of 1e-4 at most
  const double heading = up.dot(with.topLeftCorner<3, 3>() * up);
  EXPECT_NEAR(heading, up.dot(without.topLeftCorner<3, 3>() * up), 0.05 * heading);
}

TEST(RelativeCovariance, SaysWhatIsUnconnectedUndeterminedOrUnknown) {
  Chain chain = make_chain({.num_nodes = 10, .loop_every = 0});
  chain.graph.nodes.push_back({.id = 77, .T_map_node = {}});
  EXPECT_EQ(covariance_of(chain.graph, 2, 77).status, CovarianceStatus::kUnconnected);
  chain.graph.nodes.pop_back();
  chain.graph.edges[5].information.row(3).setZero();
  chain.graph.edges[5].information.col(3).setZero();
  EXPECT_EQ(covariance_of(chain.graph, 2, 9).status, CovarianceStatus::kUndetermined);
  const auto unknown = relative_covariance(chain.graph, 2, 500);
  ASSERT_FALSE(unknown.ok());
  EXPECT_NE(unknown.error().message.find("500"), std::string::npos);
}

TEST(RelativeCovariance, IsThatOfRepeatedOptimisations) {
  constexpr int kRuns = 300;
  const ChainSpec spec{.num_nodes = 40, .nodes_per_lap = 20, .loop_every = 10};
  Matrix6d sample = Matrix6d::Zero();
  for (int run = 0; run < kRuns; ++run) {
    ChainSpec seeded = spec;
    seeded.seed = 1000 + static_cast<std::uint64_t>(run);
    const Chain chain = make_chain(seeded);
    const auto result = optimize(chain.graph, {.robust = false});
    ASSERT_TRUE(result.ok());
    const std::vector<SE3> poses = poses_of(result->graph);
    const SE3 T_true = chain.T_world_node[5].inverse() * chain.T_world_node[39];
    const Vector6d e = edge_error(poses[5], poses[39], T_true);
    sample += e * e.transpose() / kRuns;
  }
  const RelativeCovariance predicted = covariance_of(make_chain(spec).graph, 5, 39);
  const Vector6d ratio = sample.diagonal().cwiseQuotient(predicted.covariance.diagonal());
  // A variance out of 300 runs deviates by sqrt(2 / 300) = 0.08; four deviations.
  EXPECT_LT((ratio - Vector6d::Ones()).cwiseAbs().maxCoeff(), 0.33) << ratio.transpose();
}

Edge closure(const Chain& chain, std::uint64_t seed) {
  math::Random random(seed);
  Edge edge = true_edge(chain, 0, 99, EdgeKind::kLoop, diagonal_information(0.002, 0.02));
  edge.T_from_to = noisy(edge.T_from_to, 0.002, 0.02, random);
  return edge;
}

EdgeTest test_last_edge(const PoseGraph& graph, double weight) {
  std::vector<double> weights(graph.edges.size(), 1.0);
  weights.back() = weight;
  const auto tests = test_edges(graph, {graph.edges.size() - 1}, weights);
  EXPECT_TRUE(tests.ok());
  return tests->front();
}

TEST(TestEdges, TrueCandidatesFollowTheChi2Distribution) {
  constexpr int kRuns = 200;
  double sum = 0.0;
  for (std::uint64_t seed = 1; seed <= kRuns; ++seed) {
    Chain chain = make_chain({.num_nodes = 100, .loop_every = 0, .seed = seed});
    chain.graph.edges.push_back(closure(chain, seed + 5000));
    const EdgeTest test = test_last_edge(chain.graph, 0.0);
    ASSERT_EQ(test.status, CovarianceStatus::kKnown);
    ASSERT_EQ(test.rank, 6);
    sum += test.chi2 / kRuns;
  }
  EXPECT_NEAR(sum, 6.0, 1.0);  // the mean of 200 deviates by sqrt(12 / 200) = 0.25; four deviations
}

TEST(TestEdges, GiveTheSameBeforeAndAfterTheEdgeIsBelieved) {
  Chain chain = make_chain({.num_nodes = 100, .loop_every = 0, .seed = 3});
  chain.graph.edges.push_back(closure(chain, 8));
  const double before = test_last_edge(chain.graph, 0.0).chi2;
  const auto optimised = optimize(chain.graph, {.tolerance = 1e-12});
  ASSERT_TRUE(optimised.ok());
  const double after = test_last_edge(optimised->graph, 1.0).chi2;
  EXPECT_NEAR(after, before, 0.05 * before);  // poses have moved by some percent of a radian
}

TEST(TestEdges, RevealALoneFalseLoopToWhichTheGraphHasBent) {
  Chain chain = make_chain({.num_nodes = 100, .loop_every = 0});
  Edge edge = closure(chain, 8);
  edge.T_from_to.t.y() += 5.0;  // odometry knows this way to a metre
  chain.graph.edges.push_back(edge);
  const auto optimised = optimize(chain.graph);
  ASSERT_TRUE(optimised.ok());
  EXPECT_EQ(optimised->report.num_rejected, 0);
  EXPECT_LT(optimised->report.edges.back().chi2, 5.0);  // looks innocent
  EXPECT_GT(test_last_edge(optimised->graph, 1.0).chi2, 50.0);
}

TEST(TestEdges, SayNothingOfAnEdgeThatIsTheOnlyWitness) {
  const Chain chain = make_chain({.num_nodes = 20, .loop_every = 0});
  const auto tests = test_edges(chain.graph, {7});
  ASSERT_TRUE(tests.ok());
  EXPECT_EQ(tests->front().rank, 0);
  EXPECT_EQ(tests->front().chi2, 0.0);
}

}  // namespace
}  // namespace mmlins::graph
