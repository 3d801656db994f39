// SPDX-License-Identifier: MIT
#pragma once
// The same estimate seen from another frame. docs/math/eskf.md, section 6.

#include "mmlins/imu/propagation.hpp"

namespace mmlins::imu {

/// Everything that is in odom coordinates, in those of a frame in which odom is placed at `T_new_odom`. Eq. (23).
[[nodiscard]] NavState transformed(const math::SE3& T_new_odom, const NavState& state);
/// The same with its covariance. Eq. (24).
[[nodiscard]] Estimate transformed(const math::SE3& T_new_odom, const Estimate& estimate);

/// Derivative of the error that somebody sees who takes the pose of `state` for granted, by that of `state`. Eq. (25).
[[nodiscard]] ErrorMatrix jacobian_of_granted_pose(const NavState& state);
/// The estimate of somebody who takes the present pose for granted, because a new map begins here: what was
/// unknown of the attitude becomes unknown of velocity and gravity, and what was unknown of the place is
/// dropped. Eq. (25).
[[nodiscard]] Estimate with_pose_taken_for_granted(const Estimate& estimate);

}  // namespace mmlins::imu
