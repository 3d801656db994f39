// SPDX-License-Identifier: MIT
// Whether a merge still stands: what is seen later may speak against it.
#include <algorithm>

#include <fmt/format.h>

#include "mmlins/base/log.hpp"
#include "mmlins/mapping/mapper.hpp"

namespace mmlins::mapping {
namespace {

bool contains(const std::vector<int>& maps, int map) { return std::find(maps.begin(), maps.end(), map) != maps.end(); }

/// Whether the closure leads from one side of the merge to the other.
bool is_across(const Merge& merge, const Closure& closure) {
  return (contains(merge.moved_maps, closure.source_map) && contains(merge.into_maps, closure.target_map)) ||
         (contains(merge.moved_maps, closure.target_map) && contains(merge.into_maps, closure.source_map));
}

}  // namespace

std::vector<int> Mapper::merges_between(const Closure& closure) const {
  std::vector<int> ids;
  for (const Merge& merge : merges_) {
    if (!merge.undone && is_across(merge, closure)) ids.push_back(merge.id);
  }
  return ids;
}

void Mapper::review(int merge_id) {
  const Merge& merge = merges_[static_cast<std::size_t>(merge_id)];
  std::vector<Placement> rivals;
  std::vector<int> rival_targets;
  double support = 0.0;
  int num_support = 0, num_seen_through = 0;
  for (const Closure& closure : closures_) {
    if (!is_across(merge, closure)) continue;
    const Placement placement = placement_of(closure, contains(merge.moved_maps, closure.source_map));
    if (closure.state == ClosureState::kCounts || closure.state == ClosureState::kConfirmed) {
      support += closure.overlap;
      ++num_support;
    } else if (closure.contradicts) {
      rivals.push_back(placement);
      rival_targets.push_back(closure.target);
    } else if (closure.state == ClosureState::kRefused && closure.crossing_share > config_.verification.max_crossing_share) {
      Placement as_it_lies = placement;
      as_it_lies.T_into_world = {};
      num_seen_through += agree(placement, as_it_lies, config_.merge) ? 1 : 0;
    }
  }
  if (num_seen_through >= config_.merge.num_agreeing && 3 * num_seen_through >= num_support) {
    dissolve(merge_id, fmt::format("{} closures see through walls, {} fit", num_seen_through, num_support));
    return;
  }
  const std::vector<std::size_t> agreeing = largest_agreement(rivals, config_.merge);
  if (static_cast<int>(agreeing.size()) < config_.merge.num_agreeing) return;
  double against = 0.0, first_way = rivals[agreeing.front()].source_way, last_way = first_way;
  bool two_places = false;
  for (const std::size_t i : agreeing) {
    against += rivals[i].weight;
    first_way = std::min(first_way, rivals[i].source_way);
    last_way = std::max(last_way, rivals[i].source_way);
    two_places = two_places || rival_targets[i] != rival_targets[agreeing.front()];
  }
  if (!two_places || last_way - first_way < config_.merge.min_span || against <= kRivalShare * support) return;
  const double apart = (rivals[agreeing.front()].T_into_world * rivals[agreeing.front()].p_world - rivals[agreeing.front()].p_world).norm();
  dissolve(merge_id, fmt::format("{} closures agree that they lie {:.2f} m elsewhere, {} stand for it", agreeing.size(), apart,
                                 num_support));
}

void Mapper::dissolve(int merge_id, const std::string& why) {
  // What was joined since then lies where this merge put it.
  for (std::size_t later = merges_.size(); later-- > static_cast<std::size_t>(merge_id) + 1;) {
    const Merge& other = merges_[later];
    const bool rests_on_it = graph_.world_of(other.into) == graph_.world_of(merges_[static_cast<std::size_t>(merge_id)].into);
    if (!other.undone && rests_on_it) dissolve(static_cast<int>(later), fmt::format("merge {} was taken back", merge_id));
  }
  Merge& merge = merges_[static_cast<std::size_t>(merge_id)];
  log::warning("map {} is no longer joined to map {}: {}", merge.world, merge.into, why);
  graph_.separate(merge.moved_maps, merge.T_new_old);
  (void)graph_.optimize();
  ++revision_;
  merge.undone = now_;
  merge.why_undone = why;
  // All of them are evidence again, for and against.
  for (Closure& closure : closures_) {
    if (!is_across(merge, closure)) continue;
    if (closure.contradicts || closure.state == ClosureState::kCounts || closure.state == ClosureState::kConfirmed) {
      closure.state = ClosureState::kWaiting;
    }
    closure.contradicts = false;
  }
}

}  // namespace mmlins::mapping
