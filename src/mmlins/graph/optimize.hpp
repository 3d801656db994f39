// SPDX-License-Identifier: MIT
#pragma once
// Optimises a pose graph by Levenberg-Marquardt, with false loops and merges found and left out.

#include <array>
#include <cstdint>
#include <vector>

#include "mmlins/base/config_fields.hpp"
#include "mmlins/base/result.hpp"
#include "mmlins/graph/pose_graph.hpp"

namespace mmlins::graph {

struct OptimizerConfig {
  int max_iterations = 50;
  double tolerance = 1e-6;
  bool robust = true;
  double outlier_scale = 1.0;
  double gnc_step = 2.0;
  int gnc_rounds = 100;
  int gnc_iterations = 20;
  double gap_cauchy = 0.0;
  bool place_maps = true;

  [[nodiscard]] Fields fields();
};

enum class GraphStatus {
  kConverged,
  kIterationLimit,     ///< better than before, but not at the end
  kNothingToEstimate,  ///< no node may move or no edge says anything; the graph is as before
  kSolverFailed,       ///< the graph is as before
};

/// Sums of squared whitened errors. Rejected edges do not count.
struct Chi2 {
  double total = 0.0;
  std::array<double, kNumEdgeKinds> of_kind{};  ///< by EdgeKind
  double gravity = 0.0;
};

struct EdgeReport {
  double initial_chi2 = 0.0;
  double chi2 = 0.0;
  double weight = 1.0;  ///< 0: rejected as false
  int rank = 6;         ///< directions of which it says something
};

struct GraphReport {
  GraphStatus status = GraphStatus::kConverged;
  Chi2 initial;  ///< with all edges
  Chi2 final;    ///< with all edges but the rejected
  int dof = 0;   ///< measured directions that count minus estimated ones
  int iterations = 0;
  int gnc_rounds = 0;
  int num_rejected = 0;
  std::array<int, kNumEdgeKinds> num_of_kind{};  ///< edges that count
  std::vector<EdgeReport> edges;                 ///< in the order of PoseGraph::edges
  /// No edge that counts joins these to the fixed map: they kept their place, though parts of them that hang
  /// together were optimised among themselves.
  std::vector<std::int64_t> unconnected_nodes;
  std::vector<int> unconnected_maps;  ///< all nodes of which are unconnected

  [[nodiscard]] double chi2_per_dof() const { return dof > 0 ? final.total / dof : 0.0; }
};

struct OptimizedGraph {
  PoseGraph graph;
  GraphReport report;
};

/// The same graph with optimised poses and anchors. The fixed anchor stays. Where gravity factors are, every
/// anchor keeps its tilt and the nodes take up the change; otherwise the first node of a map keeps its pose
/// in the map and the anchor takes it up. The same input gives the same bits.
/// @return an error that names the fault if the graph does not hold together (unknown ids, no rotation,
///   negative information, not exactly one fixed anchor)
[[nodiscard]] Result<OptimizedGraph> optimize(const PoseGraph& graph, const OptimizerConfig& config = {});

}  // namespace mmlins::graph
