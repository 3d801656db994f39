// SPDX-License-Identifier: MIT
#pragma once
// Solves a pose graph while deciding which robust edges to believe. Internal to graph/.

#include <vector>

#include "mmlins/graph/graph_index.hpp"
#include "mmlins/graph/optimize.hpp"

namespace mmlins::graph {

struct RobustSolution {
  std::vector<SE3> T_world_node;
  std::vector<double> weights;  ///< per edge, 0 or 1
  Parts parts;                  ///< as joined by the edges that count
  int iterations = 0;
  int gnc_rounds = 0;
  bool converged = false;
  bool usable = true;
};

[[nodiscard]] RobustSolution solve_robustly(const PoseGraph& graph, const GraphIndex& index,
                                            std::vector<SE3> start, const OptimizerConfig& config);

/// Squared whitened error of every edge.
[[nodiscard]] std::vector<double> edge_chi2(const PoseGraph& graph, const GraphIndex& index,
                                            const std::vector<SE3>& T_world_node);

}  // namespace mmlins::graph
