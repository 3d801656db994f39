// SPDX-License-Identifier: MIT
#include "mmlins/registration/structure_grid.hpp"

#include <algorithm>
#include <cmath>

namespace mmlins::registration {

StructureGrid::StructureGrid(const std::vector<keyframe::Column>& columns,
                             const keyframe::BirdViewConfig& config, int num_levels)
    : cell_(config.cell) {
  // A window of the highest level may begin that far before the first cell.
  const int reach = static_cast<int>(std::ceil(config.reach / cell_)) + 2;
  margin_ = reach + (1 << (num_levels - 1));
  size_ = margin_ + reach;
  const auto width = static_cast<std::size_t>(size_);
  std::vector<float> values(width * width, 0.0F);
  for (const keyframe::Column& column : columns) {
    const int x = cell_of(column.place.x()) + margin_, y = cell_of(column.place.y()) + margin_;
    for (int dy = -1; dy <= 1; ++dy) {
      for (int dx = -1; dx <= 1; ++dx) {
        const float value = dx == 0 && dy == 0 ? column.structure : 0.5F * column.structure;
        float& entry = values[static_cast<std::size_t>(y + dy) * width + static_cast<std::size_t>(x + dx)];
        entry = std::max(entry, value);
      }
    }
  }
  levels_.push_back(std::move(values));
  for (int level = 1; level < num_levels; ++level) add_level(1 << (level - 1));
}

int StructureGrid::cell_of(double coordinate) const {
  return static_cast<int>(std::floor(coordinate / cell_));
}

void StructureGrid::add_level(int step) {
  const std::vector<float>& below = levels_.back();
  std::vector<float> level(below.size());
  const auto at = [&](int x, int y) {
    if (x >= size_ || y >= size_) return 0.0F;
    return below[static_cast<std::size_t>(y) * static_cast<std::size_t>(size_) + static_cast<std::size_t>(x)];
  };
  for (int y = 0; y < size_; ++y) {
    for (int x = 0; x < size_; ++x) {
      level[static_cast<std::size_t>(y) * static_cast<std::size_t>(size_) + static_cast<std::size_t>(x)] =
          std::max({at(x, y), at(x + step, y), at(x, y + step), at(x + step, y + step)});
    }
  }
  levels_.push_back(std::move(level));
}

}  // namespace mmlins::registration
