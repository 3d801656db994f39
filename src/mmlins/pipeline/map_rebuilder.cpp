// SPDX-License-Identifier: MIT
#include "mmlins/pipeline/map_rebuilder.hpp"

#include <algorithm>
#include <utility>

#include "mmlins/base/stopwatch.hpp"
#include "mmlins/mapping/surroundings.hpp"

namespace mmlins::pipeline {

odometry::PlacedPoints placed_points(const keyframe::KeyframePointer& keyframe, const math::SE3& T_map_imu) {
  return {{keyframe, &keyframe->points_imu}, T_map_imu};
}

MapRebuilder::MapRebuilder(const mapping::MappingConfig& mapping, const odometry::OdometryConfig& odometry,
                           const sensor::Rig& rig)
    : config_(mapping.rebuild), odometry_(odometry), rig_(rig) {}

void MapRebuilder::look_for_news(const mapping::BackEndMapper& mapper) {
  const auto& closures = mapper.closures();
  const auto& merges = mapper.merges();
  const long num_known = std::count_if(closures.begin(), closures.end(), [](const mapping::Closure& closure) {
    return closure.state == mapping::ClosureState::kCounts ||
           closure.state == mapping::ClosureState::kConfirmed;
  });
  const long num_undone = std::count_if(merges.begin(), merges.end(),
                                        [](const mapping::Merge& merge) { return merge.undone.has_value(); });
  was_wrong_ = was_wrong_ || num_undone > num_undone_;
  has_news_ = has_news_ || was_wrong_ || num_known > num_known_;
  if (was_wrong_ || merges.size() > num_merges_) quiet_until_ = 0.0;
  num_known_ = num_known;
  num_undone_ = num_undone;
  num_merges_ = merges.size();
}

std::optional<odometry::RebuiltMap> MapRebuilder::after(const keyframe::Keyframe& keyframe,
                                                        const mapping::BackEndMapper& mapper,
                                                        keyframe::KeyframeStore& store) {
  if (!config_.enabled) return std::nullopt;
  T_map_imu_.push_back(keyframe.T_map_imu);
  if (std::exchange(map_id_, keyframe.map_id) != keyframe.map_id) {
    quiet_until_ = 0.0;
    T_map_world_.reset();
  }
  look_for_news(mapper);
  const double way = mapper.map_graph().odometer(keyframe.id);
  if (!has_news_ || way < quiet_until_) return std::nullopt;
  has_news_ = false;
  Stopwatch stopwatch;
  auto rebuilt = rebuild(mapper.map_graph(), store);
  milliseconds_ += stopwatch.lap_ms();
  if (rebuilt) quiet_until_ = way + config_.pause;
  return rebuilt;
}

std::optional<odometry::RebuiltMap> MapRebuilder::rebuild(const mapping::MapGraph& graph,
                                                          keyframe::KeyframeStore& store) {
  const math::SE3 T_map_world = mapping::place_world(graph, T_map_imu_, T_map_world_, config_);
  const mapping::Surroundings around =
      mapping::surroundings_of_latest(graph, T_map_imu_, T_map_world, config_);
  // What a merge brought that was taken back has to go, even if nothing comes in its place.
  if (!std::exchange(was_wrong_, false) && static_cast<int>(around.known.size()) < config_.min_known)
    return std::nullopt;
  // A keyframe that cannot be read is missing here, as it is from the map of the run, where it is told in the end.
  std::vector<odometry::PlacedPoints> known, recent;
  for (const mapping::PlacedKeyframe& one : around.known) {
    if (const auto loaded = store.load(one.id)) known.push_back(placed_points(*loaded, one.T_map_imu));
  }
  for (const int id : around.recent) {
    if (const auto loaded = store.load(id)) recent.push_back(placed_points(*loaded, (*loaded)->T_map_imu));
  }
  auto rebuilt = odometry::rebuild_map(known, recent, odometry_, rig_);
  if (rebuilt) T_map_world_ = rebuilt->local.T_map_cells * T_map_world;
  return rebuilt;
}

}  // namespace mmlins::pipeline
