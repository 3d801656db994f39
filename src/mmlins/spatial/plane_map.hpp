// SPDX-License-Identifier: MIT
#pragma once
// A map of planes: a pyramid of grids, each cell of which keeps the moments of its points and, once
// they are flat enough, their plane. A query is one look-up per level; no neighbours are searched.
// Large cells average over many points and span sparse rings, small ones follow edges and clutter;
// the cell that predicts the point with the least variance answers. docs/math/plane_map.md.

#include <vector>

#include "mmlins/base/config_fields.hpp"
#include "mmlins/spatial/local_map.hpp"
#include "mmlins/spatial/voxel_table.hpp"

namespace mmlins::spatial {

struct PlaneMapConfig {
  double finest_cell = 0.25;
  int num_levels = 4;
  double reach_in_cells = 120.0;
  int min_points = 6;
  int max_points = 200;
  double max_thickness = 0.06;
  double max_flatness_ratio = 0.04;
  double min_width_sigmas = 4.0;
  double min_incidence_deg = 2.0;
  double offset_noise = 0.01;

  [[nodiscard]] Fields fields();
};

class PlaneMap final : public LocalMap {
 public:
  /// @param range_noise  standard deviation of one measured range [m]
  PlaneMap(const PlaneMapConfig& config, double range_noise);

  void insert(std::span<const Eigen::Vector3d> points, const Eigen::Vector3d& viewpoint) override;
  [[nodiscard]] PlaneMatch match(const Eigen::Vector3d& point, double gate) const override;
  void evict_beyond(const Eigen::Vector3d& centre, double radius) override;
  [[nodiscard]] std::size_t num_cells() const override;

 private:
  /// Moments are relative to the first point of the cell, which keeps single precision exact enough.
  struct Cell {
    Eigen::Vector3d origin = Eigen::Vector3d::Zero();
    int num_points = 0;
    int num_points_at_fit = 0;
    Eigen::Vector3f sum = Eigen::Vector3f::Zero();
    Eigen::Matrix3f outer = Eigen::Matrix3f::Zero();
    Eigen::Matrix3f beams = Eigen::Matrix3f::Zero();    ///< sum of the outer products of the beams' directions
    bool is_plane = false;
    Eigen::Vector3f mean = Eigen::Vector3f::Zero();     ///< relative to origin
    Eigen::Vector3f normal = Eigen::Vector3f::Zero();
    Eigen::Vector3f middle = Eigen::Vector3f::Zero();   ///< direction of the middle spread
    Eigen::Vector3f spread = Eigen::Vector3f::Zero();   ///< variances, smallest first [m^2]
  };

  /// Distance from the sensor up to which a level is kept [m].
  [[nodiscard]] double reach_of(const VoxelTable<Cell>& level) const;
  void add_point(VoxelTable<Cell>& level, const Eigen::Vector3d& point, const Eigen::Vector3d& beam,
                 std::vector<std::uint32_t>& grown);
  void fit_plane(Cell& cell) const;
  /// The match that one cell offers; not found if the point is beyond the gate.
  [[nodiscard]] PlaneMatch match_cell(const Cell& cell, const Eigen::Vector3d& point, double gate) const;

  PlaneMapConfig config_;
  double range_variance_;
  std::vector<VoxelTable<Cell>> levels_;  ///< finest first
  std::size_t next_level_to_evict_ = 0;
  std::vector<Eigen::Vector3d> last_evictions_;  ///< per level: where its far cells were last dropped
};

}  // namespace mmlins::spatial
