// SPDX-License-Identifier: MIT
#include "mmlins/graph/optimize.hpp"

#include <algorithm>
#include <cmath>

#include "mmlins/graph/place_maps.hpp"
#include "mmlins/graph/robust_solve.hpp"

namespace mmlins::graph {
namespace {

using math::Matrix3d;

/// The shortest rotation that turns unit vector `from` to `to`.
Matrix3d turn(const Vector3d& from, const Vector3d& to) {
  return Eigen::Quaterniond::FromTwoVectors(from, to).toRotationMatrix();
}

/// Splits the poses in the world into anchors and poses in the maps again.
class MapSplitter {
 public:
  MapSplitter(const PoseGraph& graph, const GraphIndex& index, const RobustSolution& solution)
      : index_(index), parts_(solution.parts), poses_(solution.T_world_node), graph_(graph) {}

  PoseGraph split() && {
    put_back(true);
    for (std::size_t a = 0; a < graph_.anchors.size(); ++a) {
      if (!graph_.anchors[a].fixed) move_anchor(a);
    }
    put_back(false);
    for (std::size_t i = 0; i < poses_.size(); ++i) {
      graph_.nodes[i].T_map_node = anchor_of(i).T_world_map.inverse() * poses_[i];
    }
    return std::move(graph_);
  }

 private:
  std::size_t part_of(std::size_t node) const { return static_cast<std::size_t>(parts_.part_of_node[node]); }
  const Anchor& anchor_of(std::size_t node) const {
    return graph_.anchors[static_cast<std::size_t>(index_.anchor_of_node[node])];
  }

  /// The anchor follows the first node of the map that hangs on the fixed map; without such a node it stays.
  void move_anchor(std::size_t a) {
    for (std::size_t i = 0; i < poses_.size(); ++i) {
      if (index_.anchor_of_node[i] != static_cast<int>(a) || !parts_.anchored[part_of(i)]) continue;
      SE3& T_world_map = graph_.anchors[a].T_world_map;
      const SE3& T_map_node = graph_.nodes[i].T_map_node;
      const Vector3d up_map = T_world_map.R.transpose() * Vector3d::UnitZ();
      T_world_map = poses_[i] * T_map_node.inverse();
      if (!parts_.has_gravity[part_of(i)]) return;
      T_world_map.R = turn(T_world_map.R * up_map, Vector3d::UnitZ()) * T_world_map.R;
      T_world_map.t = poses_[i].t - T_world_map.R * T_map_node.t;
      return;
    }
  }

  /// Moves parts so that the node which holds them is where it was in its map: parts that hang on nothing
  /// have no other place, and in anchored ones tilting to and fro may have turned it about the vertical.
  /// Tilts that gravity corrected stay corrected.
  void put_back(bool anchored) {
    std::vector<SE3> corrections(parts_.held_node.size());
    for (std::size_t p = 0; p < corrections.size(); ++p) {
      const auto held = static_cast<std::size_t>(parts_.held_node[p]);
      if (parts_.anchored[p] != anchored || (anchored && parts_.freedom[held] == Freedom::kHeld)) continue;
      const SE3 T_world_held = anchor_of(held).T_world_map * graph_.nodes[held].T_map_node;
      SE3& correction = corrections[p];
      correction = T_world_held * poses_[held].inverse();
      if (parts_.freedom[held] == Freedom::kTiltOnly) {
        correction.R = turn(correction.R.col(2), Vector3d::UnitZ()) * correction.R;
        correction.t = T_world_held.t - correction.R * poses_[held].t;
      }
    }
    for (std::size_t i = 0; i < poses_.size(); ++i) poses_[i] = corrections[part_of(i)] * poses_[i];
  }

