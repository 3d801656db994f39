// SPDX-License-Identifier: MIT
#include "mmlins/mapping/paper_mapper.hpp"

#include <algorithm>
#include <cmath>
#include <numbers>
#include <utility>

#include "mmlins/base/log.hpp"
#include "mmlins/base/stopwatch.hpp"

namespace mmlins::mapping {
namespace {

using math::Matrix6d;
using math::SE3;

/// Points farther from a keyframe than this are no part of its surroundings [m].
constexpr double kRadius = 100.0;

/// Constant noise on every link, and neither gravity nor gaps: the paper has none of them.
LinkConfig links_of(const PaperFusionConfig& config) {
  LinkConfig link;
  link.position = std::sqrt(config.odometry_position_variance);
  link.position_per_m = 0.0;
  link.rotation_deg = std::sqrt(config.odometry_rotation_variance) * 180.0 / std::numbers::pi;
  link.rotation_deg_per_m = 0.0;
  link.gravity_every = 0;
  return link;
}

/// Plain least squares, paper's Eqs. (5) and (6), from where the maps lie.
graph::OptimizerConfig plain(graph::OptimizerConfig config) {
  config.robust = false;
  config.place_maps = false;
  return config;
}

/// The same place, turned as the Scan Contexts say.
SE3 start_of(const SimilarPair& pair) {
  return {math::so3_exp({0.0, 0.0, pair.yaw}), math::Vector3d::Zero()};
}

PaperFusionConfig config_of(const MappingConfig& config) {
  PaperFusionConfig paper = config.paper;
  if (config.fusion == FusionKind::kSingle) paper.num_constraints = 1;
  return paper;
}

}  // namespace

PaperMapper::PaperMapper(const MappingConfig& config, keyframe::KeyframeStore& store)
    : config_(config_of(config)),
      graph_(links_of(config.paper), plain(config.optimizer)),
      contexts_(config.paper.context),
      store_(store) {}

void PaperMapper::begin_map(const MapBegin& begin) {
  graph_.begin_map({begin.map_id, begin.T_world_map, std::nullopt});
  latest_map_ = begin.map_id;
  runs_.clear();
}

void PaperMapper::add(const keyframe::KeyframePointer& keyframe, const Matrix6d&) {
  now_ = keyframe->time;
  graph_.add(*keyframe, Matrix6d::Zero());
  Stopwatch stopwatch;
  place::ScanContext context = contexts_.describe(keyframe->points_imu);
  times_.describe += stopwatch.lap_ms();
  detect_loop(keyframe->id, context);
  detect_similarity(keyframe->id, context);
  contexts_.add(keyframe->id, std::move(context));
}

// The paper has no such place: its links all have one covariance.
void PaperMapper::bridge(const Matrix6d&) {}

void PaperMapper::end_map() { runs_.clear(); }

// "Loop closure detection occurs in the active map": all maps that have become one with it.
void PaperMapper::detect_loop(int keyframe, const place::ScanContext& context) {
  if (!config_.optimize || keyframe < quiet_until_) return;
  const auto may_be_loop = [&](int other) {
    const int map = graph_.map_of(other);
    if (map == latest_map_) return keyframe - other >= config_.exclude_recent;
    return graph_.world_of(map) == graph_.world_of(latest_map_);
  };
  Stopwatch stopwatch;
  const auto hit = contexts_.find(context, config_.max_distance, may_be_loop);
  times_.recognise += stopwatch.lap_ms();
  if (!hit) return;
  quiet_until_ = keyframe + config_.loop_every;
  const SimilarPair pair{keyframe, hit->keyframe, hit->distance, hit->yaw};
  const auto closure = examine(pair, start_of(pair), config_.loop);
  if (!closure || closures_[*closure].state == ClosureState::kRefused) return;
  use(*closure);
  optimize();
}

// "Similarity detection takes place in the sequence of sleeping maps", with the temporal consistency of Eq.
// (3).
void PaperMapper::detect_similarity(int keyframe, const place::ScanContext& context) {
  Stopwatch stopwatch;
  const int num_needed = std::max(config_.consecutive_hits + 1, config_.num_constraints);
  int best_map = -1;
  HitRun best_pairs;
  for (int map = 0; map < latest_map_; ++map) {
    if (graph_.world_of(map) == graph_.world_of(latest_map_)) continue;
    const auto hit =
        contexts_.find(context, config_.max_distance, [&](int other) { return graph_.map_of(other) == map; });
    std::optional<SimilarPair> pair;
    if (hit) pair = SimilarPair{keyframe, hit->keyframe, hit->distance, hit->yaw};
    HitRun& run = runs_[map] = extend(std::move(runs_[map]), pair);
    if (!is_consistent(run, num_needed - 1)) continue;
    HitRun pairs = latest_pairs(run, num_needed);
    if (best_map >= 0 && best_pairs.front().distance <= pairs.front().distance) continue;
    best_map = map;
    best_pairs = std::move(pairs);
  }
  const double search_ms = stopwatch.lap_ms();
  times_.recognise += search_ms;
  times_.fusion += search_ms;
  if (best_map < 0) return;
  best_pairs.resize(static_cast<std::size_t>(config_.num_constraints));
  if (fuse(best_map, best_pairs)) quiet_until_ = keyframe + config_.loop_every;
  times_.fusion += stopwatch.lap_ms();
  // Whether it worked or not, what was counted has been used.
  runs_.clear();
}

bool PaperMapper::fuse(int sleeping_map, const HitRun& pairs) {
  // Initial transform T_a^s, from the clouds C_a and C_s of the most similar pair.
  const auto first = examine(pairs.front(), start_of(pairs.front()), config_.initial);
  if (!first || closures_[*first].state == ClosureState::kRefused) return false;
  const Closure& closure = closures_[*first];
  const SE3 T_sleeping_active = graph_.T_world_keyframe(closure.target) * closure.T_target_source *
                                graph_.T_world_keyframe(closure.source).inverse();

  // "Apply T_a^s to all keyframe poses and point clouds": points hang on their keyframes. The frame of the
  // earlier map is kept, whichever of them is active: the other way round the same picture is only seen from
  // elsewhere.
  const int active = graph_.world_of(latest_map_), sleeping = graph_.world_of(sleeping_map);
  Merge merge;
  merge.id = static_cast<int>(merges_.size());
  merge.time = now_;
  merge.world = std::max(active, sleeping);
  merge.into = std::min(active, sleeping);
  merge.T_new_old = merge.world == active ? T_sleeping_active : T_sleeping_active.inverse();
  merge.num_keyframes = graph_.num_keyframes();
  merge.T_before = graph_.T_world_map(merge.world);
  graph_.move_world(merge.world, merge.T_new_old);
  // "Completely discard the priori constraint" of M_a: as one world they have one fixed anchor, that of the
  // earlier map.
  graph_.join(merge.world, merge.into);

  // Similarity constraints, Eq. (8), or as many as enhance them, Eq. (9).
  use(*first);
  merge.closures.push_back(static_cast<int>(*first));
  for (auto pair = pairs.begin() + 1; pair != pairs.end(); ++pair) {
    const auto enhancing = examine(*pair, predicted(*pair), config_.enhanced);
    if (!enhancing || closures_[*enhancing].state == ClosureState::kRefused) continue;
    use(*enhancing);
    merge.enhancing.push_back(static_cast<int>(*enhancing));
  }
  ++revision_;
  optimize();
  log::info("map {} is joined to map {} by {} similarity constraints, after the paper", merge.world,
            merge.into, 1 + merge.enhancing.size());
  merges_.push_back(std::move(merge));
  return true;
}

std::optional<std::size_t> PaperMapper::examine(const SimilarPair& pair, const SE3& T_target_source,
                                                const IcpConfig& icp) {
  Stopwatch stopwatch;
  const auto source = around(pair.source);
  auto target = around(pair.target);
  if (!source || !target) return std::nullopt;
  times_.submaps += stopwatch.lap_ms();
  const SE3 T_keyframe_points_inverse = target->T_keyframe_points.inverse();
  const NearestPoint nearest(std::move(target->points));
  const IcpResult fit = register_points(
      source->points, nearest, T_keyframe_points_inverse * T_target_source * source->T_keyframe_points, icp);
  times_.verify += stopwatch.lap_ms();
  Closure closure;
  closure.id = static_cast<int>(closures_.size());
  closure.source = pair.source;
  closure.target = pair.target;
  closure.source_map = graph_.map_of(pair.source);
  closure.target_map = graph_.map_of(pair.target);
  closure.time = now_;
  closure.origin = ClosureOrigin::kRecognised;
  const bool fits = fit.iterations > 0 && fit.fitness <= icp.max_fitness;
  closure.state = fits ? ClosureState::kWaiting : ClosureState::kRefused;
  closure.score = 1.0 - pair.distance;
  closure.T_target_source =
      target->T_keyframe_points * fit.T_target_source * source->T_keyframe_points.inverse();
  closure.information = Matrix6d::Identity() / config_.closure_variance;
  closure.residual_rms = std::sqrt(fit.fitness);
  closure.moved = -1.0;
  if (graph_.are_connected(closure.source_map, closure.target_map)) {
    const math::Vector6d apart = math::se3_log(predicted(pair).inverse() * closure.T_target_source);
    closure.moved = apart.tail<3>().norm();
    closure.turned = apart.head<3>().norm();
  }
  closure.reason = fmt::format("fitness {:.3f} m^2 after {} iterations", fit.fitness, fit.iterations);
  closures_.push_back(std::move(closure));
  return closures_.size() - 1;
}

std::optional<PaperMapper::Surroundings> PaperMapper::around(int keyframe) {
  keyframe::Keyframes keyframes;
  SE3 T_map_keyframe;
  for (int id = keyframe - config_.num_around; id <= keyframe + config_.num_around; ++id) {
    if (id < 0 || id >= graph_.num_keyframes() || graph_.map_of(id) != graph_.map_of(keyframe)) continue;
    auto loaded = store_.load(id);
    if (!loaded) {
      log::warning("{}", loaded.error().message);
      return std::nullopt;
    }
    if (id == keyframe) T_map_keyframe = (*loaded)->T_map_imu;
    keyframes.push_back(std::move(*loaded));
  }
  keyframe::Submap submap = keyframe::build_submap(keyframes, {.voxel = config_.voxel, .radius = kRadius});
  return Surroundings{T_map_keyframe.inverse() * submap.T_map_submap, std::move(submap.points)};
}

SE3 PaperMapper::predicted(const SimilarPair& pair) const {
  return graph_.T_world_keyframe(pair.target).inverse() * graph_.T_world_keyframe(pair.source);
}

void PaperMapper::use(std::size_t closure) {
  closures_[closure].state = ClosureState::kCounts;
  graph_.add_closure(closures_[closure]);
}

// Over the poses of both maps and T_a^s, Eq. (7), which is the anchor of the map that moved.
void PaperMapper::optimize() {
  if (!config_.optimize) return;
  Stopwatch stopwatch;
  const MapGraph::Solution solution = graph_.optimize();
  if (solution.solved) ++revision_;
  if (error_.empty()) error_ = solution.error;
  times_.optimize += stopwatch.lap_ms();
}

}  // namespace mmlins::mapping
