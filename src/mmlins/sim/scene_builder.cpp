// SPDX-License-Identifier: MIT
#include "mmlins/sim/scene_builder.hpp"

#include <algorithm>
#include <cmath>
#include <limits>
#include <utility>

namespace mmlins::sim {

using Eigen::Vector2d;
using Eigen::Vector3d;

SceneBuilder::SceneBuilder(std::uint64_t seed, Polygon keep_free, double clearance)
    : random_(seed), keep_free_(std::move(keep_free)), clearance_(clearance) {}

double SceneBuilder::distance_to_path(const Vector2d& place) const {
  double square = std::numeric_limits<double>::infinity();
  for (const Vector2d& p : keep_free_) square = std::min(square, (p - place).squaredNorm());
  return std::sqrt(square);
}

bool SceneBuilder::is_free(const Vector2d& center, double radius) const {
  return distance_to_path(center) > radius + clearance_;
}

void SceneBuilder::add(const BoxSpec& box) {
  const Vector3d center(box.center.x(), box.center.y(), 0.5 * (box.z_min + box.z_max));
  shapes_.push_back(
      make_box(center, {box.size.x(), box.size.y(), box.z_max - box.z_min}, box.yaw, reflectivity()));
}

void SceneBuilder::add_loose(const BoxSpec& box) {
  // The distance of the path from the box itself, not from a disc around it: cars are long.
  const Vector2d x_axis(std::cos(box.yaw), std::sin(box.yaw));
  const Vector2d y_axis(-x_axis.y(), x_axis.x());
  const bool blocked = std::any_of(keep_free_.begin(), keep_free_.end(), [&](const Vector2d& p) {
    const Vector2d q = p - box.center;
    const Vector2d outside(std::max(0.0, std::abs(q.dot(x_axis)) - 0.5 * box.size.x()),
                           std::max(0.0, std::abs(q.dot(y_axis)) - 0.5 * box.size.y()));
    return outside.norm() < clearance_;
  });
  if (!blocked) add(box);
}

void SceneBuilder::add_pole(const Vector2d& foot, double radius, double height) {
  if (!is_free(foot, radius)) return;
  shapes_.push_back(make_cylinder({foot.x(), foot.y(), -0.3}, radius, height + 0.3, reflectivity()));
}

void SceneBuilder::add_tree(const Vector2d& foot) {
  const double radius = random_.uniform(0.12, 0.3);
  const double trunk = random_.uniform(2.2, 3.2);
  if (!is_free(foot, radius)) return;
  add_pole(foot, radius, trunk + 0.5);
  // A crown of a few lumps: what matters is that it is not even.
  const int lumps = 3;
  for (int i = 0; i < lumps; ++i) {
    const Vector2d shift(random_.uniform(-0.8, 0.8), random_.uniform(-0.8, 0.8));
    const double bottom = trunk + random_.uniform(0.0, 1.2);
    const Vector2d center = foot + shift;
    shapes_.push_back(make_cylinder({center.x(), center.y(), bottom}, random_.uniform(0.6, 1.3),
                                    random_.uniform(1.0, 2.2), random_.uniform(0.2, 0.5)));
  }
}

void SceneBuilder::add_wall(const Vector2d& a, const Vector2d& b, double thickness, const Vector2d& z_range) {
  const Vector2d along = b - a;
  add({0.5 * (a + b), {along.norm(), thickness}, z_range.x(), z_range.y(), std::atan2(along.y(), along.x())});
}

}  // namespace mmlins::sim
