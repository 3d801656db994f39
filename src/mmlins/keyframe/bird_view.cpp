// SPDX-License-Identifier: MIT
#include "mmlins/keyframe/bird_view.hpp"

#include <algorithm>
#include <bit>
#include <cmath>
#include <unordered_map>

#include "mmlins/math/grid.hpp"

namespace mmlins::keyframe {

Fields BirdViewConfig::fields() {
  return {
      field("cell", cell, "m", {0.1, 5.0}, "edge of a column"),
      field("reach", reach, "m", {5.0, 300.0}, "columns farther from the middle are left out"),
      field("slice", slice, "m", {0.1, 2.0}, "height of the slices that are counted"),
      field("full_height", full_height, "m", {0.5, 50.0}, "of what stands there: more counts no more"),
  };
}

std::vector<Column> columns_of(const Submap& submap, const BirdViewConfig& config) {
  constexpr double kLowest = -16.0;  // in slices below the IMU; 64 of them fit
  struct Sums {
    Eigen::Vector2f sum = Eigen::Vector2f::Zero();
    int count = 0;
    std::uint64_t slices = 0;
  };
  std::unordered_map<std::uint64_t, std::size_t> index;
  std::vector<Sums> sums;
  std::vector<Column> columns;
  const auto reach = static_cast<float>(config.reach);
  for (const Eigen::Vector3f& p : submap.points) {
    if (p.head<2>().squaredNorm() > reach * reach) continue;
    const math::CellIndex cell = math::cell_at<double>(Eigen::Vector3d(p.x(), p.y(), 0.0), 1.0 / config.cell);
    const auto [entry, is_new] = index.try_emplace(math::cell_key(cell), columns.size());
    if (is_new) {
      sums.emplace_back();
      columns.push_back({Eigen::Vector2f::Zero(), 0.0F, p.z(), p.z()});
    }
    Sums& sum = sums[entry->second];
    Column& column = columns[entry->second];
    sum.sum += p.head<2>();
    ++sum.count;
    const int slice = static_cast<int>(std::floor(p.z() / config.slice) - kLowest);
    sum.slices |= std::uint64_t{1} << std::clamp(slice, 0, 63);
    column.lowest = std::min(column.lowest, p.z());
    column.highest = std::max(column.highest, p.z());
  }
  const double full = config.full_height / config.slice - 1.0;
  for (std::size_t i = 0; i < columns.size(); ++i) {
    columns[i].place = sums[i].sum / static_cast<float>(sums[i].count);
    columns[i].structure =
        static_cast<float>(std::clamp((std::popcount(sums[i].slices) - 1) / full, 0.0, 1.0));
  }
  return columns;
}

}  // namespace mmlins::keyframe
