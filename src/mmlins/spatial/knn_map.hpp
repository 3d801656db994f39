// SPDX-License-Identifier: MIT
#pragma once
// The baseline of the field: points in a hash grid, and a plane through the nearest neighbours of each
// query, fitted anew every time (FAST-LIO2, iVox). Kept to compare speed and accuracy against.

#include <array>

#include "mmlins/base/config_fields.hpp"
#include "mmlins/spatial/local_map.hpp"
#include "mmlins/spatial/voxel_table.hpp"

namespace mmlins::spatial {

struct KnnMapConfig {
  double cell = 0.5;
  double min_spacing = 0.1;
  double max_neighbour_distance = 1.5;
  double max_plane_error = 0.1;

  [[nodiscard]] Fields fields();
};

class KnnMap final : public LocalMap {
 public:
  KnnMap(const KnnMapConfig& config, double range_noise);

  void insert(std::span<const Eigen::Vector3d> points, const Eigen::Vector3d& viewpoint) override;
  [[nodiscard]] PlaneMatch match(const Eigen::Vector3d& point, double gate) const override;
  void evict_beyond(const Eigen::Vector3d& centre, double radius) override;
  [[nodiscard]] std::size_t num_cells() const override { return table_.payloads().size(); }

 private:
  static constexpr int kCapacity = 20;
  static constexpr int kNeighbours = 5;

  struct Cell {
    int num_points = 0;
    std::array<Eigen::Vector3d, kCapacity> points;
  };
  struct Neighbours {
    int count = 0;
    std::array<double, kNeighbours> distances2{};
    std::array<Eigen::Vector3d, kNeighbours> points;
  };

  [[nodiscard]] Neighbours nearest(const Eigen::Vector3d& point) const;

  KnnMapConfig config_;
  double range_variance_;
  VoxelTable<Cell> table_;
  Eigen::Vector3d last_eviction_ = Eigen::Vector3d::Zero();
};

}  // namespace mmlins::spatial
