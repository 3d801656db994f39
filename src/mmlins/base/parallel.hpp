// SPDX-License-Identifier: MIT
#pragma once
// Parallel loops whose results do not depend on the number of threads: work is cut into chunks of a
// fixed size, each chunk writes only to its own place, and sums are formed chunk by chunk in order.

#include <algorithm>
#include <cstddef>
#include <functional>
#include <vector>

namespace mmlins::parallel {

/// Upper limit on the threads used by this process; 0 means all cores.
void set_num_threads(int num_threads);
[[nodiscard]] int num_threads();

/// Calls `body(chunk)` for every chunk in [0, num_chunks), in any order and possibly at the same time.
void for_each_chunk(std::size_t num_chunks, const std::function<void(std::size_t)>& body);

/// Calls `body(begin, end)` for consecutive ranges of at most `grain` elements that cover [0, size).
template <typename Body>
void for_ranges(std::size_t size, std::size_t grain, const Body& body) {
  const std::size_t num_chunks = (size + grain - 1) / grain;
  for_each_chunk(num_chunks, [&](std::size_t chunk) { body(chunk * grain, std::min(size, (chunk + 1) * grain)); });
}

/// Sums `partial(begin, end)` over consecutive ranges, always in the order of the ranges, so that the
/// same input gives the same bits whatever the number of threads. T needs `operator+=`.
template <typename T, typename Partial>
[[nodiscard]] T ordered_sum(std::size_t size, std::size_t grain, T zero, const Partial& partial) {
  const std::size_t num_chunks = (size + grain - 1) / grain;
  std::vector<T> parts(num_chunks, zero);
  for_each_chunk(num_chunks, [&](std::size_t chunk) {
    parts[chunk] = partial(chunk * grain, std::min(size, (chunk + 1) * grain));
  });
  for (const T& part : parts) zero += part;
  return zero;
}

}  // namespace mmlins::parallel
