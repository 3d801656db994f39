// SPDX-License-Identifier: MIT
#include "mmlins/view/blocks.hpp"

namespace mmlins::view {
namespace {

/// So many are fetched and drawn in one go.
constexpr std::int64_t kMaxPoints = 120'000;
/// Blocks are kept short, so that most of them can be left out of a picture [m].
constexpr double kMaxLength = 25.0;
constexpr std::int64_t kMinPoints = 30'000;

}  // namespace

std::vector<Block> make_blocks(std::span<const atlas::KeyframeRow> rows) {
  std::vector<Block> blocks;
  math::Vector3d p_map_first = math::Vector3d::Zero();
  for (const atlas::KeyframeRow& row : rows) {
    const math::Vector3d& p_map = row.T_map_imu.t;
    const bool fits = !blocks.empty() && blocks.back().map_id == row.map_id &&
                      blocks.back().last + 1 == row.id &&
                      blocks.back().num_points + row.num_points <= kMaxPoints &&
                      ((p_map - p_map_first).norm() <= kMaxLength || blocks.back().num_points < kMinPoints);
    if (!fits) {
      blocks.push_back({row.map_id, row.id, row.id, 0});
      p_map_first = p_map;
    }
    blocks.back().last = row.id;
    blocks.back().num_points += row.num_points;
  }
  return blocks;
}

}  // namespace mmlins::view
