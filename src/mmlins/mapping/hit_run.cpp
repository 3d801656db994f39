// SPDX-License-Identifier: MIT
#include "mmlins/mapping/hit_run.hpp"

#include <algorithm>

namespace mmlins::mapping {

HitRun extend(HitRun run, const std::optional<SimilarPair>& hit) {
  if (!hit) return {};
  run.push_back(*hit);
  return run;
}

bool is_consistent(const HitRun& run, int threshold) { return static_cast<int>(run.size()) > threshold; }

HitRun latest_pairs(const HitRun& run, int count) {
  const auto skipped = std::max<std::ptrdiff_t>(0, static_cast<std::ptrdiff_t>(run.size()) - count);
  HitRun pairs(run.begin() + skipped, run.end());
  const auto best =
      std::min_element(pairs.begin(), pairs.end(),
                       [](const SimilarPair& a, const SimilarPair& b) { return a.distance < b.distance; });
  if (best != pairs.end()) std::rotate(pairs.begin(), best, best + 1);
  return pairs;
}

}  // namespace mmlins::mapping
