// SPDX-License-Identifier: MIT
#pragma once
// Keyframes in runs that are drawn, fetched and left out together.

#include <cstdint>
#include <span>
#include <vector>

#include "mmlins/atlas/rows.hpp"

namespace mmlins::view {

/// Keyframes of one map, whose ids follow one another.
struct Block {
  int map_id = 0;
  int first = 0;  ///< ids of its keyframes
  int last = 0;
  std::int64_t num_points = 0;
};

/// Every keyframe is in one block. Blocks do not change when keyframes follow, but for the last one.
/// @param rows  in the order of their ids
[[nodiscard]] std::vector<Block> make_blocks(std::span<const atlas::KeyframeRow> rows);

}  // namespace mmlins::view
