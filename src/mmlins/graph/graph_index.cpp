// SPDX-License-Identifier: MIT
#include "mmlins/graph/graph_index.hpp"

#include <cmath>
#include <numeric>
#include <unordered_map>

namespace mmlins::graph {
namespace {

constexpr double kRotationTolerance = 1e-6;  ///< of R^T R and of unit vectors

bool is_pose(const SE3& T) {
  if (!T.R.allFinite() || !T.t.allFinite() || !(T.R.determinant() > 0.0)) return false;
  return (T.R.transpose() * T.R - math::Matrix3d::Identity()).cwiseAbs().maxCoeff() < kRotationTolerance;
}

using Positions = std::unordered_map<std::int64_t, int>;

Result<Positions> index_anchors(const PoseGraph& graph, GraphIndex& index) {
  Positions positions;
  int num_fixed = 0;
  for (std::size_t i = 0; i < graph.anchors.size(); ++i) {
    const Anchor& anchor = graph.anchors[i];
    if (!positions.emplace(anchor.map, static_cast<int>(i)).second) {
      return make_error(ErrorCode::kInvalid, "pose graph: map {} has two anchors; give it one", anchor.map);
    }
    if (!is_pose(anchor.T_world_map)) {
      return make_error(ErrorCode::kInvalid, "pose graph: the anchor of map {} is no rigid transform",
                        anchor.map);
    }
    if (anchor.fixed) index.fixed_anchor = static_cast<int>(i);
    num_fixed += anchor.fixed ? 1 : 0;
  }
  if (num_fixed != 1) {
    return make_error(ErrorCode::kInvalid, "pose graph: {} of {} anchors are fixed; fix exactly one",
                      num_fixed, graph.anchors.size());
  }
  return positions;
}

Result<Positions> index_nodes(const PoseGraph& graph, const Positions& anchors, GraphIndex& index) {
  Positions positions;
  positions.reserve(graph.nodes.size());
  for (const Node& node : graph.nodes) {
    const auto anchor = anchors.find(node.map);
    if (anchor == anchors.end()) {
      return make_error(ErrorCode::kInvalid, "pose graph: node {} lies in map {}, which has no anchor",
                        node.id, node.map);
    }
    if (!positions.emplace(node.id, static_cast<int>(positions.size())).second) {
      return make_error(ErrorCode::kInvalid, "pose graph: two nodes have the id {}", node.id);
    }
    if (!is_pose(node.T_map_node)) {
      return make_error(ErrorCode::kInvalid, "pose graph: the pose of node {} is no rigid transform",
                        node.id);
    }
    index.anchor_of_node.push_back(anchor->second);
  }
  return positions;
}

Status index_edge(const Edge& edge, const Positions& nodes, GraphIndex& index) {
  for (const std::int64_t id : {edge.from, edge.to}) {
    if (nodes.count(id) == 0) {
      return make_error(ErrorCode::kInvalid, "pose graph: edge {} -> {}: there is no node {}", edge.from,
                        edge.to, id);
    }
  }
  if (edge.from == edge.to) {
    return make_error(ErrorCode::kInvalid, "pose graph: edge {} -> {} joins a node to itself", edge.from,
                      edge.to);
  }
  if (!is_pose(edge.T_from_to)) {
    return make_error(ErrorCode::kInvalid, "pose graph: edge {} -> {} is no rigid transform", edge.from,
                      edge.to);
  }
  if (!is_information(edge.information)) {
    return make_error(
        ErrorCode::kInvalid,
        "pose graph: edge {} -> {}: the information is not symmetric, finite and without negative "
        "eigenvalues",
        edge.from, edge.to);
  }
  index.ends.push_back({nodes.at(edge.from), nodes.at(edge.to)});
  index.roots.push_back(square_root(edge.information));
  return {};
}

Status index_gravity(const GravityFactor& factor, const Positions& nodes, GraphIndex& index) {
  const auto node = nodes.find(factor.node);
  if (node == nodes.end()) {
    return make_error(ErrorCode::kInvalid, "pose graph: a gravity factor names node {}, which does not exist",
                      factor.node);
  }
  if (!(std::abs(factor.up_node.norm() - 1.0) < kRotationTolerance) || !(factor.sigma > 0.0) ||
      !std::isfinite(factor.sigma)) {
    return make_error(
        ErrorCode::kInvalid,
        "pose graph: the gravity factor of node {} wants a unit vector and a positive deviation",
        factor.node);
  }
  index.node_of_gravity.push_back(node->second);
  return {};
}

/// Disjoint sets whose representative is their first member.
class Sets {
 public:
  explicit Sets(std::size_t size) : parent_(size) { std::iota(parent_.begin(), parent_.end(), 0); }
  int find(int i) {
    while (parent_[static_cast<std::size_t>(i)] != i) {
      int& parent = parent_[static_cast<std::size_t>(i)];
      parent = parent_[static_cast<std::size_t>(parent)];
      i = parent;
    }
    return i;
  }
  void join(int a, int b) {
    const int first = std::min(find(a), find(b));
    const int second = std::max(find(a), find(b));
    parent_[static_cast<std::size_t>(second)] = first;
  }

