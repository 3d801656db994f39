// SPDX-License-Identifier: MIT
#pragma once
// The structure of a view from above as a pyramid of upper bounds: a cell of level h holds the largest value
// within 2^h cells to the right and above of it.

#include <vector>

#include "mmlins/keyframe/bird_view.hpp"

namespace mmlins::registration {

class StructureGrid {
 public:
  /// Structure counts in neighbouring cells too, at half its value: cells never fit exactly.
  StructureGrid(const std::vector<keyframe::Column>& columns, const keyframe::BirdViewConfig& config,
                int num_levels);

  /// Largest value in the square of 2^level cells from (x, y) on; 0 outside.
  [[nodiscard]] float bound(int level, int x, int y) const {
    const int i = x + margin_, j = y + margin_;
    if (i < 0 || j < 0 || i >= size_ || j >= size_) return 0.0F;
    return levels_[static_cast<std::size_t>(
        level)][static_cast<std::size_t>(j) * static_cast<std::size_t>(size_) + static_cast<std::size_t>(i)];
  }
  /// Cell of a coordinate [m].
  [[nodiscard]] int cell_of(double coordinate) const;

 private:
  void add_level(int step);

  double cell_;
  int margin_;  // cells to the left of and below the origin
  int size_;
  std::vector<std::vector<float>> levels_;
};

}  // namespace mmlins::registration
