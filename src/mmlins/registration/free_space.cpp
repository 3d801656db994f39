// SPDX-License-Identifier: MIT
#include "mmlins/registration/free_space.hpp"

#include <algorithm>
#include <cmath>

namespace mmlins::registration {

namespace {

using math::Vector3d;

constexpr std::size_t kMaxRays = 1500;
constexpr double kNearEnds = 0.75;        // what lies this near to either end is no crossing [m]
constexpr double kMinCosIncidence = 0.4;  // along a surface, a small error of the pose is enough to cross it
constexpr double kInnerPart = 0.35;       // of a cell, from its mean, in which its surface surely is [cells]

struct Ray {
  Vector3d origin;
  Vector3d direction;  // unit
  double length = 0.0;
};

bool passes_through(const Ray& ray, const SurfaceCell& cell, double cell_size) {
  if (cell.num_thin != 1) return false;
  const Vector3d normal = cell.axes.col(0);
  const double cosine = normal.dot(ray.direction);
  if (std::abs(cosine) < kMinCosIncidence) return false;
  const double range = normal.dot(cell.mean - ray.origin) / cosine;
  if (range < kNearEnds || range > ray.length - kNearEnds) return false;
  return (ray.origin + range * ray.direction - cell.mean).norm() < kInnerPart * cell_size;
}

bool crosses(const Ray& ray, const GaussianMap& map) {
  const SurfaceCell* previous = nullptr;
  for (double range = kNearEnds; range < ray.length - kNearEnds; range += 0.5 * map.cell_size()) {
    const SurfaceCell* cell = map.at(ray.origin + range * ray.direction);
    if (cell == nullptr || cell == previous) continue;
    if (passes_through(ray, *cell, map.cell_size())) return true;
    previous = cell;
  }
  return false;
}

double one_way(const PreparedSubmap& from, const PreparedSubmap& through, const math::SE3& T_through_from) {
  const std::size_t count = std::min(kMaxRays, from.samples.size());
  std::size_t tested = 0, crossing = 0;
  for (std::size_t k = 0; k < count; ++k) {
    const std::size_t i = k * from.samples.size() / count;
    const Vector3d origin = T_through_from * from.viewpoints[i];
    const Vector3d along = T_through_from * from.samples[i] - origin;
    const double length = along.norm();
    if (length < 2.0 * kNearEnds) continue;
    ++tested;
    if (crosses({origin, along / length, length}, through.levels.back())) ++crossing;
  }
  return tested > 0 ? static_cast<double>(crossing) / static_cast<double>(tested) : 0.0;
}

}  // namespace

double crossing_share(const PreparedSubmap& source, const PreparedSubmap& target,
                      const math::SE3& T_target_source) {
  return std::max(one_way(source, target, T_target_source),
                  one_way(target, source, T_target_source.inverse()));
}

}  // namespace mmlins::registration
