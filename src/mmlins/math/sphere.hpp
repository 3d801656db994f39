// SPDX-License-Identifier: MIT
#pragma once
// Directions of fixed length (gravity): a two-dimensional tangent. docs/math/lie_groups.md, Eqs. (6)-(8).

#include <Eigen/Core>

#include "mmlins/math/so3.hpp"

namespace mmlins::math {

using Vector2d = Eigen::Vector2d;
using Matrix32d = Eigen::Matrix<double, 3, 2>;

/// Two unit vectors that span the plane orthogonal to `direction`; a fixed function of it.
[[nodiscard]] Matrix32d sphere_basis(const Vector3d& direction);
/// direction [+] d = Exp(B d) direction; keeps the length.
[[nodiscard]] Vector3d sphere_plus(const Vector3d& direction, const Vector2d& d);
/// The d with base [+] d = other (both of the same length, not opposite).
[[nodiscard]] Vector2d sphere_minus(const Vector3d& other, const Vector3d& base);
/// Derivative of direction [+] d with respect to d, at d = 0: -[direction]x B.
[[nodiscard]] Matrix32d sphere_plus_jacobian(const Vector3d& direction);

}  // namespace mmlins::math
