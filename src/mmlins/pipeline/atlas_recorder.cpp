// SPDX-License-Identifier: MIT
#include "mmlins/pipeline/atlas_recorder.hpp"

#include <algorithm>
#include <nlohmann/json.hpp>
#include <utility>

namespace mmlins::pipeline {
namespace {

using nlohmann::ordered_json;

std::string evidence_of(const mapping::Closure& closure) {
  return ordered_json{{"origin", std::string(to_string(closure.origin))}, {"score", closure.score},
                      {"overlap", closure.overlap}, {"residual_rms_m", closure.residual_rms}, {"reason", closure.reason}}
      .dump();
}

std::string evidence_of(const graph::Edge& edge, const mapping::BackEndMapper& mapper) {
  return edge.robust ? evidence_of(mapper.closures()[static_cast<std::size_t>(edge.provenance)]) : std::string();
}

std::string evidence_of(const mapping::Merge& merge) {
  ordered_json evidence{
      {"closures", merge.closures}, {"enhancing", merge.enhancing}, {"motion_between_was_known", merge.prior_known}};
  if (merge.undone) evidence["undone_because"] = merge.why_undone;
  return evidence.dump();
}

bool is_same(const graph::Edge& a, const graph::Edge& b) {
  return a.from == b.from && a.to == b.to && a.robust == b.robust && a.provenance == b.provenance;
}

}  // namespace

Status AtlasRecorder::begin_map(const odometry::MapRecord& map, const mapping::BackEndMapper& mapper) {
  const graph::Anchor& anchor = mapper.map_graph().graph().anchors[static_cast<std::size_t>(map.id)];
  return atlas_.add_map({map.id, atlas::MapState::kActive, mapper.map_graph().world_of(map.id),
                         std::string(to_string(map.beginning)), "", map.begin, map.begin, anchor.T_world_map});
}

Status AtlasRecorder::end_map(const odometry::MapRecord& map, const mapping::BackEndMapper& mapper) {
  if (Status status = follow(mapper); !status) return status;
  if (Status status = add_gravity(mapper, mapper.map_graph().graph().gravity.size()); !status) return status;
  auto maps = atlas_.maps();
  if (!maps) return maps.error();
  for (atlas::MapRow& row : *maps) {
    if (row.id != map.id) continue;
    row.state = atlas::MapState::kSleeping;
    row.why_ended = std::string(to_string(map.why_ended));
    row.last = map.last_believed;
    if (Status status = atlas_.update_map(row); !status) return status;
  }
  return atlas_.commit();
}

Status AtlasRecorder::follow(const mapping::BackEndMapper& mapper) {
  const bool changed = mapper.revision() != revision_ || mapper.merges().size() != merge_ids_.size();
  if (Status status = add_places(mapper); !status) return status;
  // The latest factor still moves along with the keyframes.
  const std::size_t num_gravity = mapper.map_graph().graph().gravity.size();
  if (Status status = add_gravity(mapper, num_gravity > 0 ? num_gravity - 1 : 0); !status) return status;
  if (Status status = changed ? write_change(mapper) : add_edges(mapper); !status) return status;
  if (!changed) {
    if (Status status = place_latest(mapper); !status) return status;
  }
  num_keyframes_ = static_cast<std::size_t>(mapper.map_graph().num_keyframes());
  return atlas_.commit();
}

Status AtlasRecorder::add_edges(const mapping::BackEndMapper& mapper) {
  const graph::PoseGraph& graph = mapper.map_graph().graph();
  for (std::size_t i = edge_ids_.size(); i < graph.edges.size(); ++i) {
    const auto id = atlas_.add_edge({0, graph.edges[i], 1.0, evidence_of(graph.edges[i], mapper)});
    if (!id) return id.error();
    edge_ids_.push_back(*id);
    edges_.push_back(graph.edges[i]);
    weights_.push_back(1.0);
  }
  return {};
}

Status AtlasRecorder::add_gravity(const mapping::BackEndMapper& mapper, std::size_t end) {
  const std::vector<graph::GravityFactor>& gravity = mapper.map_graph().graph().gravity;
  for (; num_gravity_ < end; ++num_gravity_) {
    const graph::GravityFactor& factor = gravity[num_gravity_];
    if (Status status = atlas_.add_gravity({static_cast<int>(factor.node), factor.up_node, factor.sigma}); !status) return status;
  }
  return {};
}

Status AtlasRecorder::add_places(const mapping::BackEndMapper& mapper) {
  const std::vector<mapping::SubmapRecord>& submaps = mapper.submaps();
  for (; num_places_ < submaps.size(); ++num_places_) {
    const mapping::SubmapRecord& submap = submaps[num_places_];
    const graph::Node& middle = mapper.map_graph().graph().nodes[static_cast<std::size_t>(submap.id)];
    std::vector<int> keyframes;
    for (int id = submap.first_keyframe; id <= submap.last_keyframe; ++id) keyframes.push_back(id);
    const atlas::PlaceRow row{submap.map_id, submap.id, middle.T_map_node * submap.T_keyframe_submap, std::move(keyframes),
                              submap.footprint};
    if (Status status = atlas_.add_place(row); !status) return status;
  }
  return {};
}

Status AtlasRecorder::place_latest(const mapping::BackEndMapper& mapper) {
  // A keyframe of a map that was moved within itself lies elsewhere than the odometry says from the beginning.
  if (revision_ == 0) return {};
  atlas::GraphChange change;
  const graph::PoseGraph& graph = mapper.map_graph().graph();
  for (std::size_t i = num_keyframes_; i < graph.nodes.size(); ++i) {
    change.T_map_imu_optimised.push_back({static_cast<int>(i), graph.nodes[i].T_map_node});
  }
  if (change.T_map_imu_optimised.empty()) return {};
  const auto committed = atlas_.apply(change);
  return committed ? Status{} : Status{committed.error()};
}

std::vector<atlas::EdgeWeight> AtlasRecorder::forget_edges(const graph::PoseGraph& graph) {
  std::vector<atlas::EdgeWeight> gone;
  std::size_t kept = 0;
  for (std::size_t i = 0; i < edges_.size(); ++i) {
    if (kept >= graph.edges.size() || !is_same(edges_[i], graph.edges[kept])) {
      gone.push_back({edge_ids_[i], 0.0});
      continue;
    }
    edge_ids_[kept] = edge_ids_[i];
    weights_[kept] = weights_[i];
    edges_[kept++] = edges_[i];
  }
  edge_ids_.resize(kept);
  weights_.resize(kept);
  edges_.resize(kept);
  return gone;
}

atlas::GraphChange AtlasRecorder::change_of(const mapping::BackEndMapper& mapper) {
  const graph::PoseGraph& graph = mapper.map_graph().graph();
  const std::vector<double>& weights = mapper.map_graph().weights();
  atlas::GraphChange change;
  change.weights = forget_edges(graph);
  for (std::size_t i = 0; i < graph.edges.size(); ++i) {
    const graph::Edge& edge = graph.edges[i];
    const double weight = i < weights.size() ? weights[i] : 1.0;
    if (i >= edge_ids_.size()) {
      change.new_edges.push_back({0, edge, weight, evidence_of(edge, mapper)});
      edges_.push_back(edge);
      weights_.push_back(weight);
    } else if (weights_[i] != weight) {
      change.weights.push_back({edge_ids_[i], weight});
      weights_[i] = weight;
    }
  }
  for (const graph::Node& node : graph.nodes) change.T_map_imu_optimised.push_back({static_cast<int>(node.id), node.T_map_node});
  for (const graph::Anchor& anchor : graph.anchors) {
    change.T_world_map.push_back({anchor.map, anchor.T_world_map});
    change.worlds.push_back({anchor.map, mapper.map_graph().world_of(anchor.map)});
  }
  return change;
}

Status AtlasRecorder::write_change(const mapping::BackEndMapper& mapper) {
  atlas::GraphChange change = change_of(mapper);
  revision_ = mapper.revision();
  const std::vector<mapping::Merge>& merges = mapper.merges();
  for (std::size_t i = 0; i < merge_ids_.size(); ++i) {
    if (!merges[i].undone || !merge_stands_[i]) continue;
    change.undone_merges.push_back({merge_ids_[i], evidence_of(merges[i])});
    merge_stands_[i] = false;
  }
  for (std::size_t i = merge_ids_.size(); i < merges.size(); ++i) {
    const mapping::Merge& merge = merges[i];
    const math::SE3 T_after = mapper.map_graph().graph().anchors[static_cast<std::size_t>(merge.world)].T_world_map;
    change.new_merges.push_back({0, merge.time, merge.world, merge.into, "merge", evidence_of(merge),
                                 merge.T_new_old.inverse() * T_after, T_after, merge.undone.has_value()});
    merge_stands_.push_back(!merge.undone);
  }
  const auto committed = atlas_.apply(change);
  if (!committed) return committed.error();
  edge_ids_.insert(edge_ids_.end(), committed->edge_ids.begin(), committed->edge_ids.end());
  merge_ids_.insert(merge_ids_.end(), committed->merge_ids.begin(), committed->merge_ids.end());
  return {};
}

}  // namespace mmlins::pipeline
