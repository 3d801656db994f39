// SPDX-License-Identifier: MIT
#include "mmlins/graph/place_maps.hpp"

#include <algorithm>
#include <cmath>

#include "mmlins/graph/gnc.hpp"

namespace mmlins::graph {
namespace {

constexpr std::size_t kMaxCandidates = 100;  ///< evenly chosen among the edges; each is scored on all edges
constexpr double kClearlyBetter = 0.95;      ///< a map is moved for no less

class MapPlacer {
 public:
  MapPlacer(const PoseGraph& graph, const GraphIndex& index)
      : graph_(graph),
        index_(index),
        poses_(world_poses(graph, index)),
        placed_(graph.anchors.size(), false) {
    placed_[static_cast<std::size_t>(index.fixed_anchor)] = true;
    for (std::size_t i = 0; i < graph.nodes.size(); ++i) {
      if (graph.nodes[i].held) placed_[anchor_of(static_cast<int>(i))] = true;
    }
    for (std::size_t e = 0; e < graph.edges.size(); ++e) {
      const bool joins = anchor_of(index.ends[e].from) != anchor_of(index.ends[e].to);
      if (joins && index.roots[e].rank > 0) joints_.push_back(e);
    }
  }

  /// Places the map that most edges join to what is placed. @return false if there is none
  bool place_next() {
    std::vector<int> votes(placed_.size(), 0);
    for (const std::size_t e : joints_) {
      const std::size_t from = anchor_of(index_.ends[e].from);
      const std::size_t to = anchor_of(index_.ends[e].to);
      if (placed_[from] != placed_[to]) ++votes[placed_[from] ? to : from];
    }
    const auto best = std::max_element(votes.begin(), votes.end());
    if (best == votes.end() || *best == 0) return false;
    place(static_cast<std::size_t>(best - votes.begin()));
    return true;
  }

  std::vector<SE3> take_poses() { return std::move(poses_); }

 private:
  std::size_t anchor_of(int node) const {
    return static_cast<std::size_t>(index_.anchor_of_node[static_cast<std::size_t>(node)]);
  }
  const SE3& pose(int node) const { return poses_[static_cast<std::size_t>(node)]; }

  /// The rigid motion of the map that brings this edge to no error.
  SE3 correction_by(std::size_t e, bool moves_to) const {
    const EdgeEnds& ends = index_.ends[e];
    const SE3& T_from_to = graph_.edges[e].T_from_to;
    if (moves_to) return pose(ends.from) * T_from_to * pose(ends.to).inverse();
    return pose(ends.to) * T_from_to.inverse() * pose(ends.from).inverse();
  }

  /// Disagreement of all edges between the map and what is placed, after the motion. Logarithms: many edges
  /// that nearly agree count for more than one that agrees fully.
  double score(const std::vector<std::size_t>& edges, std::size_t map, const SE3& correction) const {
    double sum = 0.0;
    for (const std::size_t e : edges) {
      const EdgeEnds& ends = index_.ends[e];
      const bool moves_to = anchor_of(ends.to) == map;
      const SE3 T_world_from = moves_to ? pose(ends.from) : correction * pose(ends.from);
      const SE3 T_world_to = moves_to ? correction * pose(ends.to) : pose(ends.to);
      const Vector6d e_white =
          index_.roots[e].S * edge_error(T_world_from, T_world_to, graph_.edges[e].T_from_to);
      sum += std::log1p(e_white.squaredNorm() / chi2_limit(index_.roots[e].rank));
    }
    return sum;
  }

  void place(std::size_t map) {
    std::vector<std::size_t> edges;
    std::vector<std::size_t> whole;  // edges that determine all six directions
    for (const std::size_t e : joints_) {
      const std::size_t from = anchor_of(index_.ends[e].from);
      const std::size_t to = anchor_of(index_.ends[e].to);
      const bool relevant = (from == map && placed_[to]) || (to == map && placed_[from]);
      if (!relevant) continue;
      edges.push_back(e);
      if (index_.roots[e].rank == 6) whole.push_back(e);
    }
    const std::vector<std::size_t>& candidates = whole.empty() ? edges : whole;
    const std::size_t stride = (candidates.size() + kMaxCandidates - 1) / kMaxCandidates;
    SE3 best;
    double best_score = kClearlyBetter * score(edges, map, best);
    for (std::size_t i = 0; i < candidates.size(); i += stride) {
      const std::size_t e = candidates[i];
      const SE3 correction = correction_by(e, anchor_of(index_.ends[e].to) == map);
      const double candidate_score = score(edges, map, correction);
      if (candidate_score < best_score) {
        best = correction;
        best_score = candidate_score;
      }
    }
    for (std::size_t i = 0; i < poses_.size(); ++i) {
      if (anchor_of(static_cast<int>(i)) == map) poses_[i] = best * poses_[i];
    }
    placed_[map] = true;
  }

  const PoseGraph& graph_;
  const GraphIndex& index_;
  std::vector<SE3> poses_;
  std::vector<bool> placed_;
  std::vector<std::size_t> joints_;  ///< edges between maps
};

}  // namespace

std::vector<SE3> place_maps(const PoseGraph& graph, const GraphIndex& index) {
  MapPlacer placer(graph, index);
  while (placer.place_next()) {
  }
  return placer.take_poses();
}

}  // namespace mmlins::graph
