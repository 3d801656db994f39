// SPDX-License-Identifier: MIT
#pragma once
// Errors of the factors of a pose graph and their Jacobians with respect to right perturbations of the poses
// in the world. Derivations: docs/math/pose_graph.md.

#include "mmlins/graph/pose_graph.hpp"

namespace mmlins::graph {

/// T [+] [w; u] = (R Exp(w), t + R u). docs/math/pose_graph.md, Eq. (1).
[[nodiscard]] SE3 retract(const SE3& T, const Vector6d& step);

/// Error of a measured relative pose, not whitened.
struct EdgeError {
  Vector6d e;       ///< [rotation; translation]
  Matrix6d J_from;  ///< d e / d step of the pose of `from`
  Matrix6d J_to;
};

/// Eqs. (2) to (4).
[[nodiscard]] Vector6d edge_error(const SE3& T_world_from, const SE3& T_world_to, const SE3& T_from_to);
[[nodiscard]] EdgeError linearize_edge(const SE3& T_world_from, const SE3& T_world_to, const SE3& T_from_to);

/// Error of a sensed upward direction, and its Jacobian with respect to the rotation of the node. Eq. (5).
struct GravityError {
  Vector3d e;
  math::Matrix3d J_rotation;
};
[[nodiscard]] GravityError linearize_gravity(const math::Matrix3d& R_world_node, const Vector3d& up_node);

/// A matrix S with S^T S = information, whose rows for directions without information are zero.
struct SquareRoot {
  Matrix6d S = Matrix6d::Zero();
  int rank = 0;
};
/// Eq. (6). Directions with less than `kRankTolerance` of the scale of their axes count as unknown.
[[nodiscard]] SquareRoot square_root(const Matrix6d& information);
inline constexpr double kRankTolerance = 1e-12;

/// True for finite symmetric matrices without negative eigenvalues, to rounding.
[[nodiscard]] bool is_information(const Matrix6d& information);

}  // namespace mmlins::graph
