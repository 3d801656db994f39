// SPDX-License-Identifier: MIT
#pragma once
// Pose graphs in the text format of g2o: VERTEX_SE3:QUAT, EDGE_SE3:QUAT, FIX. docs/math/pose_graph.md,
// Eq. (11), says how its information maps to ours.

#include <string>
#include <string_view>

#include "mmlins/base/result.hpp"
#include "mmlins/graph/pose_graph.hpp"

namespace mmlins::graph {

/// One map, 0, whose anchor is fixed at the origin. FIX makes nodes held. Edges between neighbouring ids
/// (n, n + 1) are odometry, all others robust loops; their provenance is their line.
/// @param source how the text is called in errors
[[nodiscard]] Result<PoseGraph> parse_g2o(std::string_view text, const std::string& source);
[[nodiscard]] Result<PoseGraph> read_g2o(const std::string& path);

/// All maps in one frame, the world; held nodes as FIX. What g2o has no words for is left out: anchors, kinds
/// of edges, provenance and gravity factors.
/// @return an error if the graph does not hold together
[[nodiscard]] Result<std::string> format_g2o(const PoseGraph& graph);
/// Replaces the file at once.
[[nodiscard]] Status write_g2o(const std::string& path, const PoseGraph& graph);

}  // namespace mmlins::graph