  const GraphIndex& index_;
  const Parts& parts_;
  std::vector<SE3> poses_;
  PoseGraph graph_;
};

Chi2 sum_chi2(const PoseGraph& graph, const GraphIndex& index, const std::vector<SE3>& poses,
              const std::vector<double>& weights) {
  Chi2 sum;
  const std::vector<double> of_edge = edge_chi2(graph, index, poses);
  for (std::size_t e = 0; e < of_edge.size(); ++e) {
    sum.of_kind[static_cast<std::size_t>(graph.edges[e].kind)] += weights[e] * of_edge[e];
  }
  for (std::size_t g = 0; g < graph.gravity.size(); ++g) {
    const SE3& T_world_node = poses[static_cast<std::size_t>(index.node_of_gravity[g])];
    const Vector3d e = linearize_gravity(T_world_node.R, graph.gravity[g].up_node).e;
    sum.gravity += e.squaredNorm() / (graph.gravity[g].sigma * graph.gravity[g].sigma);
  }
  sum.total = sum.gravity;
  for (const double chi2 : sum.of_kind) sum.total += chi2;
  return sum;
}

int num_unknowns(const Parts& parts) {
  int sum = 0;
  for (const Freedom freedom : parts.freedom) {
    if (freedom == Freedom::kFree) sum += 6;
    if (freedom == Freedom::kTiltOnly) sum += 2;
  }
  return sum;
}

void report_edges(const PoseGraph& graph, const GraphIndex& index, const std::vector<double>& weights,
                  GraphReport& report) {
  report.dof = 2 * static_cast<int>(graph.gravity.size());
  for (std::size_t e = 0; e < graph.edges.size(); ++e) {
    report.edges[e].weight = weights[e];
    report.edges[e].rank = index.roots[e].rank;
    if (weights[e] < 0.5) {
      ++report.num_rejected;
      continue;
    }
    report.dof += index.roots[e].rank;
    ++report.num_of_kind[static_cast<std::size_t>(graph.edges[e].kind)];
  }
}

void report_unconnected(const PoseGraph& graph, const GraphIndex& index, const Parts& parts,
                        GraphReport& report) {
  std::vector<bool> connected(graph.anchors.size(), false);
  connected[static_cast<std::size_t>(index.fixed_anchor)] = true;
  for (std::size_t i = 0; i < graph.nodes.size(); ++i) {
    const bool anchored = parts.anchored[static_cast<std::size_t>(parts.part_of_node[i])];
    if (anchored) connected[static_cast<std::size_t>(index.anchor_of_node[i])] = true;
    if (!anchored) report.unconnected_nodes.push_back(graph.nodes[i].id);
  }
  for (std::size_t a = 0; a < connected.size(); ++a) {
    if (!connected[a]) report.unconnected_maps.push_back(graph.anchors[a].map);
  }
}

GraphReport make_report(const PoseGraph& before, const OptimizedGraph& after, const GraphIndex& index,
                        const RobustSolution& solution) {
  GraphReport report = after.report;
  const std::vector<SE3> first = world_poses(before, index);
  const std::vector<SE3> last = world_poses(after.graph, index);
  const std::vector<double> initial_chi2 = edge_chi2(before, index, first);
  const std::vector<double> final_chi2 = edge_chi2(after.graph, index, last);
  for (std::size_t e = 0; e < initial_chi2.size(); ++e) {
    report.edges.push_back({.initial_chi2 = initial_chi2[e], .chi2 = final_chi2[e]});
  }
  report.initial = sum_chi2(before, index, first, std::vector<double>(before.edges.size(), 1.0));
  report.final = sum_chi2(after.graph, index, last, solution.weights);
  report_edges(before, index, solution.weights, report);
  report.dof -= num_unknowns(solution.parts);
  report_unconnected(before, index, solution.parts, report);
  report.iterations = solution.iterations;
  report.gnc_rounds = solution.gnc_rounds;
  return report;
}

bool has_something_to_estimate(const PoseGraph& graph, const GraphIndex& index) {
  const Parts parts = find_parts(graph, index, std::vector<double>(graph.edges.size(), 1.0));
  return parts.part_of_node.size() > parts.held_node.size() && num_unknowns(parts) > 0;
}

}  // namespace

Result<OptimizedGraph> optimize(const PoseGraph& graph, const OptimizerConfig& config) {
  const Result<GraphIndex> index = index_graph(graph);
  if (!index) return index.error();
  OptimizedGraph result{graph, {}};
  RobustSolution solution;
  if (has_something_to_estimate(graph, *index)) {
    std::vector<SE3> start = config.place_maps ? place_maps(graph, *index) : world_poses(graph, *index);
    solution = solve_robustly(graph, *index, std::move(start), config);
    result.report.status = solution.converged ? GraphStatus::kConverged : GraphStatus::kIterationLimit;
    if (!solution.usable) result.report.status = GraphStatus::kSolverFailed;
  } else {
    result.report.status = GraphStatus::kNothingToEstimate;
    solution.weights.assign(graph.edges.size(), 1.0);
    solution.parts = find_parts(graph, *index, solution.weights);
    solution.usable = false;
  }
  if (solution.usable) result.graph = MapSplitter(graph, *index, solution).split();
  result.report = make_report(graph, result, *index, solution);
  return result;
}

}  // namespace mmlins::graph
