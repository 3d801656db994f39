// SPDX-License-Identifier: MIT
#include "mmlins/sim/mover.hpp"

#include <algorithm>
#include <cmath>
#include <utility>

namespace mmlins::sim {

namespace {

using Eigen::Vector2d;
using Eigen::Vector3d;

// Boxes of length, width and height from a height above the ground on.
Shape part(const Vector3d& size, double z, double yaw, double reflectivity) {
  return make_box({0.0, 0.0, z + 0.5 * size.z()}, size, yaw, reflectivity);
}

std::vector<Shape> person(double yaw) {
  return {part({0.26, 0.36, 0.85}, 0.0, yaw, 0.3), part({0.4, 0.5, 0.62}, 0.85, yaw, 0.5),
          make_cylinder({0.0, 0.0, 1.47}, 0.11, 0.28, 0.4)};
}

std::vector<Shape> car(double yaw) {
  return {part({4.3, 1.8, 0.75}, 0.2, yaw, 0.5), part({2.3, 1.6, 0.55}, 0.95, yaw, 0.4)};
}

}  // namespace

Vector3d size_of(MoverKind kind) {
  return kind == MoverKind::kPerson ? Vector3d(0.4, 0.5, 1.75) : Vector3d(4.3, 1.8, 1.5);
}

MoverInstant mover_instant(double seconds) {
  const double ticks = std::max(0.0, seconds) / kMoverTick;
  const double whole = std::floor(ticks);
  return {static_cast<std::size_t>(whole), ticks - whole};
}

Mover::Mover(MoverKind kind, Lane lane, std::vector<std::int16_t> cells)
    : kind_(kind), lane_(std::move(lane)), cells_(std::move(cells)) {
  const double yaw = std::atan2(lane_.along.y(), lane_.along.x());
  shapes_ = kind == MoverKind::kPerson ? person(yaw) : car(yaw);
  height_ = size_of(kind).z();
  radius_ = 0.5 * size_of(kind).norm();
}

std::optional<Vector3d> Mover::place(const MoverInstant& now) const {
  if (now.tick + 1 >= cells_.size()) return std::nullopt;
  const std::int16_t here = cells_[now.tick], next = cells_[now.tick + 1];
  if (here < 0 || next < 0) return std::nullopt;
  const double cell = here + now.share * (next - here);
  const double z0 = lane_.heights[static_cast<std::size_t>(here)];
  const double z1 = lane_.heights[static_cast<std::size_t>(next)];
  const Vector2d at = lane_.from + cell * lane_.cell * lane_.along;
  return Vector3d(at.x(), at.y(), z0 + now.share * (z1 - z0));
}

double Mover::distance_from_body(const Vector2d& p, const Vector3d& place) const {
  const Vector2d q = p - place.head<2>();
  const Vector3d size = size_of(kind_);
  const double ahead = std::abs(q.dot(lane_.along));
  const double aside = std::abs(lane_.along.x() * q.y() - lane_.along.y() * q.x());
  return std::hypot(std::max(0.0, ahead - 0.5 * size.x()), std::max(0.0, aside - 0.5 * size.y()));
}

}  // namespace mmlins::sim
