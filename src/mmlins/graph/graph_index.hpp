// SPDX-License-Identifier: MIT
#pragma once
// A pose graph checked and made ready to compute with: positions instead of ids, square roots of the
// information, and which nodes hang together.

#include <vector>

#include "mmlins/base/result.hpp"
#include "mmlins/graph/pose_graph.hpp"
#include "mmlins/graph/residuals.hpp"

namespace mmlins::graph {

/// How far a node may move. Something must be held in every part of the graph that hangs together: all of
/// one node, or all but its tilt where gravity says what is level. docs/math/pose_graph.md, "Gauge".
enum class Freedom { kFree, kTiltOnly, kHeld };

/// Positions in PoseGraph::nodes.
struct EdgeEnds {
  int from = 0;
  int to = 0;
};

struct GraphIndex {
  std::vector<int> anchor_of_node;   ///< position in PoseGraph::anchors
  std::vector<EdgeEnds> ends;        ///< per edge
  std::vector<SquareRoot> roots;     ///< per edge
  std::vector<int> node_of_gravity;  ///< per gravity factor
  int fixed_anchor = 0;
};

/// Checks everything that may be wrong with a graph from outside: ids, numbers, the gauge. The error names
/// the node, edge, map or factor.
[[nodiscard]] Result<GraphIndex> index_graph(const PoseGraph& graph);

/// Parts of the graph that hang together by edges that count.
struct Parts {
  std::vector<int> part_of_node;
  std::vector<Freedom> freedom;   ///< per node
  std::vector<int> held_node;     ///< per part: the node that holds it
  std::vector<bool> has_gravity;  ///< per part
  std::vector<bool> anchored;     ///< per part: hangs on the fixed map or on a held node
};
/// @param weights per edge; edges below one half do not count
[[nodiscard]] Parts find_parts(const PoseGraph& graph, const GraphIndex& index,
                               const std::vector<double>& weights);

/// Poses of all nodes in the world.
[[nodiscard]] std::vector<SE3> world_poses(const PoseGraph& graph, const GraphIndex& index);

}  // namespace mmlins::graph
