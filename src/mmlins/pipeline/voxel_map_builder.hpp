// SPDX-License-Identifier: MIT
#pragma once
// The map that a run leaves behind: one real point per cell, so that its size follows the explored
// surface and not the length of the recording.

#include <Eigen/Core>
#include <deque>
#include <vector>

#include "mmlins/keyframe/keyframe.hpp"
#include "mmlins/spatial/voxel_table.hpp"

namespace mmlins::pipeline {

class VoxelMapBuilder {
 public:
  explicit VoxelMapBuilder(double voxel) : cells_(voxel) {}

  /// Adds the points of a keyframe that fall into empty cells.
  /// @param T_map_imu  its pose in the frame of the cloud
  void add(const keyframe::Keyframe& keyframe, const math::SE3& T_map_imu);

  [[nodiscard]] std::size_t num_points() const { return cells_.payloads().size(); }
  [[nodiscard]] std::vector<Eigen::Vector3f> points_map() const;
  [[nodiscard]] std::vector<float> intensities() const;

 private:
  struct Point {
    Eigen::Vector3f p_map;
    float intensity = 0.0F;
  };

  spatial::VoxelTable<Point, std::deque> cells_;
};

}  // namespace mmlins::pipeline
