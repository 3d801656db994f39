// SPDX-License-Identifier: MIT
#include "mmlins/io/topic_timing.hpp"

#include <algorithm>

namespace mmlins::io {

TopicTiming measure_timing(const std::vector<Time>& times, bool by_stamp) {
  TopicTiming timing;
  timing.by_stamp = by_stamp;
  if (times.empty()) return timing;
  timing.first = times.front();
  timing.last = times.back();
  std::vector<Duration> steps;  // forward ones only
  for (std::size_t i = 1; i < times.size(); ++i) {
    if (times[i] > times[i - 1]) steps.push_back(times[i] - times[i - 1]);
  }
  timing.num_not_forward = static_cast<int>(times.size() - 1 - steps.size());
  if (steps.empty()) return timing;
  const auto middle = steps.begin() + static_cast<std::ptrdiff_t>(steps.size() / 2);
  std::nth_element(steps.begin(), middle, steps.end());
  timing.median_period = *middle;
  for (std::size_t i = 1; i < times.size(); ++i) {
    const Duration step = times[i] - times[i - 1];
    if (step <= 3 * timing.median_period) continue;
    ++timing.num_gaps;
    if (step <= timing.longest_gap) continue;
    timing.longest_gap = step;
    timing.longest_gap_start = times[i - 1];
  }
  return timing;
}

}  // namespace mmlins::io
