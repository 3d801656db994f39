// SPDX-License-Identifier: MIT
#pragma once
// A good start for maps whose place in the world is not known yet. Internal to graph/.

#include <vector>

#include "mmlins/graph/graph_index.hpp"

namespace mmlins::graph {

/// Moves every map that edges join to the fixed one, directly or through others, as a rigid body: to where
/// most of these edges agree, be it where it is or where one of them puts it. docs/math/pose_graph.md,
/// Eq. (10). @return poses of the nodes in the world
[[nodiscard]] std::vector<SE3> place_maps(const PoseGraph& graph, const GraphIndex& index);

}  // namespace mmlins::graph
