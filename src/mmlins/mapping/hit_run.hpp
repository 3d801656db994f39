// SPDX-License-Identifier: MIT
#pragma once
// The temporal consistency of the MM-LINS paper, its Eq. (3): one similar keyframe may be chance; many in a
// row are not.

#include <optional>
#include <vector>

namespace mmlins::mapping {

/// A keyframe of the active map that looks like one of a sleeping map.
struct SimilarPair {
  int source = 0;  ///< in the active map
  int target = 0;  ///< in the sleeping map
  double distance = 1.0;
  double yaw = 0.0;  ///< of the source in the target [rad]
};

/// Hits without a miss in between, the latest last.
using HitRun = std::vector<SimilarPair>;

/// The run after one more keyframe: it grows with a hit and ends with a miss.
[[nodiscard]] HitRun extend(HitRun run, const std::optional<SimilarPair>& hit);

/// Eq. (3): more hits in a row than the threshold.
[[nodiscard]] bool is_consistent(const HitRun& run, int threshold);

/// Those of the latest `count` pairs of a run, of which the most similar comes first.
[[nodiscard]] HitRun latest_pairs(const HitRun& run, int count);

}  // namespace mmlins::mapping
