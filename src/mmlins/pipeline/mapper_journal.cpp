// SPDX-License-Identifier: MIT
#include "mmlins/pipeline/mapper_journal.hpp"

#include <nlohmann/json.hpp>
#include <utility>

namespace mmlins::pipeline {
namespace {

using nlohmann::ordered_json;

std::string evidence_of(const mapping::Closure& closure) {
  return ordered_json{{"origin", std::string(to_string(closure.origin))},
                      {"score", closure.score},
                      {"overlap", closure.overlap},
                      {"residual_rms_m", closure.residual_rms},
                      {"reason", closure.reason}}
      .dump();
}

std::string evidence_of(const graph::Edge& edge, const mapping::BackEndMapper& mapper) {
  return evidence_of(mapper.closures()[static_cast<std::size_t>(edge.provenance)]);
}

std::string evidence_of(const mapping::Merge& merge) {
  ordered_json evidence{{"closures", merge.closures},
                        {"enhancing", merge.enhancing},
                        {"motion_between_was_known", merge.prior_known}};
  if (merge.undone) evidence["undone_because"] = merge.why_undone;
  return evidence.dump();
}

bool is_same(const graph::Edge& a, const graph::Edge& b) {
  return a.from == b.from && a.to == b.to && a.provenance == b.provenance;
}

}  // namespace

bool MapperChange::is_empty() const {
  return places.empty() && graph.new_merges.empty() && graph.undone_merges.empty() &&
         graph.new_edges.empty() && graph.weights.empty() && graph.T_map_imu_optimised.empty() &&
         graph.T_world_map.empty() && graph.worlds.empty();
}

MapperChange MapperJournal::take(const mapping::BackEndMapper& mapper) {
  MapperChange change;
  change.has_moved = mapper.revision() != revision_ || mapper.merges().size() != merge_stands_.size();
  add_places(mapper, change);
  add_edges(mapper, change.has_moved, change);
  if (change.has_moved) add_merges(mapper, change);
  add_poses(mapper, change);
  return change;
}

void MapperJournal::add_places(const mapping::BackEndMapper& mapper, MapperChange& change) {
  const std::vector<mapping::SubmapRecord>& submaps = mapper.submaps();
  for (; num_places_ < submaps.size(); ++num_places_) {
    const mapping::SubmapRecord& submap = submaps[num_places_];
    const graph::Node& middle = mapper.map_graph().graph().nodes[static_cast<std::size_t>(submap.id)];
    std::vector<int> keyframes;
    for (int id = submap.first_keyframe; id <= submap.last_keyframe; ++id) keyframes.push_back(id);
    change.places.push_back({submap.map_id, submap.id, middle.T_map_node * submap.T_keyframe_submap,
                             std::move(keyframes), submap.footprint});
  }
}

void MapperJournal::add_edges(const mapping::BackEndMapper& mapper, bool has_changed, MapperChange& change) {
  const graph::PoseGraph& graph = mapper.map_graph().graph();
  const std::vector<double>& weights = mapper.map_graph().weights();
  const std::vector<Closed> before = std::exchange(closed_, {});
  std::size_t next = 0;  // of those before
  for (std::size_t i = 0; i < graph.edges.size(); ++i) {
    const graph::Edge& edge = graph.edges[i];
    if (!edge.robust) continue;  // of the odometry
    const double weight = has_changed && i < weights.size() ? weights[i] : 1.0;
    // Those that the graph has no longer count nothing.
    while (next < before.size() && !is_same(before[next].edge, edge))
      change.graph.weights.push_back({before[next++].id, 0.0});
    if (next == before.size()) {
      change.graph.new_edges.push_back({next_edge_, edge, weight, evidence_of(edge, mapper)});
      closed_.push_back({next_edge_++, edge, weight});
      continue;
    }
    closed_.push_back(before[next++]);
    if (!has_changed || closed_.back().weight == weight) continue;
    closed_.back().weight = weight;
    change.graph.weights.push_back({closed_.back().id, weight});
  }
  while (next < before.size()) change.graph.weights.push_back({before[next++].id, 0.0});
}

void MapperJournal::add_poses(const mapping::BackEndMapper& mapper, MapperChange& change) {
  const graph::PoseGraph& graph = mapper.map_graph().graph();
  if (change.has_moved) num_keyframes_ = num_maps_ = 0;
  was_moved_ = was_moved_ || change.has_moved;
  // Until something has been moved within its map, keyframes lie where the odometry says.
  if (!was_moved_) num_keyframes_ = graph.nodes.size();
  for (; num_keyframes_ < graph.nodes.size(); ++num_keyframes_) {
    const graph::Node& node = graph.nodes[num_keyframes_];
    change.graph.T_map_imu_optimised.push_back({static_cast<int>(node.id), node.T_map_node});
  }
  for (; num_maps_ < graph.anchors.size(); ++num_maps_) {
    const graph::Anchor& anchor = graph.anchors[num_maps_];
    change.graph.T_world_map.push_back({anchor.map, anchor.T_world_map});
    change.graph.worlds.push_back({anchor.map, mapper.map_graph().world_of(anchor.map)});
  }
}

void MapperJournal::add_merges(const mapping::BackEndMapper& mapper, MapperChange& change) {
  revision_ = mapper.revision();
  const std::vector<mapping::Merge>& merges = mapper.merges();
  for (std::size_t i = 0; i < merges.size(); ++i) {
    const mapping::Merge& merge = merges[i];
    if (i < merge_stands_.size()) {
      if (!merge.undone || !merge_stands_[i]) continue;
      change.graph.undone_merges.push_back({merge.number(), evidence_of(merge)});
      merge_stands_[i] = false;
      continue;
    }
    const math::SE3 T_after =
        mapper.map_graph().T_world_map(merge.world);
    change.graph.new_merges.push_back({merge.number(), merge.time, merge.world, merge.into, "merge", evidence_of(merge),
                                       merge.T_before, T_after,
                                       merge.undone.has_value()});
    merge_stands_.push_back(!merge.undone);
  }
}

}  // namespace mmlins::pipeline
