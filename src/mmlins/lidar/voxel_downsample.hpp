// SPDX-License-Identifier: MIT
#pragma once
// Thins a cloud to one point per cell of a grid.

#include "mmlins/lidar/deskew.hpp"

namespace mmlins::lidar {

/// Keeps the first point of every cell of edge `leaf` [m], in the order of the input. A real point is
/// kept, not a mean: its noise is that of one measurement, and nothing is averaged across time.
[[nodiscard]] Cloud voxel_downsample(const Cloud& cloud, double leaf);

struct LeafLimits {
  double min_leaf;  ///< [m]
  double max_leaf;  ///< [m], not below min_leaf
};

/// Leaf that brings about `target` points, given that `leaf` brought `count`. The number of cells that
/// surfaces fill falls with the square of the leaf. Clamped to the limits.
[[nodiscard]] double adapt_leaf(double leaf, std::size_t count, std::size_t target, const LeafLimits& limits);

}  // namespace mmlins::lidar
