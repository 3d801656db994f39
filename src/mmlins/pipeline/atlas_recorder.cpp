// SPDX-License-Identifier: MIT
#include "mmlins/pipeline/atlas_recorder.hpp"

#include <utility>

namespace mmlins::pipeline {

Status AtlasRecorder::write(const MappingTask& task) {
  if (const auto* begin = std::get_if<BeginOfMap>(&task)) return begin_map(*begin);
  if (const auto* added = std::get_if<NewKeyframe>(&task)) return add(*added);
  if (const auto* end = std::get_if<EndOfMap>(&task)) return end_map(end->record);
  odometry_.bridge(std::get<Bridge>(task).covariance);
  return {};
}

Status AtlasRecorder::begin_map(const BeginOfMap& task) {
  odometry_.begin_map(task.begin);
  const odometry::MapRecord& map = task.record;
  return atlas_.add_map({map.id, atlas::MapState::kActive, map.id, std::string(to_string(map.beginning)), "",
                         map.begin, map.begin, T_moved_world_ * task.begin.T_world_map});
}

Status AtlasRecorder::add(const NewKeyframe& task) {
  const keyframe::Keyframe& kf = *task.keyframe;
  const Status added =
      atlas_.add_keyframe(kf, kf.map_id == moved_map_ ? T_moved_map_ * kf.T_map_imu : kf.T_map_imu);
  odometry_.add(kf, task.pose_covariance);
  if (!added) lost_ = kf.id;
  const graph::PoseGraph& graph = odometry_.graph();
  for (; num_edges_ < graph.edges.size(); ++num_edges_) {
    const graph::Edge& edge = graph.edges[num_edges_];
    if (edge.from == lost_ || edge.to == lost_) continue;
    if (const auto id = atlas_.add_edge({edge.to, edge, 1.0, ""}); !id) return id.error();
  }
  if (!added) return added;
  // The latest factor still moves along with the keyframes.
  return add_gravity(graph.gravity.empty() ? 0 : graph.gravity.size() - 1);
}

Status AtlasRecorder::end_map(const odometry::MapRecord& map) {
  if (Status status = add_gravity(odometry_.graph().gravity.size()); !status) return status;
  auto maps = atlas_.maps();
  if (!maps) return maps.error();
  for (atlas::MapRow& row : *maps) {
    if (row.id != map.id) continue;
    row.state = atlas::MapState::kSleeping;
    row.why_ended = std::string(to_string(map.why_ended));
    row.last = map.last_believed;
    if (Status status = atlas_.update_map(row); !status) return status;
  }
  return {};
}

Status AtlasRecorder::add_gravity(std::size_t end) {
  const std::vector<graph::GravityFactor>& gravity = odometry_.graph().gravity;
  for (; num_gravity_ < end; ++num_gravity_) {
    const graph::GravityFactor& factor = gravity[num_gravity_];
    if (Status status = atlas_.add_gravity({static_cast<int>(factor.node), factor.up_node, factor.sigma});
        !status)
      return status;
  }
  return {};
}

Status AtlasRecorder::write(MapperChange change) {
  for (const atlas::PlaceRow& place : std::exchange(change.places, {})) {
    if (Status status = atlas_.add_place(place); !status) return status;
  }
  if (change.is_empty()) return {};
  if (change.has_moved) take_along(change);
  const auto committed = atlas_.apply(change.graph);
  return committed ? Status{} : Status{committed.error()};
}

void AtlasRecorder::take_along(MapperChange& change) {
  std::vector<atlas::PosedId>& places = change.graph.T_map_imu_optimised;
  std::vector<atlas::PosedId>& anchors = change.graph.T_world_map;
  if (places.empty()) return;
  const graph::PoseGraph& graph = odometry_.graph();
  const atlas::PosedId latest = places.back();
  moved_map_ = odometry_.map_of(latest.id);
  const math::SE3 T_world_map = anchors[static_cast<std::size_t>(moved_map_)].pose;
  T_moved_map_ = latest.pose * graph.nodes[static_cast<std::size_t>(latest.id)].T_map_node.inverse();
  T_moved_world_ = T_world_map * latest.pose * odometry_.T_world_keyframe(latest.id).inverse();
  for (int id = latest.id + 1; id < odometry_.num_keyframes() && odometry_.map_of(id) == moved_map_; ++id) {
    places.push_back({id, T_moved_map_ * graph.nodes[static_cast<std::size_t>(id)].T_map_node});
  }
  for (std::size_t map = anchors.size(); map < graph.anchors.size(); ++map) {
    anchors.push_back({graph.anchors[map].map, T_moved_world_ * graph.anchors[map].T_world_map});
  }
}

}  // namespace mmlins::pipeline
