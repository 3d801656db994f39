// SPDX-License-Identifier: MIT
#include "mmlins/spatial/plane_map.hpp"

#include <Eigen/Eigenvalues>
#include <cmath>
#include <numbers>

#include "mmlins/base/parallel.hpp"

namespace mmlins::spatial {

namespace {
// Walking all cells costs milliseconds; a tenth of the radius may pile up before it is worth it.
constexpr double kEvictionStep = 0.1;
}  // namespace

Fields PlaneMapConfig::fields() {
  return {
      field("finest_cell", finest_cell, "m", {0.05, 2.0}, "edge of the smallest cells; each level above doubles it"),
      field("num_levels", num_levels, "", {1.0, 6.0}, "number of grids"),
      field("reach_in_cells", reach_in_cells, "", {10.0, 10000.0},
            "a grid holds no cells farther from the sensor than this many of its edges: there they would stay too empty"),
      field("min_points", min_points, "", {4.0, 100.0}, "points that a cell needs before a plane is fitted"),
      field("max_points", max_points, "", {10.0, 10000.0}, "points after which a cell is left as it is"),
      field("max_thickness", max_thickness, "m", {0.001, 1.0}, "standard deviation across the plane that still counts as flat"),
      field("max_flatness_ratio", max_flatness_ratio, "", {1e-4, 0.5},
            "largest ratio of the variance across the plane to the smaller variance along it"),
      field("min_width_sigmas", min_width_sigmas, "", {0.0, 100.0},
            "the narrower spread along a plane must exceed this many standard deviations of the range"),
      field("min_incidence_deg", min_incidence_deg, "deg", {0.0, 45.0},
            "the beams must have met the plane at this angle at least (root mean square): else it is what they sweep"),
      field("offset_noise", offset_noise, "m", {0.0, 0.5},
            "standard deviation of a plane's position that no number of points averages out: the poses they were seen from"),
  };
}

double PlaneMap::reach_of(const VoxelTable<Cell>& level) const { return config_.reach_in_cells * level.cell_size(); }

PlaneMap::PlaneMap(const PlaneMapConfig& config, double range_noise)
    : config_(config),
      range_variance_(range_noise * range_noise),
      last_evictions_(static_cast<std::size_t>(config.num_levels), Eigen::Vector3d::Zero()) {
  double cell_size = config.finest_cell;
  for (int i = 0; i < config.num_levels; ++i, cell_size *= 2.0) levels_.emplace_back(cell_size);
}

void PlaneMap::insert(std::span<const Eigen::Vector3d> points, const Eigen::Vector3d& viewpoint) {
  // Levels share nothing, so each may have its own thread.
  parallel::for_each_chunk(levels_.size(), [&](std::size_t i) {
    VoxelTable<Cell>& level = levels_[i];
    std::vector<std::uint32_t> grown;
    const double reach = reach_of(level);
    for (const Eigen::Vector3d& point : points) {
      const Eigen::Vector3d beam = point - viewpoint;
      if (beam.squaredNorm() < reach * reach) add_point(level, point, beam.normalized(), grown);
    }
    for (const std::uint32_t id : grown) fit_plane(level.payloads()[id]);
  });
}

void PlaneMap::add_point(VoxelTable<Cell>& level, const Eigen::Vector3d& point, const Eigen::Vector3d& beam,
                         std::vector<std::uint32_t>& grown) {
  const std::uint32_t id = level.find_or_add(level.index_of(point));
  Cell& cell = level.payloads()[id];
  if (cell.num_points >= config_.max_points) return;
  if (cell.num_points == 0) cell.origin = point;
  const Eigen::Vector3f d = (point - cell.origin).cast<float>();
  cell.sum += d;
  cell.outer += d * d.transpose();
  cell.beams += (beam * beam.transpose()).cast<float>();
  ++cell.num_points;
  // Refit when a fifth more points have come: a cell is fitted a few dozen times in its life.
  const bool due = cell.num_points >= config_.min_points && 5 * cell.num_points >= 6 * cell.num_points_at_fit;
  if (due && (grown.empty() || grown.back() != id)) grown.push_back(id);
}

void PlaneMap::fit_plane(Cell& cell) const {
  if (5 * cell.num_points < 6 * cell.num_points_at_fit) return;
  cell.num_points_at_fit = cell.num_points;
  const double inverse = 1.0 / cell.num_points;
  const Eigen::Vector3d mean = cell.sum.cast<double>() * inverse;
  const Eigen::Matrix3d scatter = cell.outer.cast<double>() * inverse - mean * mean.transpose();
  Eigen::SelfAdjointEigenSolver<Eigen::Matrix3d> solver;
  solver.computeDirect(scatter);
  const Eigen::Vector3d spread = solver.eigenvalues().cwiseMax(0.0);
  // Range noise alone spreads the points of one ring along the beam: together with the ring's own direction
  // that makes a perfect plane which is not there, the one that the beams sweep.
  const double least_width2 = config_.min_width_sigmas * config_.min_width_sigmas * range_variance_;
  const Eigen::Vector3d normal = solver.eigenvectors().col(0);
  // One ring alone cuts whatever it meets, corners and trees too, in a flat curve. What the beams sweep lies along them.
  const double incidence2 = normal.dot(cell.beams.cast<double>() * normal) * inverse;
  const double least_incidence = std::sin(config_.min_incidence_deg * std::numbers::pi / 180.0);
  cell.is_plane = spread(1) > least_width2 && spread(0) < config_.max_thickness * config_.max_thickness &&
                  spread(0) < config_.max_flatness_ratio * spread(1) && incidence2 > least_incidence * least_incidence;
  cell.mean = mean.cast<float>();
  cell.normal = normal.cast<float>();
  cell.middle = solver.eigenvectors().col(1).cast<float>();
  cell.spread = spread.cast<float>();
}

PlaneMatch PlaneMap::match_cell(const Cell& cell, const Eigen::Vector3d& point, double gate) const {
  PlaneMatch match;
  const Eigen::Vector3d from_mean = point - cell.origin - cell.mean.cast<double>();
  const Eigen::Vector3d normal = cell.normal.cast<double>();
  const double distance = normal.dot(from_mean);
  if (std::abs(distance) > gate) return match;
  const Eigen::Vector3d middle = cell.middle.cast<double>();
  const double along_middle = middle.dot(from_mean);
  const double along_widest2 = std::max(0.0, from_mean.squaredNorm() - distance * distance - along_middle * along_middle);
  const double lever = 1.0 + along_middle * along_middle / static_cast<double>(cell.spread(1)) +
                       along_widest2 / static_cast<double>(cell.spread(2));
  match.found = true;
  match.normal = normal;
  match.distance = distance;
  match.surface_variance = std::max(static_cast<double>(cell.spread(0)), range_variance_);
  match.plane_variance =
      lever * (match.surface_variance / cell.num_points_at_fit + config_.offset_noise * config_.offset_noise);
  const double mean_variance = match.surface_variance / cell.num_points_at_fit;
  match.widest = middle.cross(normal);
  match.tilt_variance_middle = mean_variance / static_cast<double>(cell.spread(1));
  match.tilt_variance_widest = mean_variance / static_cast<double>(cell.spread(2));
  return match;
}

PlaneMatch PlaneMap::match(const Eigen::Vector3d& point, double gate) const {
  PlaneMatch best;
  for (std::size_t i = 0; i < levels_.size(); ++i) {
    const std::int64_t id = levels_[i].find(levels_[i].index_of(point));
    if (id < 0) continue;
    const Cell& cell = levels_[i].payloads()[static_cast<std::size_t>(id)];
    if (!cell.is_plane) continue;
    PlaneMatch match = match_cell(cell, point, gate);
    if (!match.found) continue;
    const double variance = match.surface_variance + match.plane_variance;
    if (best.found && variance >= best.surface_variance + best.plane_variance) continue;
    match.plane_id = static_cast<std::uint32_t>(static_cast<std::size_t>(id) * levels_.size() + i);
    best = match;
  }
  return best;
}

void PlaneMap::evict_beyond(const Eigen::Vector3d& centre, double radius) {
  // One level per call, in turn, spreads the work over several scans.
  const std::size_t i = next_level_to_evict_;
  next_level_to_evict_ = (i + 1) % levels_.size();
  VoxelTable<Cell>& level = levels_[i];
  const double reach = std::min(radius, reach_of(level));
  if ((centre - last_evictions_[i]).norm() < kEvictionStep * reach) return;
  last_evictions_[i] = centre;
  level.keep_if([&](const CellIndex& index, const Cell&) {
    return (level.centre_of(index) - centre).squaredNorm() < reach * reach;
  });
}

std::size_t PlaneMap::num_cells() const {
  std::size_t sum = 0;
  for (const auto& level : levels_) sum += level.payloads().size();
  return sum;
}

}  // namespace mmlins::spatial
