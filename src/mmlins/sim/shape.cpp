// SPDX-License-Identifier: MIT
#include "mmlins/sim/shape.hpp"

#include <cmath>
#include <limits>

namespace mmlins::sim {

namespace {

using Eigen::Vector2d;
using Eigen::Vector3d;

Vector3d to_box(const Shape& box, const Vector3d& v) {
  return {box.x_axis.x() * v.x() + box.x_axis.y() * v.y(), -box.x_axis.y() * v.x() + box.x_axis.x() * v.y(),
          v.z()};
}

Vector3d from_box(const Shape& box, const Vector3d& v) {
  return {box.x_axis.x() * v.x() - box.x_axis.y() * v.y(), box.x_axis.y() * v.x() + box.x_axis.x() * v.y(),
          v.z()};
}

std::optional<ShapeHit> intersect_box(const Shape& box, const Ray& ray) {
  const Vector3d origin = to_box(box, ray.origin - box.center);
  const Vector3d direction = to_box(box, ray.direction);
  ShapeHit hit;
  double exit = std::numeric_limits<double>::infinity();
  for (int axis = 0; axis < 3; ++axis) {
    if (direction(axis) == 0.0) {
      if (std::abs(origin(axis)) > box.half_size(axis)) return std::nullopt;
      continue;
    }
    const double inverse = 1.0 / direction(axis);
    const double to_middle = -origin(axis) * inverse;
    const double reach = box.half_size(axis) * std::abs(inverse);
    if (to_middle - reach > hit.range) hit = {to_middle - reach, 2 * axis + (direction(axis) > 0.0 ? 0 : 1)};
    exit = std::min(exit, to_middle + reach);
  }
  if (hit.range <= 0.0 || hit.range > exit) return std::nullopt;
  return hit;
}

std::optional<ShapeHit> intersect_cylinder(const Shape& cylinder, const Ray& ray) {
  const Vector3d origin = ray.origin - cylinder.center;
  const double radius = cylinder.half_size.x();
  const double half_height = cylinder.half_size.z();
  const double a = ray.direction.head<2>().squaredNorm();
  const double b = origin.head<2>().dot(ray.direction.head<2>());
  const double c = origin.head<2>().squaredNorm() - radius * radius;
  if (a > 0.0) {
    const double discriminant = b * b - a * c;
    if (discriminant <= 0.0) return std::nullopt;
    const double range = (-b - std::sqrt(discriminant)) / a;
    if (range > 0.0 && std::abs(origin.z() + range * ray.direction.z()) <= half_height)
      return ShapeHit{range, 0};
  }
  if (ray.direction.z() == 0.0) return std::nullopt;
  const bool from_above = ray.direction.z() < 0.0;
  const double range = ((from_above ? half_height : -half_height) - origin.z()) / ray.direction.z();
  const Vector2d on_end = origin.head<2>() + range * ray.direction.head<2>();
  if (range <= 0.0 || on_end.squaredNorm() > radius * radius) return std::nullopt;
  return ShapeHit{range, from_above ? 5 : 4};
}

}  // namespace

Shape make_box(const Vector3d& center, const Vector3d& size, double yaw, double reflectivity) {
  return {ShapeKind::kBox, center, 0.5 * size, {std::cos(yaw), std::sin(yaw)}, reflectivity};
}

Shape make_cylinder(const Vector3d& foot, double radius, double height, double reflectivity) {
  return {ShapeKind::kCylinder,
          foot + Vector3d(0, 0, 0.5 * height),
          {radius, radius, 0.5 * height},
          {1, 0},
          reflectivity};
}

Eigen::AlignedBox3d bounds_of(const Shape& shape) {
  Vector3d reach = shape.half_size;
  if (shape.kind == ShapeKind::kBox) {
    const Vector2d axis = shape.x_axis.cwiseAbs();
    reach.x() = axis.x() * shape.half_size.x() + axis.y() * shape.half_size.y();
    reach.y() = axis.y() * shape.half_size.x() + axis.x() * shape.half_size.y();
  }
  return {shape.center - reach, shape.center + reach};
}

std::optional<ShapeHit> intersect(const Shape& shape, const Ray& ray) {
  return shape.kind == ShapeKind::kBox ? intersect_box(shape, ray) : intersect_cylinder(shape, ray);
}

FaceDistance distance_to_face(const Shape& shape, int face, const Vector3d& p) {
  const Vector3d from_center = p - shape.center;
  if (shape.kind == ShapeKind::kCylinder && face < 4) {
    const double radius = from_center.head<2>().norm();
    return {radius - shape.half_size.x(), {from_center.x() / radius, from_center.y() / radius, 0.0}};
  }
  const int axis = face / 2;
  const double sign = face % 2 == 1 ? 1.0 : -1.0;
  Vector3d normal = sign * Vector3d::Unit(axis);
  if (shape.kind == ShapeKind::kBox) normal = from_box(shape, normal);
  return {normal.dot(from_center) - shape.half_size(axis), normal};
}

}  // namespace mmlins::sim
