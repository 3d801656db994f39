// SPDX-License-Identifier: MIT
#pragma once
// Takes a merge back: the maps lie in two worlds again, as they would without the closures that tied them.

#include <vector>

#include "mmlins/atlas/atlas.hpp"

namespace mmlins::atlas {

/// What lies apart now, maps in the order of their ids.
struct Unmerged {
  std::vector<int> stayed;
  std::vector<int> moved;   ///< out of the world of the others
  std::size_t num_edges = 0;  ///< that tied them and count no longer
};

/// @return an error if there is no such merge, or it was undone already
[[nodiscard]] Result<MergeRow> find_standing_merge(const Atlas& atlas, int merge_id);

/// One transaction. Closures between the two sides lose their weight, and each side is optimised with what is left:
/// where no closure is left, its keyframes lie as the odometry had them. The side that was moved lies where the gap
/// before it says, or where it lay before the merge; what follows it by gaps goes along. The record stays, as undone.
/// @return an error if there is no such merge, it was undone already, a later one rests on it, or a map that is needed
///   is damaged
[[nodiscard]] Result<Unmerged> unmerge(Atlas& atlas, int merge_id);

}  // namespace mmlins::atlas
