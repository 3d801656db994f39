// SPDX-License-Identifier: MIT
#pragma once
// Where a ray went there was nothing: two submaps laid over each other wrongly have rays through walls.

#include "mmlins/registration/register_submaps.hpp"

namespace mmlins::registration {

/// Share of the rays of either submap that pass through a surface of the other; the larger of both.
[[nodiscard]] double crossing_share(const PreparedSubmap& source, const PreparedSubmap& target,
                                    const math::SE3& T_target_source);

}  // namespace mmlins::registration
