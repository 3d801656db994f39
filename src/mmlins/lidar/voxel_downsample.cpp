// SPDX-License-Identifier: MIT
#include "mmlins/lidar/voxel_downsample.hpp"

#include <algorithm>
#include <bit>
#include <cmath>

namespace mmlins::lidar {
namespace {

/// Cell indices of up to +-2^20 packed into one number; never 0, which marks an empty slot.
std::uint64_t cell_key(const Eigen::Vector3f& point, float inverse_leaf) {
  const auto index = [&](int axis) {
    return static_cast<std::uint64_t>(static_cast<std::int64_t>(std::floor(point[axis] * inverse_leaf)) + (1 << 20)) &
           0x1FFFFF;
  };
  return (index(0) << 42 | index(1) << 21 | index(2)) + 1;
}

}  // namespace

Cloud voxel_downsample(const Cloud& cloud, double leaf) {
  const auto inverse_leaf = static_cast<float>(1.0 / leaf);
  const std::size_t capacity = std::bit_ceil(std::max<std::size_t>(16, 2 * cloud.size()));
  const int shift = 64 - std::countr_zero(capacity);
  std::vector<std::uint64_t> table(capacity, 0);
  Cloud kept;
  for (std::size_t i = 0; i < cloud.size(); ++i) {
    const std::uint64_t key = cell_key(cloud.points[i], inverse_leaf);
    std::size_t slot = (key * 0x9E3779B97F4A7C15ULL) >> shift;
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
