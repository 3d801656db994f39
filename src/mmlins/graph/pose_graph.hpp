// SPDX-License-Identifier: MIT
#pragma once
// A pose graph of one or several maps, as plain data. Poses of nodes are relative to their map; one anchor
// per map says where it lies in the world. Equations: docs/math/pose_graph.md.

#include <array>
#include <cstdint>
#include <string_view>
#include <vector>

#include "mmlins/math/se3.hpp"

namespace mmlins::graph {

using math::Matrix6d;
using math::SE3;
using math::Vector3d;
using math::Vector6d;

/// A pose to be estimated. Ids are unique in the whole graph.
struct Node {
  std::int64_t id = 0;
  int map = 0;
  SE3 T_map_node;
  bool held = false;  ///< known: its pose in the world does not change
};

/// Where a map lies in the world, z up.
struct Anchor {
  int map = 0;
  SE3 T_world_map;
  bool fixed = false;  ///< the gauge: true for exactly one map of the graph
};

enum class EdgeKind {
  kOdometry,
  kLoop,   ///< within a map
  kMerge,  ///< between two maps
  kGap,    ///< what the IMU alone knows between the end of a map and the start of the next
};
inline constexpr int kNumEdgeKinds = 4;
inline constexpr std::array<std::string_view, kNumEdgeKinds> kEdgeKindNames{"odometry", "loop", "merge",
                                                                            "gap"};

/// A measured pose of node `to` in the frame of node `from`: T = T_from_to Exp(e), where e = [rotation [rad];
/// translation [m], expressed in the measured frame of `to`] has the given information (inverse covariance).
/// Directions of zero information are allowed: nothing is known of them.
struct Edge {
  std::int64_t from = 0;
  std::int64_t to = 0;
  SE3 T_from_to;
  Matrix6d information = Matrix6d::Identity();
  EdgeKind kind = EdgeKind::kOdometry;
  /// May turn out to be false; then it loses its weight. Only loops and merges: odometry and gaps are never
  /// robust.
  bool robust = false;
  std::int64_t provenance = 0;  ///< whatever the maker needs to find its origin again
};

/// The upward direction as a node senses it.
struct GravityFactor {
  std::int64_t node = 0;
  Vector3d up_node = Vector3d::UnitZ();  ///< unit vector
  double sigma = 0.01;                   ///< standard deviation per axis [rad]
};

struct PoseGraph {
  std::vector<Anchor> anchors;
  std::vector<Node> nodes;
  std::vector<Edge> edges;
  std::vector<GravityFactor> gravity;
};

}  // namespace mmlins::graph
