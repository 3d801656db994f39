// SPDX-License-Identifier: MIT
#include "mmlins/spatial/knn_map.hpp"

#include <Eigen/Eigenvalues>

namespace mmlins::spatial {

Fields KnnMapConfig::fields() {
  return {
      field("cell", cell, "m", {0.1, 5.0}, "edge of a cell; neighbours come from the 27 cells around a point"),
      field("min_spacing", min_spacing, "m", {0.0, 1.0}, "a point nearer than this to one of its cell is not stored"),
      field("max_neighbour_distance", max_neighbour_distance, "m", {0.1, 10.0}, "farther neighbours do not make a plane"),
      field("max_plane_error", max_plane_error, "m", {0.001, 1.0}, "largest distance of a neighbour from the fitted plane"),
  };
}

KnnMap::KnnMap(const KnnMapConfig& config, double range_noise)
    : config_(config), range_variance_(range_noise * range_noise), table_(config.cell) {}

void KnnMap::insert(std::span<const Eigen::Vector3d> points, const Eigen::Vector3d& /*viewpoint*/) {
  const double spacing2 = config_.min_spacing * config_.min_spacing;
  for (const Eigen::Vector3d& point : points) {
    Cell& cell = table_.payloads()[table_.find_or_add(table_.index_of(point))];
    if (cell.num_points == kCapacity) continue;
    const bool crowded = std::any_of(cell.points.begin(), cell.points.begin() + cell.num_points,
                                     [&](const Eigen::Vector3d& other) { return (other - point).squaredNorm() < spacing2; });
    if (!crowded) cell.points[static_cast<std::size_t>(cell.num_points++)] = point;
  }
}

KnnMap::Neighbours KnnMap::nearest(const Eigen::Vector3d& point) const {
  Neighbours best;
  const CellIndex centre = table_.index_of(point);
  const auto consider = [&](const Eigen::Vector3d& other) {
    const double distance2 = (other - point).squaredNorm();
    if (best.count == kNeighbours && distance2 >= best.distances2[kNeighbours - 1]) return;
    int i = best.count < kNeighbours ? best.count++ : kNeighbours - 1;
    for (; i > 0 && best.distances2[static_cast<std::size_t>(i - 1)] > distance2; --i) {
      best.distances2[static_cast<std::size_t>(i)] = best.distances2[static_cast<std::size_t>(i - 1)];
      best.points[static_cast<std::size_t>(i)] = best.points[static_cast<std::size_t>(i - 1)];
    }
    best.distances2[static_cast<std::size_t>(i)] = distance2;
    best.points[static_cast<std::size_t>(i)] = other;
  };
  for (int n = 0; n < 27; ++n) {
    const std::int64_t id = table_.find(centre + CellIndex(n % 3 - 1, n / 3 % 3 - 1, n / 9 - 1));
    if (id < 0) continue;
    const Cell& cell = table_.payloads()[static_cast<std::size_t>(id)];
    for (int i = 0; i < cell.num_points; ++i) consider(cell.points[static_cast<std::size_t>(i)]);
  }
  return best;
}

PlaneMatch KnnMap::match(const Eigen::Vector3d& point, double gate) const {
  PlaneMatch match;
  const Neighbours near = nearest(point);
  const double reach = config_.max_neighbour_distance;
  if (near.count < kNeighbours || near.distances2[kNeighbours - 1] > reach * reach) return match;
  Eigen::Vector3d mean = Eigen::Vector3d::Zero();
  for (const Eigen::Vector3d& p : near.points) mean += p / kNeighbours;
  Eigen::Matrix3d scatter = Eigen::Matrix3d::Zero();
  for (const Eigen::Vector3d& p : near.points) scatter += (p - mean) * (p - mean).transpose() / kNeighbours;
  Eigen::SelfAdjointEigenSolver<Eigen::Matrix3d> solver;
  solver.computeDirect(scatter);
  match.normal = solver.eigenvectors().col(0);
  for (const Eigen::Vector3d& p : near.points) {
    if (std::abs(match.normal.dot(p - mean)) > config_.max_plane_error) return match;
  }
  match.distance = match.normal.dot(point - mean);
  match.found = std::abs(match.distance) <= gate;
  match.surface_variance = std::max(range_variance_, solver.eigenvalues()(0));
  match.plane_variance = match.surface_variance / kNeighbours;
  match.widest = solver.eigenvectors().col(2);
  match.tilt_variance_middle = match.plane_variance / std::max(solver.eigenvalues()(1), 1e-9);
  match.tilt_variance_widest = match.plane_variance / std::max(solver.eigenvalues()(2), 1e-9);
  return match;
}

void KnnMap::evict_beyond(const Eigen::Vector3d& centre, double radius) {
  if ((centre - last_eviction_).norm() < 0.1 * radius) return;
  last_eviction_ = centre;
  table_.keep_if([&](const CellIndex& index, const Cell&) {
    return (table_.centre_of(index) - centre).squaredNorm() < radius * radius;
  });
}

}  // namespace mmlins::spatial
