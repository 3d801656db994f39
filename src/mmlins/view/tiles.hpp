// SPDX-License-Identifier: MIT
#pragma once
// The points of a block in levels of detail: the first level has one point per large cell, each further one
// adds what smaller cells need, the last one all that is left. Every point is in exactly one level, as it was
// stored: in the frame of its keyframe, so that nothing is sent again when a map moves. docs/formats.md,
// "What `mmlins view` serves".

#include <array>
#include <cstdint>
#include <span>
#include <string>
#include <vector>

#include "mmlins/keyframe/keyframe.hpp"

namespace mmlins::view {

/// Edge of the cells of each level [m]; the last level has no cells.
inline constexpr std::array kLevelCells{1.0, 0.5, 0.25, 0.125, 0.0};
inline constexpr int kNumLevels = static_cast<int>(kLevelCells.size());

struct TilePoint {
  std::array<std::int16_t, 3> p_imu{};  ///< in multiples of keyframe::kPointQuantum
  std::uint16_t keyframe = 0;           ///< id of its keyframe, less the first id of the block
  std::uint16_t intensity = 0;
};

struct BlockTiles {
  std::array<std::vector<TilePoint>, kNumLevels>
      levels;  ///< in an order by which any beginning is an even sample
  math::Vector3d p_imu_centre =
      math::Vector3d::Zero();  ///< mean of its points, in the frame of the middle keyframe [m]
  double radius = 0.0;         ///< four of five points are as near to the centre [m]
};

/// @param keyframes  of one map; cells are aligned with that map, in which the keyframes lie as the odometry
/// had them
/// @param first_id   from which the points number their keyframes; those at 65536 and beyond are left out
[[nodiscard]] BlockTiles make_tiles(std::span<const keyframe::KeyframePointer> keyframes, int first_id);

/// One level of a block as it is sent.
[[nodiscard]] std::string encode_tile(const BlockTiles& tiles, int level);

}  // namespace mmlins::view
