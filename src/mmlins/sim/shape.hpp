// SPDX-License-Identifier: MIT
#pragma once
// What scenes are made of: boxes turned about the vertical, and upright cylinders.

#include <Eigen/Core>
#include <Eigen/Geometry>
#include <optional>

namespace mmlins::sim {

/// A half-line: origin + range * direction, |direction| = 1.
struct Ray {
  Eigen::Vector3d origin;  ///< [m]
  Eigen::Vector3d direction;
  double time = 0.0;  ///< at which it is shot, after the start of the recording [s]
};

enum class ShapeKind { kBox, kCylinder };

struct Shape {
  ShapeKind kind = ShapeKind::kBox;
  Eigen::Vector3d center = Eigen::Vector3d::Zero();     ///< [m]
  Eigen::Vector3d half_size = Eigen::Vector3d::Ones();  ///< [m]; of a cylinder: radius, radius, half height
  Eigen::Vector2d x_axis = Eigen::Vector2d::UnitX();    ///< of a box, horizontal unit vector
  double reflectivity = 0.5;                            ///< diffuse, 0 to 1
};

[[nodiscard]] Shape make_box(const Eigen::Vector3d& center, const Eigen::Vector3d& size, double yaw,
                             double reflectivity);
/// Upright, from z_min to z_max.
[[nodiscard]] Shape make_cylinder(const Eigen::Vector3d& foot, double radius, double height,
                                  double reflectivity);

[[nodiscard]] Eigen::AlignedBox3d bounds_of(const Shape& shape);

/// Faces are numbered: of a box -x +x -y +y -z +z, of a cylinder 0 for the side, 4 and 5 for the ends.
inline constexpr int kFacesPerShape = 6;

struct ShapeHit {
  double range = 0.0;  ///< [m]
  int face = 0;
};

/// Where the ray enters the (perfectly even) shape; nothing if it misses or starts inside.
[[nodiscard]] std::optional<ShapeHit> intersect(const Shape& shape, const Ray& ray);

/// Distance of a point from the infinite surface that a face is part of, positive outside, and the
/// direction in which it grows.
struct FaceDistance {
  double distance = 0.0;  ///< [m]
  Eigen::Vector3d normal = Eigen::Vector3d::UnitZ();
};
[[nodiscard]] FaceDistance distance_to_face(const Shape& shape, int face, const Eigen::Vector3d& p);

}  // namespace mmlins::sim
