// SPDX-License-Identifier: MIT
#include "mmlins/lidar/voxel_downsample.hpp"

#include <algorithm>
#include <bit>
#include <cmath>

#include "mmlins/math/grid.hpp"

namespace mmlins::lidar {
namespace {
constexpr std::uint64_t kTaken = std::uint64_t{1} << 63;
}  // namespace

Cloud voxel_downsample(const Cloud& cloud, double leaf) {
  const auto inverse_leaf = static_cast<float>(1.0 / leaf);
  const std::size_t capacity = std::bit_ceil(std::max<std::size_t>(16, 2 * cloud.size()));
  const int shift = 64 - std::countr_zero(capacity);
  std::vector<std::uint64_t> table(capacity, 0);
  Cloud kept;
  for (std::size_t i = 0; i < cloud.size(); ++i) {
    // Keys use 63 bits; one more tells a taken slot from an empty one.
    const std::uint64_t key = math::cell_key(math::cell_at(cloud.points[i], inverse_leaf)) | kTaken;
    std::size_t slot = math::hash_slot(key, shift);
    while (table[slot] != 0 && table[slot] != key) slot = (slot + 1) & (capacity - 1);
    if (table[slot] == key) continue;
    table[slot] = key;
    kept.points.push_back(cloud.points[i]);
    kept.source.push_back(cloud.source[i]);
  }
  return kept;
}

double adapt_leaf(double leaf, std::size_t count, std::size_t target, const LeafLimits& limits) {
  const double ratio = static_cast<double>(std::max<std::size_t>(count, 1)) / static_cast<double>(target);
  return std::clamp(leaf * std::sqrt(ratio), limits.min_leaf, limits.max_leaf);
}

}  // namespace mmlins::lidar
