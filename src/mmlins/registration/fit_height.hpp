// SPDX-License-Identifier: MIT
#pragma once
// The height at which two level submaps fit, once x, y and yaw are known from above. Floors alone do not
// tell: a scanner that looks up sees ceilings where another one sees the floor.

#include "mmlins/keyframe/submap.hpp"

namespace mmlins::registration {

/// T_target_source with the z, within `range` [m] of the one given, at which most points of the source fall
/// into occupied cells of the target; what stands counts more than what lies. Of equal ones the nearest to
/// the given.
[[nodiscard]] math::SE3 fit_height(const keyframe::Submap& source, const keyframe::Submap& target,
                                   const math::SE3& T_target_source, double range);

}  // namespace mmlins::registration
