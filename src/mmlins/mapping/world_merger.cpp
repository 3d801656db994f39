// SPDX-License-Identifier: MIT
#include "mmlins/mapping/world_merger.hpp"

#include <fmt/format.h>

#include <Eigen/Cholesky>
#include <algorithm>
#include <iterator>
#include <map>
#include <numeric>
#include <utility>

#include "mmlins/base/log.hpp"

namespace mmlins::mapping {
namespace {

/// Squared distance from what the IMU carried, with its deviations doubled, beyond which maps are not joined.
constexpr double kMaxSurprise = 6.0;
/// 99.9 % of true closures are nearer to what all others say, in six directions.
constexpr double kMaxClosureChi2 = 22.5;
/// Maps are not joined, or not any longer, if closures against it weigh more than this share of those for it.
constexpr double kRivalShare = 0.5;
/// So many closures that fit are outvoted by one that sees through walls.
constexpr int kOutvoted = 3;

bool contains(const std::vector<int>& maps, int map) { return std::find(maps.begin(), maps.end(), map) != maps.end(); }

/// Whether the closure leads from one side of the merge to the other.
bool is_across(const Merge& merge, const Closure& closure) {
  return (contains(merge.moved_maps, closure.source_map) && contains(merge.into_maps, closure.target_map)) ||
         (contains(merge.moved_maps, closure.target_map) && contains(merge.into_maps, closure.source_map));
}

bool stands_for_it(const Closure& closure) {
  return closure.state == ClosureState::kCounts || closure.state == ClosureState::kConfirmed;
}

/// The same for all looks at two places, however far the submaps had grown.
std::pair<int, int> places_of(const Closure& closure) { return std::minmax(closure.source_begin, closure.target_begin); }

double weight_of(const std::vector<Placement>& placements) {
  return std::accumulate(placements.begin(), placements.end(), 0.0,
                         [](double sum, const Placement& placement) { return sum + placement.weight; });
}

}  // namespace

std::vector<Placement> WorldMerger::placements_of(const std::vector<int>& closures,
                                                  const std::function<bool(int map)>& moves) const {
  std::map<std::pair<int, int>, int> num_looks;
  for (const int id : closures) ++num_looks[places_of(worlds_.closure(id))];
  std::vector<Placement> placements;
  for (const int id : closures) {
    const Closure& closure = worlds_.closure(id);
    placements.push_back(worlds_.placement_of(closure, moves(closure.source_map)));
    placements.back().weight /= num_looks[places_of(closure)];
  }
  return placements;
}

std::vector<int> WorldMerger::last_looks(const std::vector<int>& closures) const {
  std::map<std::pair<int, int>, int> last;
  for (const int id : closures) last[places_of(worlds_.closure(id))] = id;
  std::vector<int> ids;
  std::copy_if(closures.begin(), closures.end(), std::back_inserter(ids),
               [&](int id) { return last[places_of(worlds_.closure(id))] == id; });
  return ids;
}

WorldMerger::Case WorldMerger::strongest_case(const std::vector<int>& closures,
                                              const std::vector<Placement>& placements) const {
  Case one;
  std::vector<int> members;
  double first_way = 0.0, last_way = 0.0, most_overlap = 0.0;
  for (const std::size_t i : largest_agreement(placements, config_.merge)) {
    const Closure& closure = worlds_.closure(closures[i]);
    const bool is_first = members.empty();
    first_way = is_first ? placements[i].source_way : std::min(first_way, placements[i].source_way);
    last_way = is_first ? placements[i].source_way : std::max(last_way, placements[i].source_way);
    one.weight += placements[i].weight;
    if (is_first || closure.overlap > most_overlap) {
      one.best = placements[i];
      most_overlap = closure.overlap;
    }
    members.push_back(closures[i]);
    // One place may look like another; two that lie to each other as they should seldom do.
    one.has_two_targets = one.has_two_targets || closure.target != worlds_.closure(members.front()).target;
  }
  one.span = last_way - first_way;
  one.closures = last_looks(members);
  std::set_difference(members.begin(), members.end(), one.closures.begin(), one.closures.end(),
                      std::back_inserter(one.repeated));
  return one;
}

std::optional<Merge> WorldMerger::try_to_merge(int world_a, int world_b) {
  const int into = std::min(world_a, world_b), world = std::max(world_a, world_b);
  std::vector<int> ids;
  for (const Closure& closure : worlds_.closures) {
    if (closure.state == ClosureState::kWaiting && worlds_.is_between(closure, into, world)) ids.push_back(closure.id);
  }
  const auto placements = placements_of(ids, [&](int map) { return worlds_.graph.world_of(map) == world; });
  const Case one = strongest_case(ids, placements);
  if (one.closures.empty() || !is_enough(one, into, world)) return std::nullopt;
  // Others tell another story: wait until one of them is clearly the longer.
  if (weight_of(placements) - one.weight > kRivalShare * one.weight) return std::nullopt;
  Merge merge;
  merge.closures = one.closures;
  merge.world = world;
  merge.into = into;
  merge.prior_known = worlds_.graph.are_connected(into, world);
  merge.T_new_old = one.best.T_into_world;
  const bool fits = commit(merge);
  // The evidence so far is spent; only new closures may try again.
  const ClosureState spent = fits ? ClosureState::kConfirmed : ClosureState::kRejected;
  for (const int id : one.repeated) worlds_.closure(id).state = spent;
  if (fits) return merge;
  log::info("maps {} and {} stay apart: joined, they do not fit", into, world);
  return std::nullopt;
}

bool WorldMerger::is_enough(const Case& one, int into, int world) const {
  const bool prior_known = worlds_.graph.are_connected(into, world);
  // Places that look alike are found where the IMU cannot have carried the pose.
  if (prior_known && !is_as_predicted(worlds_.closure(one.closures.front()))) return false;
  // Who was wrong once must have more to say.
  const int times_undone = num_undone(into, world);
  const int needed = prior_known && times_undone == 0 ? config_.merge.num_agreeing_with_prior
                                                      : config_.merge.num_agreeing * (1 + times_undone);
  const double needed_span = prior_known ? config_.merge.min_span_with_prior : config_.merge.min_span;
  const auto num = static_cast<int>(one.closures.size());
  return num >= needed && one.span >= needed_span && one.has_two_targets &&
         kOutvoted * num_seen_through(into, world, one.best) < num;
}

int WorldMerger::num_undone(int into, int world) const {
  return static_cast<int>(std::count_if(worlds_.merges.begin(), worlds_.merges.end(), [&](const Merge& merge) {
    const int a = worlds_.graph.world_of(merge.world), b = worlds_.graph.world_of(merge.into);
    return merge.undone && std::minmax(a, b) == std::minmax(into, world);
  }));
}

bool WorldMerger::is_as_predicted(const Closure& closure) const {
  const KeyframePair pair{closure.target, closure.source};
  const auto prior = worlds_.graph.predict({&pair, 1}).front();
  if (!prior) return false;
  const math::Vector6d apart = math::se3_log(prior->T_target_source.inverse() * closure.T_target_source);
  return apart.dot(prior->covariance.ldlt().solve(apart)) <= kMaxSurprise;
}

bool WorldMerger::sees_through(const Closure& closure) const {
  return closure.state == ClosureState::kRefused && closure.crossing_share > config_.verification.max_crossing_share;
}

int WorldMerger::num_seen_through(int into, int world, const Placement& like) const {
  std::vector<int> ids;
  for (const Closure& closure : worlds_.closures) {
    if (!sees_through(closure) || !worlds_.is_between(closure, into, world)) continue;
    const bool source_moves = worlds_.graph.world_of(closure.source_map) == world;
    if (agree(worlds_.placement_of(closure, source_moves), like, config_.merge)) ids.push_back(closure.id);
  }
  return static_cast<int>(last_looks(ids).size());
}

bool WorldMerger::commit(Merge& merge) {
  MapGraph& graph = worlds_.graph;
  const MapGraph before = graph;
  for (int map = 0; map < graph.num_maps(); ++map) {
    if (graph.world_of(map) == merge.into) merge.into_maps.push_back(map);
    if (graph.world_of(map) == merge.world) merge.moved_maps.push_back(map);
  }
  merge.T_before = graph.T_world_map(merge.world);
  graph.move_world(merge.world, merge.T_new_old);
  graph.join(merge.world, merge.into);
  for (const int id : merge.closures) graph.add_closure(worlds_.closure(id));
  bool fits = worlds_.solve(before);
  if (fits) {
    const std::vector<double> chi2 = graph.test(merge.closures);
    fits = std::all_of(chi2.begin(), chi2.end(), [](double one) { return one <= kMaxClosureChi2; });
  }
  if (!fits) {
    graph = before;
    worlds_.take_over_verdicts();
    // The evidence so far is spent; only new closures may try again.
    for (const int id : merge.closures) worlds_.closure(id).state = ClosureState::kRejected;
    return false;
  }
  for (const int id : merge.closures) {
    Closure& closure = worlds_.closure(id);
    if (closure.state == ClosureState::kWaiting) closure.state = ClosureState::kCounts;
  }
  merge.id = static_cast<int>(worlds_.merges.size());
  merge.time = worlds_.now;
  merge.num_keyframes = graph.num_keyframes();
  return true;
}

std::vector<int> WorldMerger::merges_between(const Closure& closure) const {
  std::vector<int> ids;
  for (const Merge& merge : worlds_.merges) {
    if (!merge.undone && is_across(merge, closure)) ids.push_back(merge.id);
  }
  return ids;
}

void WorldMerger::review(int merge_id) {
  const Merge& merge = worlds_.merges[static_cast<std::size_t>(merge_id)];
  const auto moves = [&](int map) { return contains(merge.moved_maps, map); };
  std::vector<int> rivals, support, seen_through;
  for (const Closure& closure : worlds_.closures) {
    if (!is_across(merge, closure)) continue;
    if (stands_for_it(closure)) {
      support.push_back(closure.id);
    } else if (closure.contradicts) {
      rivals.push_back(closure.id);
    } else if (sees_through(closure)) {
      const Placement placement = worlds_.placement_of(closure, moves(closure.source_map));
      Placement as_it_lies = placement;
      as_it_lies.T_into_world = {};
      if (agree(placement, as_it_lies, config_.merge)) seen_through.push_back(closure.id);
    }
  }
  const auto num_support = static_cast<int>(last_looks(support).size());
  const auto num_seen_through = static_cast<int>(last_looks(seen_through).size());
  if (num_seen_through >= config_.merge.num_agreeing && kOutvoted * num_seen_through >= num_support) {
    dissolve(merge_id, fmt::format("{} closures see through walls, {} fit", num_seen_through, num_support));
    return;
  }
  const Case other = strongest_case(rivals, placements_of(rivals, moves));
  const auto num_against = static_cast<int>(other.closures.size());
  if (num_against < config_.merge.num_agreeing || !other.has_two_targets || other.span < config_.merge.min_span) return;
  if (other.weight <= kRivalShare * weight_of(placements_of(support, moves))) return;
  const double apart = (other.best.T_into_world * other.best.p_world - other.best.p_world).norm();
  dissolve(merge_id, fmt::format("{} closures agree that they lie {:.2f} m elsewhere, {} stand for it", num_against, apart,
                                 num_support));
}

void WorldMerger::dissolve(int merge_id, const std::string& why) {
  MapGraph& graph = worlds_.graph;
  Merge& merge = worlds_.merges[static_cast<std::size_t>(merge_id)];
  // What was joined since then lies where this merge put it.
  for (std::size_t later = worlds_.merges.size(); later-- > static_cast<std::size_t>(merge_id) + 1;) {
    const Merge& other = worlds_.merges[later];
    const bool rests_on_it = graph.world_of(other.into) == graph.world_of(merge.into);
    if (!other.undone && rests_on_it) dissolve(static_cast<int>(later), fmt::format("merge {} was taken back", merge.number()));
  }
  log::warning("map {} is no longer joined to map {}: {}", merge.world, merge.into, why);
  graph.separate(merge.moved_maps, merge.T_before);
  if (!worlds_.solve(graph)) ++worlds_.revision;
  merge.undone = worlds_.now;
  merge.why_undone = why;
  // All of them are evidence again, for and against.
  for (Closure& closure : worlds_.closures) {
    if (!is_across(merge, closure)) continue;
    if (closure.contradicts || stands_for_it(closure)) closure.state = ClosureState::kWaiting;
    closure.contradicts = false;
  }
}

}  // namespace mmlins::mapping
