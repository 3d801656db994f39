// SPDX-License-Identifier: MIT
#pragma once
// The surfaces of a submap: a grid of cells, each with the Gaussian of its points, of which only the
// directions across a surface count. A Gaussian along a wall says where its cell ends, not where the wall
// does, and would hold a pose that nothing holds. docs/math/registration.md.

#include <Eigen/Core>
#include <cstdint>
#include <optional>
#include <span>
#include <vector>

#include "mmlins/base/config_fields.hpp"
#include "mmlins/math/grid.hpp"
#include "mmlins/math/se3.hpp"

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

  [[nodiscard]] double cell_size() const { return cell_size_; }
  /// All surfaces.
  [[nodiscard]] const std::vector<SurfaceCell>& cells() const { return cells_; }

 private:
  struct Moments;
  /// What decides whether a surface is near.
  struct Shape {
    math::Vector3d mean;
    math::Vector3d axis;  // across a plane, along a pole
    int z = 0;            // of its cell
    bool is_plane = false;
  };

  [[nodiscard]] math::CellIndex cell_of(const math::Vector3d& point) const;
  [[nodiscard]] std::vector<Moments> moments_of(std::span<const Eigen::Vector3f> points) const;
  void sort_into_columns(const std::vector<SurfaceCell>& cells, const std::vector<math::CellIndex>& places);
  /// Where column (x, y) is in begins_.
  [[nodiscard]] std::size_t column_of(int x, int y) const {
    return static_cast<std::size_t>(x) * static_cast<std::size_t>(extent_.y()) + static_cast<std::size_t>(y);
  }

  double cell_size_;
  double inverse_size_;
  // Cells on top of each other form a column, so that a neighbourhood is found by a look-up for each x: the
  // surfaces of column k are those from begins_[k] up to begins_[k + 1].
  math::CellIndex corner_ = math::CellIndex::Zero();
  math::CellIndex extent_ = math::CellIndex::Zero();
  std::vector<std::uint32_t> begins_;
  std::vector<Shape> shapes_;
  std::vector<SurfaceCell> cells_;  // in the same order
};

}  // namespace mmlins::registration
