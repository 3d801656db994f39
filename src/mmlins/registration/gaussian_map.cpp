// SPDX-License-Identifier: MIT
#include "mmlins/registration/gaussian_map.hpp"

#include <Eigen/Eigenvalues>
#include <cmath>

namespace mmlins::registration {

namespace {

using math::Matrix3d;
using math::Vector3d;

// A pole stands: lines that lie are the rings of a scanner on the ground more often than anything real.
constexpr double kUpright = 0.85;

struct Moments {
  Vector3d sum = Vector3d::Zero();
  Matrix3d outer = Matrix3d::Zero();
};

int num_thin_axes(const SurfaceCell& cell, double cell_size, const SurfaceConfig& config) {
  const double max_variance = config.max_thickness * config.max_thickness;
  const double width = config.min_width_in_cells * cell_size;
  const Vector3d& v = cell.variances;
  const bool wide = v(1) > width * width;
  if (wide) return v(0) < max_variance && v(0) < config.max_flatness_ratio * v(1) ? 1 : 0;
  const bool is_pole = v(2) > width * width && v(1) < max_variance && v(1) < config.max_flatness_ratio * v(2);
  return is_pole && std::abs(cell.axes(2, 2)) > kUpright ? 2 : 0;
}

void fit(SurfaceCell& cell, const Moments& moments, double cell_size, const SurfaceConfig& config) {
  if (cell.num_points < config.min_points) return;
  const Vector3d mean = moments.sum / cell.num_points;  // relative to cell.mean, which is the first point
  const Matrix3d scatter = moments.outer / cell.num_points - mean * mean.transpose();
  Eigen::SelfAdjointEigenSolver<Matrix3d> solver;
  solver.computeDirect(scatter);
  cell.mean += mean;
  cell.axes = solver.eigenvectors();
  cell.variances = solver.eigenvalues().cwiseMax(0.0);
  cell.num_thin = num_thin_axes(cell, cell_size, config);
}

}  // namespace

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
    : cells_(cell_size) {
  std::vector<Moments> moments;
  for (const Eigen::Vector3f& point : points) {
    const Vector3d p = point.cast<double>();
    const std::uint32_t id = cells_.find_or_add(cells_.index_of(p));
    moments.resize(cells_.payloads().size());
    SurfaceCell& cell = cells_.payloads()[id];
    if (cell.num_points == 0) cell.mean = p;
    const Vector3d d = p - cell.mean;
    moments[id].sum += d;
    moments[id].outer += d * d.transpose();
    ++cell.num_points;
  }
  for (std::size_t i = 0; i < moments.size(); ++i) fit(cells_.payloads()[i], moments[i], cell_size, config);
}

const SurfaceCell* GaussianMap::at(const Vector3d& point) const {
  const std::int64_t id = cells_.find(cells_.index_of(point));
  if (id < 0) return nullptr;
  const SurfaceCell& cell = cells_.payloads()[static_cast<std::size_t>(id)];
  return cell.num_thin > 0 ? &cell : nullptr;
}

std::optional<SurfaceMatch> GaussianMap::match(const Vector3d& point, double gate, double reach) const {
  const double margin = reach * cell_size();
  const spatial::CellIndex low = cells_.index_of(point - Vector3d::Constant(margin));
  const spatial::CellIndex high = cells_.index_of(point + Vector3d::Constant(margin));
  std::optional<SurfaceMatch> best;
  double best_cost = gate * gate;
  for (int x = low.x(); x <= high.x(); ++x) {
    for (int y = low.y(); y <= high.y(); ++y) {
      for (int z = low.z(); z <= high.z(); ++z) {
        const std::int64_t id = cells_.find({x, y, z});
        if (id < 0) continue;
        const SurfaceCell& cell = cells_.payloads()[static_cast<std::size_t>(id)];
        if (cell.num_thin == 0) continue;
        const Vector3d d = cell.axes.transpose() * (point - cell.mean);
        const bool is_plane = cell.num_thin == 1;
        const double across2 = d.x() * d.x() + (is_plane ? 0.0 : d.y() * d.y());
        // A surface ends near its cell: what is beyond is judged by how far beyond it is.
        const double along = std::sqrt(d.z() * d.z() + (is_plane ? d.y() * d.y() : 0.0));
        const double beyond = std::max(0.0, along - 0.75 * cell_size());
        const double cost = across2 + beyond * beyond;
        if (cost >= best_cost) continue;
        best_cost = cost;
        best = SurfaceMatch{&cell, std::sqrt(across2)};
      }
    }
  }
  return best;
}

}  // namespace mmlins::registration
