// SPDX-License-Identifier: MIT
#pragma once
// The map that a run leaves behind: one real point per cell, so that its size follows the explored
// surface and not the length of the recording.

#include <Eigen/Core>
#include <cstdint>
#include <unordered_set>
#include <vector>

#include "mmlins/math/se3.hpp"
#include "mmlins/odometry/scan_result.hpp"

namespace mmlins::pipeline {

class VoxelMapBuilder {
 public:
  explicit VoxelMapBuilder(double voxel) : inverse_voxel_(1.0 / voxel) {}

  /// Adds the points of a tracked scan that fall into empty cells.
  void add(const odometry::ScanResult& result);

  [[nodiscard]] const std::vector<Eigen::Vector3f>& points_odom() const { return points_odom_; }
  [[nodiscard]] const std::vector<float>& intensities() const { return intensities_; }

 private:
  double inverse_voxel_;
  std::unordered_set<std::uint64_t> cells_;
  std::vector<Eigen::Vector3f> points_odom_;
  std::vector<float> intensities_;
};

}  // namespace mmlins::pipeline
