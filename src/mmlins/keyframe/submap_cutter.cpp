// SPDX-License-Identifier: MIT
#include "mmlins/keyframe/submap_cutter.hpp"

#include <utility>

namespace mmlins::keyframe {

std::optional<Keyframes> SubmapCutter::add(KeyframePointer keyframe) {
  pending_.push_back(std::move(keyframe));
  const std::vector<KeyframeRange> ranges = split_by_travel(pending_, config_);
  // A range that ends where the keyframes end may still grow, unless it is full: then the next one begins within it.
  if (ranges.size() < 2) return std::nullopt;
  Keyframes complete(pending_.begin(), pending_.begin() + static_cast<std::ptrdiff_t>(ranges.front().last));
  pending_.erase(pending_.begin(), pending_.begin() + static_cast<std::ptrdiff_t>(ranges[1].first));
  num_returned_ = ranges.front().last - ranges[1].first;
  return complete;
}

std::optional<Keyframes> SubmapCutter::finish() {
  Keyframes rest = std::exchange(pending_, {});
  const std::size_t num_returned = std::exchange(num_returned_, 0);
  if (rest.size() <= num_returned) return std::nullopt;
  return rest;
}

}  // namespace mmlins::keyframe
