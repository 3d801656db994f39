// SPDX-License-Identifier: MIT
#include "mmlins/math/sphere.hpp"

#include <cmath>

namespace mmlins::math {

// The x and y axes, carried along by the shortest rotation from -z to the direction: smooth everywhere but
// at +z, where gravity never points.
Matrix32d sphere_basis(const Vector3d& direction) {
  const Eigen::Quaterniond q = Eigen::Quaterniond::FromTwoVectors(-Vector3d::UnitZ(), direction);
  return q.toRotationMatrix().leftCols<2>();
}

Vector3d sphere_plus(const Vector3d& direction, const Vector2d& d) {
  return so3_exp(sphere_basis(direction) * d) * direction;
}

Vector2d sphere_minus(const Vector3d& other, const Vector3d& base) {
  const Vector3d axis = base.cross(other);
  const double sine = axis.norm();
  if (sine == 0.0) return Vector2d::Zero();
  const double angle = std::atan2(sine, base.dot(other));
  return sphere_basis(base).transpose() * (axis * (angle / sine));
}

Matrix32d sphere_plus_jacobian(const Vector3d& direction) { return -skew(direction) * sphere_basis(direction); }

}  // namespace mmlins::math
