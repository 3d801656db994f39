// SPDX-License-Identifier: MIT
#pragma once
// Graphs with a known truth: a walk in circles that climbs, tilts and revisits its places every lap.

#include <algorithm>
#include <cmath>
#include <numbers>
#include <vector>

#include "mmlins/graph/optimize.hpp"
#include "mmlins/graph/residuals.hpp"
#include "mmlins/math/random.hpp"

namespace mmlins::graph {

struct ChainSpec {
  int num_nodes = 200;
  int nodes_per_lap = 50;
  double rotation_sigma = 0.002;    ///< of odometry [rad]
  double translation_sigma = 0.02;  ///< [m]
  int loop_every = 5;               ///< a loop to the lap before from every so many nodes; 0: none
  std::uint64_t seed = 1;
};

struct Chain {
  std::vector<SE3> T_world_node;  ///< truth, by position in graph.nodes
  PoseGraph graph;
};

inline SE3 true_pose(int i, int nodes_per_lap) {
  const double angle = 2.0 * std::numbers::pi * i / nodes_per_lap;
  const double radius = nodes_per_lap / (2.0 * std::numbers::pi);
  const Vector3d tilt(0.1 * std::sin(3.0 * angle), 0.1 * std::cos(2.0 * angle), 0.0);
  const math::Matrix3d R = math::so3_exp({0.0, 0.0, angle + 0.5 * std::numbers::pi}) * math::so3_exp(tilt);
  return {R, {radius * std::cos(angle), radius * std::sin(angle), 0.3 * std::sin(angle) + 0.002 * i}};
}

inline Matrix6d diagonal_information(double rotation_sigma, double translation_sigma) {
  Vector6d information;
  information << Vector3d::Constant(1.0 / (rotation_sigma * rotation_sigma)),
      Vector3d::Constant(1.0 / (translation_sigma * translation_sigma));
  return information.asDiagonal();
}

/// The measurement whose error against the truth is `e`.
inline SE3 measurement_with_error(const SE3& T_true, const Vector6d& e) {
  const math::Matrix3d R = T_true.R * math::so3_exp(-e.head<3>());
  return {R, T_true.t - R * e.tail<3>()};
}

inline SE3 noisy(const SE3& T_true, double rotation_sigma, double translation_sigma, math::Random& random) {
  Vector6d e;
  e.head<3>() = rotation_sigma * random.normal3();
  e.tail<3>() = translation_sigma * random.normal3();
  return measurement_with_error(T_true, e);
}

inline Edge true_edge(const Chain& chain, int from, int to, EdgeKind kind, const Matrix6d& information) {
  const SE3 T = chain.T_world_node[static_cast<std::size_t>(from)].inverse() *
                chain.T_world_node[static_cast<std::size_t>(to)];
  const bool robust = kind == EdgeKind::kLoop || kind == EdgeKind::kMerge;
  return {.from = from, .to = to, .T_from_to = T, .information = information, .kind = kind, .robust = robust};
}

/// Nodes 0, 1, ... of map 0 at the poses that the noisy odometry alone gives. A sigma of 0 stands for
/// noise-free measurements that are given the information of 1 mm and 1 mrad.
inline Chain make_chain(const ChainSpec& spec) {
  Chain chain;
  math::Random random(spec.seed);
  const double rotation_sigma = spec.rotation_sigma > 0.0 ? spec.rotation_sigma : 1e-3;
  const double translation_sigma = spec.translation_sigma > 0.0 ? spec.translation_sigma : 1e-3;
  const Matrix6d information = diagonal_information(rotation_sigma, translation_sigma);
  chain.graph.anchors = {{.map = 0, .T_world_map = {}, .fixed = true}};
  for (int i = 0; i < spec.num_nodes; ++i) chain.T_world_node.push_back(true_pose(i, spec.nodes_per_lap));
  SE3 T = chain.T_world_node[0];
  chain.graph.nodes.push_back({.id = 0, .T_map_node = T});
  for (int i = 1; i < spec.num_nodes; ++i) {
    Edge edge = true_edge(chain, i - 1, i, EdgeKind::kOdometry, information);
    edge.T_from_to = noisy(edge.T_from_to, spec.rotation_sigma, spec.translation_sigma, random);
    T = T * edge.T_from_to;
    chain.graph.nodes.push_back({.id = i, .T_map_node = T});
    chain.graph.edges.push_back(edge);
  }
  for (int i = spec.nodes_per_lap; spec.loop_every > 0 && i < spec.num_nodes; i += spec.loop_every) {
    Edge edge = true_edge(chain, i - spec.nodes_per_lap, i, EdgeKind::kLoop, information);
    edge.T_from_to = noisy(edge.T_from_to, spec.rotation_sigma, spec.translation_sigma, random);
    chain.graph.edges.push_back(edge);
  }
  return chain;
}

/// Poses in the world, by position.
inline std::vector<SE3> poses_of(const PoseGraph& graph) {
  std::vector<SE3> poses;
  for (const Node& node : graph.nodes) {
    const auto anchor = std::find_if(graph.anchors.begin(), graph.anchors.end(),
                                     [&node](const Anchor& a) { return a.map == node.map; });
    poses.push_back(anchor->T_world_map * node.T_map_node);
  }
  return poses;
}

inline double largest_position_error(const std::vector<SE3>& poses, const std::vector<SE3>& truth) {
  double largest = 0.0;
  for (std::size_t i = 0; i < truth.size(); ++i)
    largest = std::max(largest, (poses[i].t - truth[i].t).norm());
  return largest;
}
inline double rms_position_error(const std::vector<SE3>& poses, const std::vector<SE3>& truth) {
  double sum = 0.0;
  for (std::size_t i = 0; i < truth.size(); ++i) sum += (poses[i].t - truth[i].t).squaredNorm();
  return std::sqrt(sum / static_cast<double>(truth.size()));
}
inline double largest_rotation_error(const std::vector<SE3>& poses, const std::vector<SE3>& truth) {
  double largest = 0.0;
  for (std::size_t i = 0; i < truth.size(); ++i) {
    largest = std::max(largest, math::so3_log(math::Matrix3d(poses[i].R.transpose() * truth[i].R)).norm());
  }
  return largest;
}

}  // namespace mmlins::graph
