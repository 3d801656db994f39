// SPDX-License-Identifier: MIT
#include "mmlins/pipeline/voxel_map_builder.hpp"

#include "mmlins/math/grid.hpp"

namespace mmlins::pipeline {

void VoxelMapBuilder::add(const odometry::ScanResult& result) {
  const math::SE3 T_odom_imu = result.estimate.state.T_odom_imu();
  const Eigen::Matrix3f R = T_odom_imu.R.cast<float>();
  const Eigen::Vector3f t = T_odom_imu.t.cast<float>();
  const auto inverse_voxel = static_cast<float>(inverse_voxel_);
  for (std::size_t i = 0; i < result.cloud_imu->size(); ++i) {
    const Eigen::Vector3f p_odom = R * result.cloud_imu->points[i] + t;
    if (!cells_.insert(math::cell_key(math::cell_at(p_odom, inverse_voxel))).second) continue;
    points_odom_.push_back(p_odom);
    intensities_.push_back(result.scan->intensities[result.cloud_imu->source[i]]);
  }
}

}  // namespace mmlins::pipeline
