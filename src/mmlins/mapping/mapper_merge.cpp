// SPDX-License-Identifier: MIT
// How closures change the graph: loops within a world, and two worlds that become one.
#include <Eigen/Cholesky>
#include <algorithm>
#include <utility>

#include "mmlins/base/log.hpp"
#include "mmlins/base/stopwatch.hpp"
#include "mmlins/mapping/mapper.hpp"

namespace mmlins::mapping {
namespace {

using math::SE3;

/// Odometry that has to bend more than this (mean squared normalised error) is bent by something false.
constexpr double kMaxOdometryChi2 = 1.5;
/// Squared distance from what the IMU carried, with its deviations doubled, beyond which maps are not joined.
constexpr double kMaxSurprise = 6.0;
/// 99.9 % of true closures are nearer to what all others say, in six directions.
constexpr double kMaxClosureChi2 = 22.5;

bool contains(const std::vector<int>& values, int value) { return std::find(values.begin(), values.end(), value) != values.end(); }

}  // namespace

bool Mapper::needs_ties(int map_a, int map_b) const {
  if (map_a == map_b) return false;
  const auto ties = std::count_if(closures_.begin(), closures_.end(), [&](const Closure& closure) {
    return closure.state == ClosureState::kCounts &&
           std::minmax(closure.source_map, closure.target_map) == std::minmax(map_a, map_b);
  });
  return ties < config_.merge.num_enhancing;
}

void Mapper::use(Closure& closure) {
  const bool ties_maps = needs_ties(closure.source_map, closure.target_map);
  const bool is_bridged = graph_.is_bridged(closure.source, closure.target);
  const bool is_known = closure.moved >= 0.0 && closure.news <= 1.0;
  if (!ties_maps && (is_known || !is_bridged)) quiet_until_ = graph_.odometer(closure.source) + config_.loop.pause;
  if (!ties_maps && is_known) {
    closure.state = ClosureState::kConfirmed;
    // What the IMU alone carried is known no better by the odometry: another closure must not move it unasked.
    if (is_bridged) graph_.hold(closure, covariance_of(config_.loop.confirmed_within_deg, config_.loop.confirmed_within));
    return;
  }
  // The map may have been found again in the wrong place; but one closure that says so may be wrong as well.
  Closure* fellow = is_bridged ? fellow_of(closure) : nullptr;
  if (is_bridged && !ties_maps && !fellow) return;
  MapGraph before = graph_;
  for (Closure* one : {&closure, fellow}) {
    if (!one) continue;
    one->state = ClosureState::kCounts;
    graph_.add_closure(*one);
  }
  if (solve(std::move(before))) return;
  closure.state = ClosureState::kRejected;
  if (fellow) fellow->state = ClosureState::kRejected;
}

Closure* Mapper::fellow_of(const Closure& closure) {
  const int world = graph_.world_of(closure.source_map);
  const Placement placement = placement_of(closure, world);
  const auto found = std::find_if(closures_.begin(), closures_.end(), [&](const Closure& other) {
    return other.state == ClosureState::kWaiting && other.id != closure.id && other.target != closure.target &&
           other.source != closure.source && graph_.world_of(other.source_map) == world &&
           graph_.world_of(other.target_map) == world && !graph_.is_bridged(other.source, closure.source) &&
           agree(placement_of(other, world), placement, config_.merge);
  });
  return found == closures_.end() ? nullptr : &*found;
}

bool Mapper::solve(MapGraph before) {
  Stopwatch stopwatch;
  const MapGraph::Solution solution = graph_.optimize();
  times_.optimize += stopwatch.lap_ms();
  if (!solution.solved || solution.odometry_chi2_per_dof > kMaxOdometryChi2) {
    graph_ = std::move(before);
    return false;
  }
  for (const int id : solution.rejected) closures_[static_cast<std::size_t>(id)].state = ClosureState::kRejected;
  ++revision_;
  return true;
}

Placement Mapper::placement_of(const Closure& closure, bool source_moves) const {
  const SE3 T_world_source = graph_.T_world_keyframe(closure.source);
  const SE3 T_world_target = graph_.T_world_keyframe(closure.target);
  Placement placement;
  placement.T_into_world = source_moves ? T_world_target * closure.T_target_source * T_world_source.inverse()
                                        : T_world_source * closure.T_target_source.inverse() * T_world_target.inverse();
  placement.p_world = source_moves ? T_world_source.t : T_world_target.t;
  placement.source_way = graph_.odometer(closure.source);
  placement.target_way = graph_.odometer(closure.target);
  placement.weight = closure.overlap;
  return placement;
}

void Mapper::try_to_merge(int world_a, int world_b) {
  const int into = std::min(world_a, world_b), world = std::max(world_a, world_b);
  std::vector<Placement> placements;
  std::vector<int> ids;
  for (const Closure& closure : closures_) {
    if (closure.state != ClosureState::kWaiting) continue;
    const int source = graph_.world_of(closure.source_map), target = graph_.world_of(closure.target_map);
    if (std::minmax(source, target) != std::minmax(into, world)) continue;
    placements.push_back(placement_of(closure, world));
    ids.push_back(closure.id);
  }
  const std::vector<std::size_t> agreeing = largest_agreement(placements, config_.merge);
  if (agreeing.empty()) return;
  const bool prior_known = graph_.are_connected(into, world);
  // Places that look alike are found where the IMU cannot have carried the pose.
  if (prior_known && !is_as_predicted(closures_[static_cast<std::size_t>(ids[agreeing.front()])])) return;
  const auto num_undone = static_cast<int>(std::count_if(merges_.begin(), merges_.end(), [&](const Merge& merge) {
    return merge.undone && std::minmax(graph_.world_of(merge.world), graph_.world_of(merge.into)) == std::minmax(into, world);
  }));
  // Who was wrong once must have more to say.
  const int needed = prior_known && num_undone == 0 ? config_.merge.num_agreeing_with_prior
                                                    : config_.merge.num_agreeing * (1 + num_undone);
  const double needed_span = prior_known ? config_.merge.min_span_with_prior : config_.merge.min_span;
  if (static_cast<int>(agreeing.size()) < needed) return;
  double first_way = placements[agreeing.front()].source_way, last_way = first_way, weight = 0.0, total = 0.0;
  for (const Placement& placement : placements) total += placement.weight;
  Merge merge;
  std::size_t best = agreeing.front();
  for (const std::size_t i : agreeing) {
    first_way = std::min(first_way, placements[i].source_way);
    last_way = std::max(last_way, placements[i].source_way);
    weight += placements[i].weight;
    if (placements[i].weight > placements[best].weight) best = i;
    merge.closures.push_back(ids[i]);
  }
  // One place may look like another; two that lie to each other as they should seldom do.
  const auto leads_elsewhere = [&](int id) {
    return closures_[static_cast<std::size_t>(id)].target != closures_[static_cast<std::size_t>(merge.closures.front())].target;
  };
  if (std::none_of(merge.closures.begin(), merge.closures.end(), leads_elsewhere)) return;
  // Others tell another story: wait until one of them is clearly the longer.
  if (last_way - first_way < needed_span || total - weight > kRivalShare * weight) return;
  if (3 * num_seen_through(into, world, placements[best]) >= static_cast<int>(agreeing.size())) return;
  merge.world = world;
  merge.into = into;
  merge.prior_known = prior_known;
  merge.T_new_old = placements[best].T_into_world;
  if (!commit(std::move(merge))) log::info("maps {} and {} stay apart: joined, they do not fit", into, world);
}

bool Mapper::is_as_predicted(const Closure& closure) const {
  const KeyframePair pair{closure.target, closure.source};
  const auto prior = graph_.predict({&pair, 1}).front();
  if (!prior) return false;
  const math::Vector6d apart = math::se3_log(prior->T_target_source.inverse() * closure.T_target_source);
  return apart.dot(prior->covariance.ldlt().solve(apart)) <= kMaxSurprise;
}

int Mapper::num_seen_through(int into, int world, const Placement& like) const {
  return static_cast<int>(std::count_if(closures_.begin(), closures_.end(), [&](const Closure& closure) {
    if (closure.state != ClosureState::kRefused) return false;
    if (closure.crossing_share <= config_.verification.max_crossing_share) return false;
    const int source = graph_.world_of(closure.source_map), target = graph_.world_of(closure.target_map);
    return std::minmax(source, target) == std::minmax(into, world) && agree(placement_of(closure, world), like, config_.merge);
  }));
}

bool Mapper::commit(Merge merge) {
  MapGraph before = graph_;
  for (int map = 0; map <= latest_map_; ++map) {
    if (graph_.world_of(map) == merge.into) merge.into_maps.push_back(map);
    if (graph_.world_of(map) == merge.world) merge.moved_maps.push_back(map);
  }
  graph_.move_world(merge.world, merge.T_new_old);
  graph_.join(merge.world, merge.into);
  for (const int id : merge.closures) graph_.add_closure(closures_[static_cast<std::size_t>(id)]);
  const MapGraph untouched = before;
  bool fits = solve(std::move(before));
  if (fits) {
    const std::vector<double> chi2 = graph_.test(merge.closures);
    fits = std::all_of(chi2.begin(), chi2.end(), [](double one) { return one <= kMaxClosureChi2; });
  }
  if (!fits) {
    graph_ = untouched;
    // The evidence so far is spent; only new closures may try again.
    for (const int id : merge.closures) closures_[static_cast<std::size_t>(id)].state = ClosureState::kRejected;
    return false;
  }
  for (const int id : merge.closures) {
    Closure& closure = closures_[static_cast<std::size_t>(id)];
    if (closure.state == ClosureState::kWaiting) closure.state = ClosureState::kCounts;
  }
  merge.id = static_cast<int>(merges_.size());
  merge.time = now_;
  merge.num_keyframes = graph_.num_keyframes();
  enhance(merge);
  log::info("map {} is joined to map {} by {} closures", merge.world, merge.into, merge.closures.size() + merge.enhancing.size());
  merges_.push_back(std::move(merge));
  return true;
}

void Mapper::enhance(Merge& merge) {
  const auto was_in = [&](int map) { return contains(merge.into_maps, map); };
  const MapGraph before = graph_;
  bool added = false;
  for (std::size_t index = 0; index < library_.records().size(); ++index) {
    const SubmapRecord record = library_.records()[index];
    const bool is_source = std::any_of(merge.closures.begin(), merge.closures.end(), [&](int id) {
      return closures_[static_cast<std::size_t>(id)].source == record.id;
    });
    if (is_source || was_in(record.map_id) || graph_.world_of(record.map_id) != merge.into) continue;
    if (static_cast<int>(merge.enhancing.size()) >= config_.merge.num_enhancing) break;
    const auto loaded = library_.load(index);
    if (!loaded) continue;
    for (const PlaceCandidate& candidate : finder_.predicted(record, (*loaded)->submap)) {
      if (!was_in(library_.records()[candidate.index].map_id)) continue;
      Closure* closure = examine({record, *loaded}, candidate);
      if (!closure || closure->state != ClosureState::kWaiting) continue;
      closure->state = ClosureState::kCounts;
      graph_.add_closure(*closure);
      merge.enhancing.push_back(closure->id);
      added = true;
      break;
    }
  }
  if (added && !solve(before)) {
    for (const int id : merge.enhancing) closures_[static_cast<std::size_t>(id)].state = ClosureState::kRejected;
    merge.enhancing.clear();
  }
}

}  // namespace mmlins::mapping
