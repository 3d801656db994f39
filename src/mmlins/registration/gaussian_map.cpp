// SPDX-License-Identifier: MIT
#include "mmlins/registration/gaussian_map.hpp"

#include <Eigen/Eigenvalues>
#include <algorithm>
#include <cmath>
#include <numeric>

#include "mmlins/spatial/voxel_table.hpp"

namespace mmlins::registration {

namespace {

using math::CellIndex;
using math::Matrix3d;
using math::Vector3d;

// A pole stands: lines that lie are the rings of a scanner on the ground more often than anything real.
constexpr double kUpright = 0.85;
// The grid is shifted against the origin, so that a floor or wall at a round coordinate does not run along
// the faces of the cells.
constexpr double kShift = 0.381966;

int num_thin_axes(const SurfaceCell& cell, double cell_size, const SurfaceConfig& config) {
  const double max_variance = config.max_thickness * config.max_thickness;
  const double width = config.min_width_in_cells * cell_size;
  const Vector3d& v = cell.variances;
  const bool wide = v(1) > width * width;
  if (wide) return v(0) < max_variance && v(0) < config.max_flatness_ratio * v(1) ? 1 : 0;
  const bool is_pole = v(2) > width * width && v(1) < max_variance && v(1) < config.max_flatness_ratio * v(2);
  return is_pole && std::abs(cell.axes(2, 2)) > kUpright ? 2 : 0;
}

}  // namespace

/// Sums over the points of a cell, relative to the first one.
struct GaussianMap::Moments {
  CellIndex cell = CellIndex::Zero();
  int num_points = 0;
  Vector3d first = Vector3d::Zero();
  Vector3d sum = Vector3d::Zero();
  Matrix3d outer = Matrix3d::Zero();
};

Fields SurfaceConfig::fields() {
  return {
      field("min_points", min_points, "", {4.0, 100.0}, "points that make a surface of a cell"),
      field("max_thickness", max_thickness, "m", {0.01, 1.0}, "standard deviation across a surface, at most"),
      field("max_flatness_ratio", max_flatness_ratio, "", {1e-4, 0.5},
            "largest ratio of the variance across a surface to the smaller one along it"),
      field("min_width_in_cells", min_width_in_cells, "", {0.0, 0.3},
            "standard deviation along a surface, at least, in edges of the cell"),
      field("point_noise", point_noise, "m", {1e-3, 0.5},
            "standard deviation of a submap's point: range noise and the drift within the submap"),
  };
}

GaussianMap::GaussianMap(std::span<const Eigen::Vector3f> points, double cell_size,
                         const SurfaceConfig& config)
    : cell_size_(cell_size), inverse_size_(1.0 / cell_size) {
  std::vector<SurfaceCell> cells;
  std::vector<CellIndex> places;
  for (const Moments& moments : moments_of(points)) {
    if (moments.num_points < config.min_points) continue;
    const Vector3d mean = moments.sum / moments.num_points;
    const Matrix3d scatter = moments.outer / moments.num_points - mean * mean.transpose();
    Eigen::SelfAdjointEigenSolver<Matrix3d> solver;
    solver.computeDirect(scatter);
    SurfaceCell cell{moments.first + mean, solver.eigenvectors(), solver.eigenvalues().cwiseMax(0.0),
                     moments.num_points};
    cell.num_thin = num_thin_axes(cell, cell_size, config);
    if (cell.num_thin == 0) continue;
    cells.push_back(cell);
    places.push_back(moments.cell);
  }
  sort_into_columns(cells, places);
}

CellIndex GaussianMap::cell_of(const Vector3d& point) const {
  const auto floor =
      [&](double coordinate) {  // std::floor is a call where processors have no instruction for it
        const double place = coordinate * inverse_size_ + kShift;
        const int towards_zero = static_cast<int>(place);
        return towards_zero - (static_cast<double>(towards_zero) > place ? 1 : 0);
      };
  return {floor(point.x()), floor(point.y()), floor(point.z())};
}

std::vector<GaussianMap::Moments> GaussianMap::moments_of(std::span<const Eigen::Vector3f> points) const {
  spatial::VoxelTable<Moments> table(cell_size_);
  for (const Eigen::Vector3f& point : points) {
    const Vector3d p = point.cast<double>();
    const CellIndex cell = cell_of(p);
    Moments& moments = table.payloads()[table.find_or_add(cell)];
    if (moments.num_points == 0) {
      moments.cell = cell;
      moments.first = p;
    }
    const Vector3d d = p - moments.first;
    moments.sum += d;
    moments.outer += d * d.transpose();
    ++moments.num_points;
  }
  return std::move(table.payloads());
}

void GaussianMap::sort_into_columns(const std::vector<SurfaceCell>& cells,
                                    const std::vector<CellIndex>& places) {
  if (cells.empty()) return;
  CellIndex high = places.front();
  corner_ = places.front();
  for (const CellIndex& place : places) {
    corner_ = corner_.cwiseMin(place);
    high = high.cwiseMax(place);
  }
  extent_ = high - corner_ + CellIndex::Ones();
  begins_.assign(column_of(extent_.x(), 0) + 1, 0);
  const auto column = [&](const CellIndex& place) {
    return column_of(place.x() - corner_.x(), place.y() - corner_.y());
  };
  for (const CellIndex& place : places) ++begins_[column(place) + 1];
  std::partial_sum(begins_.begin(), begins_.end(), begins_.begin());
  std::vector<std::uint32_t> next(begins_);
  cells_.resize(cells.size());
  shapes_.resize(cells.size());
  for (std::size_t i = 0; i < cells.size(); ++i) {
    const std::uint32_t to = next[column(places[i])]++;
    cells_[to] = cells[i];
    const bool is_plane = cells[i].num_thin == 1;
    shapes_[to] = {cells[i].mean, cells[i].axes.col(is_plane ? 0 : 2), places[i].z(), is_plane};
  }
}

const SurfaceCell* GaussianMap::at(const Vector3d& point) const {
  const CellIndex cell = cell_of(point);
  const CellIndex place = cell - corner_;
  if ((place.array() < 0).any() || (place.array() >= extent_.array()).any()) return nullptr;
  const std::size_t column = column_of(place.x(), place.y());
  for (std::uint32_t i = begins_[column]; i < begins_[column + 1]; ++i) {
    if (shapes_[i].z == cell.z()) return &cells_[i];
  }
  return nullptr;
}

std::optional<SurfaceMatch> GaussianMap::match(const Vector3d& point, double gate, double reach) const {
  const Vector3d margin = Vector3d::Constant(reach * cell_size_);
  const CellIndex low = cell_of(point - margin), high = cell_of(point + margin);
  const int low_y = std::max(low.y() - corner_.y(), 0),
            high_y = std::min(high.y() - corner_.y(), extent_.y() - 1);
  const int low_x = std::max(low.x() - corner_.x(), 0),
            high_x = std::min(high.x() - corner_.x(), extent_.x() - 1);
  if (low_y > high_y) return std::nullopt;
  const double width = 0.75 * cell_size_;
  const SurfaceCell* best = nullptr;
  double best_cost = gate * gate, best_across2 = 0.0;
  for (int x = low_x; x <= high_x; ++x) {
    const std::uint32_t end = begins_[column_of(x, high_y) + 1];
    for (std::uint32_t i = begins_[column_of(x, low_y)]; i < end; ++i) {
      const Shape& shape = shapes_[i];
      if (shape.z < low.z() || shape.z > high.z()) continue;
      const Vector3d d = point - shape.mean;
      const double on_axis = shape.axis.dot(d);
      const double on_axis2 = on_axis * on_axis, rest2 = std::max(0.0, d.squaredNorm() - on_axis2);
      const double across2 = shape.is_plane ? on_axis2 : rest2;
      if (across2 >= best_cost) continue;
      // A surface ends near its cell: what is beyond is judged by how far beyond it is.
      const double along2 = shape.is_plane ? rest2 : on_axis2;
      const double beyond = along2 > width * width ? std::sqrt(along2) - width : 0.0;
      const double cost = across2 + beyond * beyond;
      if (cost >= best_cost) continue;
      best_cost = cost;
      best_across2 = across2;
      best = &cells_[i];
    }
  }
  if (best == nullptr) return std::nullopt;
  return SurfaceMatch{best, std::sqrt(best_across2)};
}

}  // namespace mmlins::registration
