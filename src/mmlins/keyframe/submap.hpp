// SPDX-License-Identifier: MIT
#pragma once
// The unit in which places are recognised: what was seen over some metres of travel, levelled by gravity.
// After that much motion a scanner of 16 rings and one that never repeats its pattern look alike, and two
// submaps of one place differ by x, y, z and yaw only.

#include <cstdint>
#include <span>
#include <vector>

#include "mmlins/base/config_fields.hpp"
#include "mmlins/keyframe/keyframe.hpp"

namespace mmlins::keyframe {

struct SubmapConfig {
  double travel = 15.0;
  double max_turn_deg = 360.0;
  double voxel = 0.25;
  double radius = 60.0;

  [[nodiscard]] Fields fields();
};

/// The frame of a submap: origin at the IMU of its middle keyframe, z up by gravity, x along the IMU's x axis
/// of that keyframe seen from above.
struct Submap {
  int id = 0;  ///< that of the middle keyframe
  int map_id = 0;
  Time time;  ///< of the middle keyframe
  math::SE3 T_map_submap;
  std::vector<int> keyframe_ids;
  double travel = 0.0;                      ///< from the first keyframe to the last [m]
  std::vector<Eigen::Vector3f> points;      ///< mean of each occupied voxel [m]
  std::vector<std::uint16_t> views;         ///< for each point: index of the first viewpoint that saw it
  std::vector<Eigen::Vector3f> viewpoints;  ///< the IMU at each keyframe [m]
};

/// Submap of consecutive keyframes of one map.
/// @pre keyframes is not empty
[[nodiscard]] Submap build_submap(std::span<const KeyframePointer> keyframes, const SubmapConfig& config);

/// A range [first, last) of keyframes.
struct KeyframeRange {
  std::size_t first = 0;
  std::size_t last = 0;
};

/// Cuts keyframes into ranges of `travel` (or `max_turn_deg`), each half over the one before; the last range
/// may be shorter. A range never crosses from one map to another.
[[nodiscard]] std::vector<KeyframeRange> split_by_travel(std::span<const KeyframePointer> keyframes,
                                                         const SubmapConfig& config);

}  // namespace mmlins::keyframe
