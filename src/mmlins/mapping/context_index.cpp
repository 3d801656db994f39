// SPDX-License-Identifier: MIT
#include "mmlins/mapping/context_index.hpp"

#include <algorithm>
#include <utility>

namespace mmlins::mapping {
namespace {

/// Chosen by ring keys; the number of the Scan Context paper.
constexpr std::size_t kNumCompared = 10;

}  // namespace

void ContextIndex::add(int keyframe, place::ScanContext context) {
  entries_.push_back({keyframe, std::move(context)});
}

std::optional<ContextHit> ContextIndex::find(const place::ScanContext& query, double max_distance,
                                             const std::function<bool(int)>& is_eligible) const {
  std::vector<std::pair<float, std::size_t>> nearest;
  for (std::size_t i = 0; i < entries_.size(); ++i) {
    if (!is_eligible(entries_[i].keyframe)) continue;
    nearest.emplace_back((entries_[i].context.ring_key - query.ring_key).squaredNorm(), i);
  }
  const std::size_t num_compared = std::min(nearest.size(), kNumCompared);
  std::partial_sort(nearest.begin(), nearest.begin() + static_cast<std::ptrdiff_t>(num_compared),
                    nearest.end());
  std::optional<ContextHit> best;
  for (std::size_t k = 0; k < num_compared; ++k) {
    const Entry& entry = entries_[nearest[k].second];
    const place::ContextMatch match = place::compare(query, entry.context, config_);
    if (match.distance < (best ? best->distance : max_distance))
      best = {entry.keyframe, match.distance, match.yaw};
  }
  return best;
}

}  // namespace mmlins::mapping
