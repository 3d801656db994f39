// SPDX-License-Identifier: MIT
#pragma once
// The surfaces of a submap: a grid of cells, each with the Gaussian of its points, of which only the
// directions across a surface count. A Gaussian along a wall says where its cell ends, not where the wall
// does, and would hold a pose that nothing holds. docs/math/registration.md.

#include <Eigen/Core>
#include <optional>
#include <span>
#include <vector>

#include "mmlins/base/config_fields.hpp"
#include "mmlins/math/se3.hpp"
#include "mmlins/spatial/voxel_table.hpp"

namespace mmlins::registration {

struct SurfaceConfig {
  int min_points = 5;
  double max_thickness = 0.12;
  double max_flatness_ratio = 0.1;
  double min_width_in_cells = 0.12;
  double point_noise = 0.03;

  [[nodiscard]] Fields fields();
};

/// The Gaussian of one cell; axes sorted by variance, smallest first.
struct SurfaceCell {
  math::Vector3d mean = math::Vector3d::Zero();  ///< [m]
  math::Matrix3d axes = math::Matrix3d::Identity();
  math::Vector3d variances = math::Vector3d::Zero();  ///< [m^2]
  int num_points = 0;
  int num_thin = 0;  ///< axes that count: 1 for a plane, 2 for a pole, 0 for neither
};

struct SurfaceMatch {
  const SurfaceCell* cell = nullptr;
  double distance = 0.0;  ///< from the surface [m]
};

class GaussianMap {
 public:
  GaussianMap(std::span<const Eigen::Vector3f> points, double cell_size, const SurfaceConfig& config);

  /// The surface nearest to the point among the cells that touch the ball of `reach` cell edges around it
  /// (at most 1); nothing if there is none within `gate` [m].
  [[nodiscard]] std::optional<SurfaceMatch> match(const math::Vector3d& point, double gate,
                                                  double reach) const;
  /// The cell that holds the point, if it is a surface.
  [[nodiscard]] const SurfaceCell* at(const math::Vector3d& point) const;

  [[nodiscard]] double cell_size() const { return cells_.cell_size(); }
  [[nodiscard]] const std::vector<SurfaceCell>& cells() const { return cells_.payloads(); }

 private:
  spatial::VoxelTable<SurfaceCell> cells_;
};

}  // namespace mmlins::registration
