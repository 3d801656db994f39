// SPDX-License-Identifier: MIT
#pragma once
// Graduated non-convexity for truncated least squares: weights that begin nearly equal and end as 0 or 1.
// docs/math/pose_graph.md, "Robust edges".

namespace mmlins::graph {

/// The chi2 that a true edge of this rank (1 to 6) exceeds once in a thousand times.
[[nodiscard]] double chi2_limit(int rank);

/// Where the non-convexity begins for this largest ratio chi2 / limit (above 1). Eq. (8).
[[nodiscard]] double first_convexity(double max_ratio);

/// Weight of an edge with this ratio chi2 / limit; grows sharper with `mu`. Eq. (9).
[[nodiscard]] double truncated_weight(double ratio, double mu);

}  // namespace mmlins::graph
