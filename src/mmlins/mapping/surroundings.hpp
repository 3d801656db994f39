// SPDX-License-Identifier: MIT
#pragma once
// Which keyframes the robot has around it, now that places were recognised: those that it comes from, and
// those of other maps and other times. docs/math/mapping.md, "Back to the odometry".

#include <optional>
#include <vector>

#include "mmlins/mapping/map_graph.hpp"

namespace mmlins::mapping {

/// A keyframe and where it lies in the frame that the odometry has for the active map.
struct PlacedKeyframe {
  int id = 0;
  math::SE3 T_map_imu;
};

struct Surroundings {
  std::vector<PlacedKeyframe>
      known;                ///< that a map which grew along the way does not hold, or not in the right place
  std::vector<int> recent;  ///< that it does hold: the way on which the robot came, the latest last
};

/// Where the world lies in the frame that the odometry has for the active map. There the robot stays where it
/// is; and where the world was laid before is kept as long as it is right to `config.kept_within`: laid anew
/// at every turn, it would wander by what each pose is off.
/// @param T_map_imu  of each keyframe as the odometry had it, up to the latest, which is where the robot is
/// @param before     where it was laid the last time, if it was
[[nodiscard]] math::SE3 place_world(const MapGraph& graph, const std::vector<math::SE3>& T_map_imu,
                                    const std::optional<math::SE3>& before, const RebuildConfig& config);

[[nodiscard]] Surroundings surroundings_of_latest(const MapGraph& graph,
                                                  const std::vector<math::SE3>& T_map_imu,
                                                  const math::SE3& T_map_world, const RebuildConfig& config);

}  // namespace mmlins::mapping
