// SPDX-License-Identifier: MIT
#pragma once
// Graduated non-convexity: weights that begin nearly equal and part into believed and false.
// docs/math/pose_graph.md, "Robust edges".

namespace mmlins::graph {

/// The chi2 that a true edge of this rank (1 to 6) exceeds once in a thousand times.
[[nodiscard]] double chi2_limit(int rank);

/// Where the graduation begins for this largest ratio chi2 / limit. Eq. (8).
[[nodiscard]] double first_width(double max_ratio);

/// Weight of an edge with this ratio chi2 / limit; sharper the narrower, down to a width of 1. Eq. (9).
[[nodiscard]] double graduated_weight(double ratio, double width);

}  // namespace mmlins::graph
