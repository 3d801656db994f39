// SPDX-License-Identifier: MIT
#pragma once
// Rotations: exponential, logarithm and their Jacobians. Right perturbation throughout: R [+] w = R Exp(w).
// Formulas: docs/math/lie_groups.md.

#include <Eigen/Core>
#include <Eigen/Geometry>

namespace mmlins::math {

using Eigen::Matrix3d;
using Eigen::Vector3d;

/// The matrix with skew(a) * b = a x b.
[[nodiscard]] Matrix3d skew(const Vector3d& a);

/// Rotation by |w| [rad] about w. docs/math/lie_groups.md, Eq. (1).
[[nodiscard]] Matrix3d so3_exp(const Vector3d& w);
/// The same as unit quaternion.
[[nodiscard]] Eigen::Quaterniond so3_exp_quaternion(const Vector3d& w);
/// Rotation vector of R, of length at most pi [rad]. Eq. (2).
[[nodiscard]] Vector3d so3_log(const Matrix3d& R);
[[nodiscard]] Vector3d so3_log(const Eigen::Quaterniond& q);

/// Right Jacobian: Exp(w + d) ~ Exp(w) Exp(Jr(w) d). Eq. (3).
[[nodiscard]] Matrix3d so3_right_jacobian(const Vector3d& w);
/// Its inverse: Log(Exp(w) Exp(d)) ~ w + Jr^-1(w) d. Eq. (4).
[[nodiscard]] Matrix3d so3_right_jacobian_inverse(const Vector3d& w);

/// The closest rotation matrix in the Frobenius norm.
[[nodiscard]] Matrix3d nearest_rotation(const Matrix3d& M);

}  // namespace mmlins::math
