// SPDX-License-Identifier: MIT
#include "mmlins/graph/g2o.hpp"

#include <gtest/gtest.h>

#include <filesystem>

#include "mmlins/graph/g2o_information.hpp"
#include "tests/graph/chains.hpp"

namespace mmlins::graph {
namespace {

const std::string kInformation = " 1 0 0 0 0 0 1 0 0 0 0 1 0 0 0 4 0 0 4 0 4";
const std::string kTwoVertices = "VERTEX_SE3:QUAT 0 0 0 0 0 0 0 1\nVERTEX_SE3:QUAT 1 1 2 3 0 0 0 1\n";

std::string error_of(const std::string& text) {
  const auto graph = parse_g2o(text, "file.g2o");
  return graph.ok() ? "accepted" : graph.error().message;
}

TEST(G2o, RoundTripKeepsEverythingToANanometre) {
  Chain chain = make_chain({.num_nodes = 80, .seed = 2});
  chain.graph.nodes[3].held = true;
  Matrix6d full;
  for (int i = 0; i < 36; ++i) full(i / 6, i % 6) = 3.0 * std::cos(i) + i;
  chain.graph.edges[5].information = full * full.transpose();
  const auto text = format_g2o(chain.graph);
  ASSERT_TRUE(text.ok());
  const auto again = parse_g2o(*text, "again");
  ASSERT_TRUE(again.ok()) << again.error().message;
  ASSERT_EQ(again->nodes.size(), chain.graph.nodes.size());
  ASSERT_EQ(again->edges.size(), chain.graph.edges.size());
  for (std::size_t i = 0; i < again->nodes.size(); ++i) {
    const SE3 d = again->nodes[i].T_map_node.inverse() * chain.graph.nodes[i].T_map_node;
    EXPECT_LT(d.t.norm() + math::so3_log(d.R).norm(), 1e-9);
    EXPECT_EQ(again->nodes[i].id, chain.graph.nodes[i].id);
    EXPECT_EQ(again->nodes[i].held, i == 3);
  }
  for (std::size_t e = 0; e < again->edges.size(); ++e) {
    const Edge& a = again->edges[e];
    const Edge& b = chain.graph.edges[e];
    const SE3 d = a.T_from_to.inverse() * b.T_from_to;
    EXPECT_LT(d.t.norm() + math::so3_log(d.R).norm(), 1e-9);
    EXPECT_LT((a.information - b.information).norm(), 1e-9 * b.information.norm());
    EXPECT_EQ(a.kind, b.kind);
  }
}

// g2o's error is the translation and the vector part of the quaternion of measurement^-1 * estimate.
TEST(G2o, InformationGivesTheChi2ThatG2oComputes) {
  Matrix6d root;
  for (int i = 0; i < 36; ++i) root(i / 6, i % 6) = std::sin(3.0 * i);
  const Matrix6d g2o = root * root.transpose();
  const SE3 T_error{math::so3_exp({1e-3, -2e-3, 3e-3}), {0.01, 0.02, -0.03}};
  Vector6d g2o_error;
  g2o_error << T_error.t, T_error.quaternion().vec();
  const double expected = g2o_error.dot(g2o * g2o_error);
  const Vector6d e = edge_error({}, T_error, {});
  // 2 sin(w / 2) differs from w by a 24th of its square: 6e-7.
  EXPECT_NEAR(e.dot(from_g2o_information(g2o) * e), expected, 2e-6 * expected);
  EXPECT_LT((to_g2o_information(from_g2o_information(g2o)) - g2o).norm(), 1e-15 * g2o.norm());
}

TEST(G2o, ReadsVerticesAfterEdgesCommentsAndFix) {
  const std::string text =
      "# comment\n\nFIX 1\nEDGE_SE3:QUAT 0 1 1 2 3 0 0 0 1" + kInformation + "\r\n" + kTwoVertices;
  const auto graph = parse_g2o(text, "file.g2o");
  ASSERT_TRUE(graph.ok()) << graph.error().message;
  EXPECT_EQ(graph->edges[0].kind, EdgeKind::kOdometry);
  EXPECT_EQ(graph->edges[0].provenance, 4);
  EXPECT_LT((graph->edges[0].information - Matrix6d::Identity()).norm(), 1e-15);
  EXPECT_TRUE(graph->nodes[1].held);
  EXPECT_EQ(optimize(*graph)->report.final.total, 0.0);
}

TEST(G2o, BadInputIsOneLineThatNamesItsPlace) {
  const std::string edge = "EDGE_SE3:QUAT 0 1 1 2 3 0 0 0 1";
  const auto expect = [](const std::string& text, const std::string& place, const std::string& what) {
    const std::string message = error_of(text);
    EXPECT_EQ(message.find(place), 0u) << message;
    EXPECT_NE(message.find(what), std::string::npos) << message;
    EXPECT_EQ(message.find('\n'), std::string::npos) << message;
  };
  expect("", "file.g2o:", "holds no VERTEX_SE3:QUAT");
  expect(kTwoVertices + "VERTEX_SE2 4 0 0 0\n", "file.g2o:3:", "not supported");
  expect(kTwoVertices + "VERTEX_SE3:QUAT 1 0 0 0 0 0 0 1\n", "file.g2o:3:", "there twice");
  expect(kTwoVertices + "VERTEX_SE3:QUAT 2 0 0 0 0 0 0\n", "file.g2o:3:", "8 values");
  expect(kTwoVertices + "VERTEX_SE3:QUAT 2 0 nan 0 0 0 0 1\n", "file.g2o:3:", "not a finite number");
  expect(kTwoVertices + "VERTEX_SE3:QUAT 2.5 0 0 0 0 0 0 1\n", "file.g2o:3:", "not an integer id");
  expect(kTwoVertices + "VERTEX_SE3:QUAT 2 0 0 0 0 0 0 0\n", "file.g2o:3:", "quaternion of length 0");
  expect(kTwoVertices + edge + " 1 2 3\n", "file.g2o:3:", "30 values");
  expect(kTwoVertices + "EDGE_SE3:QUAT 1 1 1 2 3 0 0 0 1" + kInformation, "file.g2o:3:", "to itself");
  expect(kTwoVertices + "EDGE_SE3:QUAT 1 9 1 2 3 0 0 0 1" + kInformation, "file.g2o:3:", "no vertex 9");
  expect(kTwoVertices + edge + " -1" + kInformation.substr(2), "file.g2o:3:", "negative eigenvalues");
  expect(kTwoVertices + "\nFIX 7\n", "file.g2o:4:", "no vertex 7");
}

TEST(G2o, MissingFileIsNamed) {
  const auto graph = read_g2o("nowhere/graph.g2o");
  ASSERT_FALSE(graph.ok());
  EXPECT_NE(graph.error().message.find("nowhere/graph.g2o"), std::string::npos);
}

TEST(G2o, WritesAllMapsInOneFrame) {
  Chain chain = make_chain({.num_nodes = 4, .loop_every = 0});
  const SE3 T_world_b{math::so3_exp({0.0, 0.0, 1.0}), {10.0, 0.0, 0.0}};
  chain.graph.anchors.push_back({.map = 1, .T_world_map = T_world_b});
  chain.graph.nodes[3].map = 1;
  const std::string path = std::filesystem::temp_directory_path() / "mmlins_two_maps.g2o";
  ASSERT_TRUE(write_g2o(path, chain.graph).ok());
  const auto again = read_g2o(path);
  std::filesystem::remove(path);
  ASSERT_TRUE(again.ok());
  EXPECT_LT((again->nodes[3].T_map_node.t - T_world_b * chain.graph.nodes[3].T_map_node.t).norm(), 1e-9);
}

}  // namespace
}  // namespace mmlins::graph
