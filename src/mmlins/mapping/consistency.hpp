// SPDX-License-Identifier: MIT
#pragma once
// Closures between two worlds that tell the same story: each says how one world lies in the other, and true ones
// agree. docs/math/mapping.md, Eqs. (2) and (3).

#include <span>
#include <vector>

#include "mmlins/mapping/mapping_config.hpp"
#include "mmlins/math/se3.hpp"

namespace mmlins::mapping {

/// A closure as it is compared.
struct Placement {
  math::SE3 T_into_world;                             ///< how it places the world
  math::Vector3d p_world = math::Vector3d::Zero();    ///< where it was found, in the world [m]
  double source_way = 0.0;                            ///< way along the keyframes up to there [m]
  double target_way = 0.0;                            ///< and up to the keyframe that it leads to [m]
  double weight = 1.0;                                ///< how much it counts
};

[[nodiscard]] bool agree(const Placement& a, const Placement& b, const MergeConfig& config);

/// Positions of the largest set of which all agree with all others, by the sum of their weights; of equal ones the
/// first. At most the last 30 placements are looked at.
[[nodiscard]] std::vector<std::size_t> largest_agreement(std::span<const Placement> placements, const MergeConfig& config);

}  // namespace mmlins::mapping
