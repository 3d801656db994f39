// SPDX-License-Identifier: MIT
#pragma once
// The least-squares problem of a pose graph in Ceres, with weights that can be changed between two
// solutions. Internal to graph/.

#include <memory>
#include <vector>

#include "mmlins/graph/ceres_terms.hpp"
#include "mmlins/graph/graph_index.hpp"

namespace mmlins::graph {

struct SolveLimits {
  int max_iterations = 50;
  double tolerance = 1e-6;  ///< relative decrease of chi2
};

struct SolveOutcome {
  int iterations = 0;
  bool converged = false;
  bool usable = true;  ///< false: the solver gave up; the poses are those from before
};

class GraphProblem {
 public:
  /// @param gap_cauchy scale of the Cauchy loss of gap edges in standard deviations; 0: none
  GraphProblem(const PoseGraph& graph, const GraphIndex& index, const Parts& parts,
               const std::vector<SE3>& T_world_node, double gap_cauchy);
  GraphProblem(const GraphProblem&) = delete;
  GraphProblem& operator=(const GraphProblem&) = delete;

  /// For robust edges only.
  void set_weights(const std::vector<double>& weights);
  [[nodiscard]] SolveOutcome solve(const SolveLimits& limits);
  [[nodiscard]] std::vector<SE3> poses() const;

 private:
  void add_nodes(const Parts& parts);
  void add_edges(const PoseGraph& graph, const GraphIndex& index, double gap_cauchy);

  // What the problem points at must outlive it.
  PoseManifold pose_manifold_;
  TiltManifold tilt_manifold_;
  std::unique_ptr<ceres::CauchyLoss> gap_loss_;
  std::vector<WeightLoss> weight_losses_;
  std::vector<PoseBlock> blocks_;
  std::unique_ptr<ceres::Problem> problem_;
};

/// Whether an edge can lose its weight.
[[nodiscard]] inline bool is_robust(const Edge& edge) {
  return edge.robust && (edge.kind == EdgeKind::kLoop || edge.kind == EdgeKind::kMerge);
}

}  // namespace mmlins::graph