 private:
  std::vector<int> parent_;
};

int number_parts(const GraphIndex& index, const std::vector<double>& weights,
                 std::vector<int>& part_of_node) {
  Sets sets(part_of_node.size());
  for (std::size_t e = 0; e < index.ends.size(); ++e) {
    if (weights[e] >= 0.5 && index.roots[e].rank > 0) sets.join(index.ends[e].from, index.ends[e].to);
  }
  int num_parts = 0;
  for (std::size_t i = 0; i < part_of_node.size(); ++i) {
    const int first = sets.find(static_cast<int>(i));
    part_of_node[i] =
        first == static_cast<int>(i) ? num_parts++ : part_of_node[static_cast<std::size_t>(first)];
  }
  return num_parts;
}

}  // namespace

Result<GraphIndex> index_graph(const PoseGraph& graph) {
  GraphIndex index;
  const Result<Positions> anchors = index_anchors(graph, index);
  if (!anchors) return anchors.error();
  const Result<Positions> nodes = index_nodes(graph, *anchors, index);
  if (!nodes) return nodes.error();
  for (const Edge& edge : graph.edges) {
    const Status status = index_edge(edge, *nodes, index);
    if (!status) return status.error();
  }
  for (const GravityFactor& factor : graph.gravity) {
    const Status status = index_gravity(factor, *nodes, index);
    if (!status) return status.error();
  }
  return index;
}

Parts find_parts(const PoseGraph& graph, const GraphIndex& index, const std::vector<double>& weights) {
  const std::size_t num_nodes = graph.nodes.size();
  Parts parts;
  parts.part_of_node.resize(num_nodes);
  parts.freedom.assign(num_nodes, Freedom::kFree);
  const auto num_parts = static_cast<std::size_t>(number_parts(index, weights, parts.part_of_node));
  parts.held_node.assign(num_parts, -1);
  parts.has_gravity.assign(num_parts, false);
  parts.anchored.assign(num_parts, false);
  const auto part_of = [&parts](std::size_t node) {
    return static_cast<std::size_t>(parts.part_of_node[node]);
  };

  for (const int node : index.node_of_gravity)
    parts.has_gravity[part_of(static_cast<std::size_t>(node))] = true;
  std::vector<int> size(num_parts, 0);
  bool seen_fixed_map = false;
  for (std::size_t i = 0; i < num_nodes; ++i) {
    ++size[part_of(i)];
    const bool first_of_fixed_map = !seen_fixed_map && index.anchor_of_node[i] == index.fixed_anchor;
    seen_fixed_map = seen_fixed_map || first_of_fixed_map;
    if (graph.nodes[i].held) parts.freedom[i] = Freedom::kHeld;
    if (graph.nodes[i].held || first_of_fixed_map) {
      if (!parts.anchored[part_of(i)] || graph.nodes[i].held)
        parts.held_node[part_of(i)] = static_cast<int>(i);
      parts.anchored[part_of(i)] = true;
    }
    if (parts.held_node[part_of(i)] < 0) parts.held_node[part_of(i)] = static_cast<int>(i);
  }
  for (std::size_t p = 0; p < num_parts; ++p) {
    const auto node = static_cast<std::size_t>(parts.held_node[p]);
    if (parts.freedom[node] == Freedom::kHeld) continue;
    parts.freedom[node] = parts.has_gravity[p] && size[p] > 1 ? Freedom::kTiltOnly : Freedom::kHeld;
  }
  return parts;
}

std::vector<SE3> world_poses(const PoseGraph& graph, const GraphIndex& index) {
  std::vector<SE3> poses;
  poses.reserve(graph.nodes.size());
  for (std::size_t i = 0; i < graph.nodes.size(); ++i) {
    const Anchor& anchor = graph.anchors[static_cast<std::size_t>(index.anchor_of_node[i])];
    poses.push_back(anchor.T_world_map * graph.nodes[i].T_map_node);
  }
  return poses;
}

}  // namespace mmlins::graph
