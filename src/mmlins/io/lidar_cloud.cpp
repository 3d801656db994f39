// SPDX-License-Identifier: MIT
#include "mmlins/io/lidar_cloud.hpp"

#include <cstddef>

namespace mmlins::io {
namespace {

template <typename Value>
void keep_marked(std::vector<Value>& column, const std::vector<bool>& keep) {
  if (column.empty()) return;
  std::size_t size = 0;
  for (std::size_t i = 0; i < keep.size(); ++i) {
    if (keep[i]) column[size++] = column[i];
  }
  column.resize(size);
}

}  // namespace

void drop_outside(LidarCloud& cloud, std::int64_t first, std::int64_t last) {
  std::vector<bool> keep(cloud.times.size());
  for (std::size_t i = 0; i < keep.size(); ++i) keep[i] = cloud.times[i] >= first && cloud.times[i] <= last;
  keep_marked(cloud.points, keep);
  keep_marked(cloud.intensities, keep);
  keep_marked(cloud.rings, keep);
  keep_marked(cloud.times, keep);
  cloud.num_invalid += static_cast<int>(keep.size() - cloud.times.size());
}

}  // namespace mmlins::io
