// SPDX-License-Identifier: MIT
#pragma once
// How well a graph knows where one node lies relative to another: for gating candidates of loops.

#include <cstdint>
#include <vector>

#include "mmlins/base/result.hpp"
#include "mmlins/graph/pose_graph.hpp"

namespace mmlins::graph {

enum class CovarianceStatus {
  kKnown,
  kUnconnected,   ///< no edges that count lead from one to the other
  kUndetermined,  ///< they lead there, but leave directions open
};

struct RelativeCovariance {
  CovarianceStatus status = CovarianceStatus::kUndetermined;
  SE3 T_i_j;
  /// Of e = [rotation [rad]; translation [m]] in T_i_j Exp(e); zero unless the status is kKnown.
  Matrix6d covariance = Matrix6d::Zero();
};

struct NodePair {
  std::int64_t i = 0;
  std::int64_t j = 0;
};

/// Marginal covariances at the poses of the graph as they are (optimise it before). One factorisation serves
/// all pairs. docs/math/pose_graph.md, Eq. (12).
/// @param weights of the edges (EdgeReport::weight); empty: all count
[[nodiscard]] Result<std::vector<RelativeCovariance>> relative_covariances(
    const PoseGraph& graph, const std::vector<NodePair>& pairs, const std::vector<double>& weights = {});

/// How far an edge is from what all others say.
struct EdgeTest {
  CovarianceStatus status = CovarianceStatus::kUndetermined;
  double chi2 = 0.0;  ///< follows the chi2 distribution with `rank` degrees of freedom if the edge is true
  int rank = 0;       ///< directions that others determine too; 0: nothing to compare with
};

/// Tests edges against the rest of the graph, at its poses as they are: edges that count as if they had been
/// left out, edges of weight 0 as candidates. The optimiser cannot do this by itself: where nothing but
/// odometry contradicts a false loop, the graph bends to it. docs/math/pose_graph.md, Eq. (13).
/// @param edges positions in PoseGraph::edges
[[nodiscard]] Result<std::vector<EdgeTest>> test_edges(const PoseGraph& graph,
                                                       const std::vector<std::size_t>& edges,
                                                       const std::vector<double>& weights = {});

/// relative_covariances for a single pair.
[[nodiscard]] Result<RelativeCovariance> relative_covariance(const PoseGraph& graph, std::int64_t i,
                                                             std::int64_t j,
                                                             const std::vector<double>& weights = {});

}  // namespace mmlins::graph
