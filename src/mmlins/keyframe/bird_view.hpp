// SPDX-License-Identifier: MIT
#pragma once
// A submap from above: how much stands in each column, and where its ground is. Counting occupied slices of
// height instead of points makes it the same for dense and sparse scanners.

#include <cstdint>
#include <vector>

#include "mmlins/keyframe/submap.hpp"

namespace mmlins::keyframe {

struct BirdViewConfig {
  double cell = 0.5;
  double reach = 60.0;
  double slice = 0.5;
  double full_height = 3.0;

  [[nodiscard]] Fields fields();
};

/// One column that holds points.
struct Column {
  Eigen::Vector2f place;   ///< mean of its points, in the frame of the submap [m]
  float structure = 0.0F;  ///< 0: a floor or less; 1: `full_height` or more is occupied
  float lowest = 0.0F;     ///< height of its lowest point [m]
  float highest = 0.0F;    ///< [m]
};

/// The columns of a submap within `reach` of its origin, in the order in which its points came.
[[nodiscard]] std::vector<Column> columns_of(const Submap& submap, const BirdViewConfig& config);

}  // namespace mmlins::keyframe
