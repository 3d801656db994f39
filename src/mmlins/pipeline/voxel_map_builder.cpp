// SPDX-License-Identifier: MIT
#include "mmlins/pipeline/voxel_map_builder.hpp"

namespace mmlins::pipeline {

void VoxelMapBuilder::add(const keyframe::Keyframe& keyframe, const math::SE3& T_map_imu) {
  for (std::size_t i = 0; i < keyframe.points_imu.size(); ++i) {
    const math::Vector3d p_map = T_map_imu * keyframe.points_imu[i].cast<double>();
    const std::size_t num_before = cells_.payloads().size();
    const std::uint32_t id = cells_.find_or_add(cells_.index_of(p_map));
    if (cells_.payloads().size() == num_before) continue;
    const float intensity = keyframe.intensities.empty() ? 0.0F : static_cast<float>(keyframe.intensities[i]);
    cells_.payloads()[id] = {p_map.cast<float>(), intensity};
  }
}

std::vector<Eigen::Vector3f> VoxelMapBuilder::points_map() const {
  std::vector<Eigen::Vector3f> points;
  points.reserve(num_points());
  for (const Point& point : cells_.payloads()) points.push_back(point.p_map);
  return points;
}

std::vector<float> VoxelMapBuilder::intensities() const {
  std::vector<float> intensities;
  intensities.reserve(num_points());
  for (const Point& point : cells_.payloads()) intensities.push_back(point.intensity);
  return intensities;
}

}  // namespace mmlins::pipeline
