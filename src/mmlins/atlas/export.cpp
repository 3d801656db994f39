// SPDX-License-Identifier: MIT
#include "mmlins/atlas/export.hpp"

#include <algorithm>
#include <set>
#include <unordered_set>

namespace mmlins::atlas {

Result<std::vector<WorldKeyframe>> world_keyframes(const Atlas& atlas, std::span<const int> map_ids) {
  const auto maps = atlas.maps();
  if (!maps) return maps.error();
  std::vector<WorldKeyframe> keyframes;
  for (const int id : map_ids) {
    const auto map =
        std::find_if(maps->begin(), maps->end(), [id](const MapRow& row) { return row.id == id; });
    if (map == maps->end()) {
      return make_error(ErrorCode::kNotFound, "{}: there is no map {}; mmlins maps list tells which",
                        atlas.folder(), id);
    }
    const auto rows = atlas.keyframes_of(id);
    if (!rows) return rows.error();
    for (const KeyframeRow& row : *rows) {
      keyframes.push_back({row.id, id, row.time, map->T_world_map * row.T_map_imu_optimised});
    }
  }
  std::stable_sort(keyframes.begin(), keyframes.end(),
                   [](const WorldKeyframe& a, const WorldKeyframe& b) { return a.time < b.time; });
  return keyframes;
}

Result<graph::PoseGraph> pose_graph(const Atlas& atlas, std::span<const int> map_ids) {
  const std::set<int> wanted(map_ids.begin(), map_ids.end());
  graph::PoseGraph graph;
  const auto maps = atlas.maps();
  if (!maps) return maps.error();
  for (const MapRow& map : *maps) {
    if (wanted.contains(map.id)) graph.anchors.push_back({map.id, map.T_world_map, graph.anchors.empty()});
  }
  const auto keyframes = atlas.keyframes();
  if (!keyframes) return keyframes.error();
  std::unordered_set<std::int64_t> nodes;
  for (const KeyframeRow& row : *keyframes) {
    if (!wanted.contains(row.map_id)) continue;
    nodes.insert(row.id);
    graph.nodes.push_back({.id = row.id, .map = row.map_id, .T_map_node = row.T_map_imu_optimised});
  }
  const auto edges = atlas.edges();
  if (!edges) return edges.error();
  for (const EdgeRow& row : *edges) {
    if (!(row.weight > 0.0) || !nodes.contains(row.edge.from) || !nodes.contains(row.edge.to)) continue;
    graph.edges.push_back(row.edge);
    graph.edges.back().provenance = row.id;
  }
  const auto gravity = atlas.gravity();
  if (!gravity) return gravity.error();
  for (const GravityRow& row : *gravity) {
    if (nodes.contains(row.keyframe_id)) graph.gravity.push_back({row.keyframe_id, row.up_imu, row.sigma});
  }
  return graph;
}

}  // namespace mmlins::atlas
