// SPDX-License-Identifier: MIT
#include "mmlins/mapping/mapper.hpp"

#include <algorithm>
#include <array>
#include <numbers>
#include <utility>

#include "mmlins/base/log.hpp"
#include "mmlins/base/stopwatch.hpp"
#include "mmlins/registration/edge_information.hpp"
#include "mmlins/registration/fit_height.hpp"

namespace mmlins::mapping {
namespace {

using math::Matrix6d;
using math::SE3;

/// A young map looks for known places before its first submap is complete, after so many metres.
constexpr std::array<double, 3> kProbeAfter{3.0, 6.0, 10.0};
/// Height by which the view from above may be wrong [m].
constexpr double kHeightRange = 2.5;
/// 95 % of what is off by chance alone is nearer than this squared distance, in six directions.
constexpr double kChance = 12.6;

/// The same information about keyframes instead of their submaps.
Matrix6d of_keyframes(const Matrix6d& information, const SubmapRecord& source) {
  Matrix6d turn = Matrix6d::Zero();
  turn.topLeftCorner<3, 3>() = source.T_keyframe_submap.R;
  turn.bottomRightCorner<3, 3>() = source.T_keyframe_submap.R;
  return turn * information * turn.transpose();
}

}  // namespace

Mapper::Mapper(const MappingConfig& config, keyframe::KeyframeStore& store)
    : config_(config),
      worlds_(MapGraph(config.link, config.optimizer)),
      merger_(config, worlds_),
      library_(config.submap, config.verification.registration, store),
      finder_(config, worlds_.graph, library_),
      cutter_(config.submap) {}

void Mapper::begin_map(const MapBegin& begin) {
  worlds_.graph.begin_map(begin);
  latest_map_ = begin.map_id;
  num_probes_ = 0;
  map_begins_at_ = worlds_.graph.num_keyframes() > 0 ? worlds_.graph.odometer(worlds_.graph.num_keyframes() - 1) : 0.0;
}

void Mapper::add(const keyframe::KeyframePointer& keyframe, const math::Matrix6d& pose_covariance) {
  worlds_.now = keyframe->time;
  worlds_.graph.add(*keyframe, pose_covariance);
  if (const auto complete = cutter_.add(keyframe)) {
    look_around(*complete, true);
  } else if (probe_is_due()) {
    ++num_probes_;
    look_around(cutter_.pending(), false);
  }
}

void Mapper::bridge(const Matrix6d& covariance) {
  // A submap must not hold what was seen before and after: it may not fit together.
  end_map();
  worlds_.graph.bridge(covariance);
}

void Mapper::end_map() {
  if (const auto rest = cutter_.finish()) look_around(*rest, true);
}

bool Mapper::is_alone(int map) const { return map > 0 && worlds_.graph.world_of(map) == map; }

bool Mapper::probe_is_due() const {
  if (!is_alone(latest_map_) || num_probes_ >= kProbeAfter.size()) return false;
  return worlds_.graph.odometer(worlds_.graph.num_keyframes() - 1) - map_begins_at_ >= kProbeAfter[num_probes_];
}

void Mapper::look_around(const keyframe::Keyframes& keyframes, bool is_complete) {
  if (!config_.enabled) return;
  Stopwatch stopwatch;
  View view;
  view.loaded = library_.build(keyframes);
  view.record = SubmapLibrary::record_of(view.loaded->submap, keyframes);
  times_.submaps += stopwatch.lap_ms();
  place::PlaceDescriptor descriptor = finder_.describe(view.loaded->submap);
  find_known_places(view, descriptor);
  const bool is_new = library_.records().empty() || library_.records().back().id < view.record.id;
  if (!is_complete || !is_new) return;
  view.record.footprint = descriptor.footprint;
  library_.add(view.record, view.loaded);
  finder_.add(view.record, std::move(descriptor));
}

void Mapper::find_known_places(const View& view, const place::PlaceDescriptor& descriptor) {
  const bool may_join = config_.fusion != FusionKind::kOff;
  bool other_worlds = false;
  for (const SubmapRecord& record : library_.records()) {
    other_worlds = other_worlds || (may_join && worlds_.graph.world_of(record.map_id) != worlds_.graph.world_of(view.record.map_id));
  }
  const bool is_quiet = worlds_.graph.odometer(view.record.id) < quiet_until_;
  if (is_quiet && !other_worlds) return;
  std::vector<std::size_t> examined;
  const auto consider = [&](const std::vector<PlaceCandidate>& candidates) {
    for (const PlaceCandidate& candidate : candidates) {
      if (std::find(examined.begin(), examined.end(), candidate.index) != examined.end()) continue;
      const int target_world = worlds_.graph.world_of(library_.records()[candidate.index].map_id);
      const int world = worlds_.graph.world_of(view.record.map_id);
      if (target_world == world ? is_quiet : !may_join) continue;
      examined.push_back(candidate.index);
      Stopwatch stopwatch;
      Closure* closure = examine(view, candidate);
      if (target_world != world) times_.fusion += stopwatch.lap_ms();
      if (!closure) continue;
      if (closure->state == ClosureState::kRefused) {
        for (const int merge : merger_.merges_between(*closure)) merger_.review(merge);
      }
      if (closure->state != ClosureState::kWaiting) continue;
      // A merge that was taken back just now leaves two worlds where there was one.
      const int source = worlds_.graph.world_of(closure->source_map), target = worlds_.graph.world_of(closure->target_map);
      if (source == target) {
        use(*closure);
        return true;
      }
      if (auto merge = merger_.try_to_merge(source, target)) file(std::move(*merge));
      times_.fusion += stopwatch.lap_ms();
    }
    return false;
  };
  if (consider(finder_.predicted(view.record, view.loaded->submap)) && !other_worlds) return;
  consider(finder_.recognised(view.record, descriptor));
}

Closure* Mapper::examine(const View& view, const PlaceCandidate& candidate) {
  const SubmapRecord& target = library_.records()[candidate.index];
  const auto loaded = library_.load(candidate.index);
  if (!loaded) {
    log::warning("{}", loaded.error().message);
    return nullptr;
  }
  Stopwatch stopwatch;
  std::vector<SE3> starts = candidate.starts;
  if (candidate.origin == ClosureOrigin::kRecognised) {
    for (SE3& start : starts) start = registration::fit_height(view.loaded->submap, (*loaded)->submap, start, kHeightRange);
  }
  registration::Verification verdict = registration::verify(view.loaded->prepared, (*loaded)->prepared, starts,
                                                            candidate.prior, config_.verification);
  Closure closure;
  closure.id = static_cast<int>(worlds_.closures.size());
  closure.source = view.record.id;
  closure.target = target.id;
  closure.source_map = view.record.map_id;
  closure.target_map = target.map_id;
  closure.source_begin = view.record.first_keyframe;
  closure.target_begin = target.first_keyframe;
  closure.time = worlds_.now;
  closure.origin = candidate.origin;
  closure.state = verdict.accepted ? ClosureState::kWaiting : ClosureState::kRefused;
  closure.score = candidate.score;
  const registration::Registration& fit = verdict.registration;
  closure.T_target_source =
      target.T_keyframe_submap * fit.T_target_source * view.record.T_keyframe_submap.inverse();
  closure.information = of_keyframes(fit.information, view.record);
  closure.overlap = fit.overlap;
  closure.residual_rms = fit.residual_rms;
  closure.crossing_share = verdict.crossing_share;
  closure.reason = verdict.reason;
  closure.moved = -1.0;
  if (candidate.prior && fit.status != registration::RegistrationStatus::kHopeless) {
    const math::Vector6d apart = math::se3_log(candidate.prior->T_target_source.inverse() * fit.T_target_source);
    const registration::RegistrationConfig& limits = config_.verification.registration;
    const Matrix6d known = covariance_of(limits.observability.weak_rotation_deg, limits.observability.weak_position);
    const math::Vector6d shift = known * (registration::compared_information(fit.information, known) * apart);
    closure.moved = shift.tail<3>().norm();
    closure.turned = shift.head<3>().norm();
    const Matrix6d least = covariance_of(config_.loop.confirmed_within_deg, config_.loop.confirmed_within);
    closure.news = apart.dot(registration::compared_information(fit.information / kChance, least) * apart);
  }
  if (verdict.refused_by_prior && !merger_.merges_between(closure).empty()) {
    // Where it should be follows from a merge, which may be the one that is wrong.
    closure.contradicts = registration::verify(view.loaded->prepared, (*loaded)->prepared, {&fit.T_target_source, 1},
                                               std::nullopt, config_.verification).accepted;
  }
  times_.verify += stopwatch.lap_ms();
  worlds_.closures.push_back(std::move(closure));
  return &worlds_.closures.back();
}

bool Mapper::needs_ties(int map_a, int map_b) const {
  if (map_a == map_b) return false;
  const auto ties = std::count_if(worlds_.closures.begin(), worlds_.closures.end(), [&](const Closure& closure) {
    return closure.state == ClosureState::kCounts &&
           std::minmax(closure.source_map, closure.target_map) == std::minmax(map_a, map_b);
  });
  return ties < config_.merge.num_enhancing;
}

void Mapper::use(Closure& closure) {
  const bool ties_maps = needs_ties(closure.source_map, closure.target_map);
  const bool is_bridged = worlds_.graph.is_bridged(closure.source, closure.target);
  const bool is_known = closure.moved >= 0.0 && closure.news <= 1.0;
  if (!ties_maps && (is_known || !is_bridged)) quiet_until_ = worlds_.graph.odometer(closure.source) + config_.loop.pause;
  if (!ties_maps && is_known) {
    closure.state = ClosureState::kConfirmed;
    // What the IMU alone carried is known no better by the odometry: another closure must not move it unasked.
    if (is_bridged) worlds_.graph.hold(closure, covariance_of(config_.loop.confirmed_within_deg, config_.loop.confirmed_within));
    return;
  }
  // The map may have been found again in the wrong place; but one closure that says so may be wrong as well.
  Closure* fellow = is_bridged ? fellow_of(closure) : nullptr;
  if (is_bridged && !ties_maps && !fellow) return;
  MapGraph before = worlds_.graph;
  for (Closure* one : {&closure, fellow}) {
    if (!one) continue;
    one->state = ClosureState::kCounts;
    worlds_.graph.add_closure(*one);
  }
  if (worlds_.solve(std::move(before))) return;
  closure.state = ClosureState::kRejected;
  if (fellow) fellow->state = ClosureState::kRejected;
}

Closure* Mapper::fellow_of(const Closure& closure) {
  const int world = worlds_.graph.world_of(closure.source_map);
  const Placement placement = worlds_.placement_of(closure, true);
  const auto found = std::find_if(worlds_.closures.begin(), worlds_.closures.end(), [&](const Closure& other) {
    return other.state == ClosureState::kWaiting && other.id != closure.id && other.target != closure.target &&
           other.source != closure.source && worlds_.graph.world_of(other.source_map) == world &&
           worlds_.graph.world_of(other.target_map) == world && !worlds_.graph.is_bridged(other.source, closure.source) &&
           agree(worlds_.placement_of(other, true), placement, config_.merge);
  });
  return found == worlds_.closures.end() ? nullptr : &*found;
}

void Mapper::file(Merge merge) {
  enhance(merge);
  log::info("map {} is joined to map {} by {} closures", merge.world, merge.into, merge.closures.size() + merge.enhancing.size());
  worlds_.merges.push_back(std::move(merge));
}

void Mapper::enhance(Merge& merge) {
  const auto was_in = [&](int map) {
    return std::find(merge.into_maps.begin(), merge.into_maps.end(), map) != merge.into_maps.end();
  };
  const MapGraph before = worlds_.graph;
  bool added = false;
  for (std::size_t index = 0; index < library_.records().size(); ++index) {
    const SubmapRecord record = library_.records()[index];
    const bool is_source = std::any_of(merge.closures.begin(), merge.closures.end(), [&](int id) {
      return worlds_.closure(id).source == record.id;
    });
    if (is_source || was_in(record.map_id) || worlds_.graph.world_of(record.map_id) != merge.into) continue;
    if (static_cast<int>(merge.enhancing.size()) >= config_.merge.num_enhancing) break;
    const auto loaded = library_.load(index);
    if (!loaded) continue;
    for (const PlaceCandidate& candidate : finder_.predicted(record, (*loaded)->submap)) {
      if (!was_in(library_.records()[candidate.index].map_id)) continue;
      Closure* closure = examine({record, *loaded}, candidate);
      if (!closure || closure->state != ClosureState::kWaiting) continue;
      closure->state = ClosureState::kCounts;
      worlds_.graph.add_closure(*closure);
      merge.enhancing.push_back(closure->id);
      added = true;
      break;
    }
  }
  if (added && !worlds_.solve(before)) {
    for (const int id : merge.enhancing) worlds_.closure(id).state = ClosureState::kRejected;
    merge.enhancing.clear();
  }
}

MapperTimes Mapper::times() const {
  MapperTimes times = times_;
  times.optimize = worlds_.optimize_ms;
  times.describe = finder_.times().describe_ms;
  times.recognise = finder_.times().query_ms;
  times.search = finder_.times().search_ms;
  return times;
}

}  // namespace mmlins::mapping
