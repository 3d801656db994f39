// SPDX-License-Identifier: MIT
#include "mmlins/atlas/unmerge.hpp"

#include <algorithm>
#include <map>
#include <optional>
#include <set>
#include <utility>

#include "mmlins/graph/optimize.hpp"

namespace mmlins::atlas {
namespace {

using Maps = std::set<int>;

bool is_tie(const EdgeRow& row) { return row.edge.robust && row.weight > 0.0; }

/// The atlas as it is, and as it shall be.
class Split {
 public:
  Split(std::vector<MapRow> maps, std::vector<KeyframeRow> keyframes, std::vector<EdgeRow> edges,
        std::vector<GravityRow> gravity)
      : edges_(std::move(edges)), gravity_(std::move(gravity)) {
    for (MapRow& map : maps) maps_.emplace(map.id, std::move(map));
    for (KeyframeRow& keyframe : keyframes) keyframes_.emplace(keyframe.id, std::move(keyframe));
  }

  /// A map that is referred to, but whose row is damaged and was left out; nothing if there is none.
  [[nodiscard]] std::optional<int> missing_map(const std::vector<MergeRow>& merges) const;
  /// Which maps the merge brought together, by the merges that are left. @pre no map is missing
  void divide(const MergeRow& merge, const std::vector<MergeRow>& merges);
  /// The poses of one side without the other.
  [[nodiscard]] Status settle(const Maps& side);
  /// Worlds hang on the maps before them by gaps, from the one with the first map of `side` on.
  void hang_on_gaps(const MergeRow& merge);
  [[nodiscard]] GraphChange change(int merge_id) const;
  [[nodiscard]] Unmerged report() const;
  [[nodiscard]] const Maps& stayed() const { return stayed_; }
  [[nodiscard]] const Maps& moved() const { return moved_; }

 private:
  [[nodiscard]] int map_of(std::int64_t keyframe) const {
    const auto found = keyframes_.find(static_cast<int>(keyframe));
    return found == keyframes_.end() ? -1 : found->second.map_id;
  }
  [[nodiscard]] SE3 T_world_keyframe(std::int64_t id) const {
    const KeyframeRow& keyframe = keyframes_.at(static_cast<int>(id));
    return maps_.at(keyframe.map_id).T_world_map * keyframe.T_map_imu_optimised;
  }
  [[nodiscard]] bool is_within(const EdgeRow& row, const Maps& side) const {
    return side.contains(map_of(row.edge.from)) && side.contains(map_of(row.edge.to));
  }
  [[nodiscard]] bool is_across(const EdgeRow& row) const {
    const int from = map_of(row.edge.from), to = map_of(row.edge.to);
    return (stayed_.contains(from) && moved_.contains(to)) || (moved_.contains(from) && stayed_.contains(to));
  }
  [[nodiscard]] graph::PoseGraph graph_of(const Maps& side) const;

  std::map<int, MapRow> maps_;
  std::map<int, KeyframeRow> keyframes_;
  std::vector<EdgeRow> edges_;
  std::vector<GravityRow> gravity_;
  Maps stayed_, moved_;
};

std::optional<int> Split::missing_map(const std::vector<MergeRow>& merges) const {
  Maps needed;
  for (const MergeRow& merge : merges) {
    if (!merge.undone) needed.insert({merge.map, merge.into});
  }
  for (const EdgeRow& row : edges_) {
    if (row.edge.kind == graph::EdgeKind::kGap) needed.insert({map_of(row.edge.from), map_of(row.edge.to)});
  }
  needed.erase(-1);  // a gap whose keyframe is damaged tells nothing, and nothing rests on it
  const auto missing = std::find_if(needed.begin(), needed.end(), [this](int map) { return !maps_.contains(map); });
  return missing == needed.end() ? std::nullopt : std::optional(*missing);
}

void Split::divide(const MergeRow& merge, const std::vector<MergeRow>& merges) {
  const int world = maps_.at(merge.map).world;
  moved_ = {merge.map};
  for (bool grows = true; grows;) {
    grows = false;
    for (const MergeRow& other : merges) {
      if (other.undone || other.id == merge.id || moved_.contains(other.map) == moved_.contains(other.into)) continue;
      moved_.insert(other.map);
      moved_.insert(other.into);
      grows = true;
    }
  }
  for (auto& [id, map] : maps_) {
    if (map.world != world) continue;
    if (!moved_.contains(id)) stayed_.insert(id);
    map.world = moved_.contains(id) ? *moved_.begin() : *stayed_.begin();
  }
}

graph::PoseGraph Split::graph_of(const Maps& side) const {
  graph::PoseGraph graph;
  for (const int id : side) graph.anchors.push_back({id, maps_.at(id).T_world_map, graph.anchors.empty()});
  for (const auto& [id, keyframe] : keyframes_) {
    if (side.contains(keyframe.map_id)) graph.nodes.push_back({id, keyframe.map_id, keyframe.T_map_imu, false});
  }
  for (const EdgeRow& row : edges_) {
    if (row.weight > 0.0 && is_within(row, side)) graph.edges.push_back(row.edge);
  }
  for (const GravityRow& row : gravity_) {
    if (side.contains(map_of(row.keyframe_id))) graph.gravity.push_back({row.keyframe_id, row.up_imu, row.sigma});
  }
  return graph;
}

Status Split::settle(const Maps& side) {
  for (auto& [id, keyframe] : keyframes_) {
    if (side.contains(keyframe.map_id)) keyframe.T_map_imu_optimised = keyframe.T_map_imu;
  }
  // Without closures nothing was ever optimised.
  const auto ties = [&](const EdgeRow& row) { return is_tie(row) && is_within(row, side); };
  if (std::none_of(edges_.begin(), edges_.end(), ties)) return {};
  graph::OptimizerConfig config;
  config.robust = false;  // which of them are false is known
  const auto optimised = graph::optimize(graph_of(side), config);
  if (!optimised) return optimised.error();
  for (const graph::Anchor& anchor : optimised->graph.anchors) maps_.at(anchor.map).T_world_map = anchor.T_world_map;
  for (const graph::Node& node : optimised->graph.nodes) {
    keyframes_.at(static_cast<int>(node.id)).T_map_imu_optimised = node.T_map_node;
  }
  return {};
}

void Split::hang_on_gaps(const MergeRow& merge) {
  Maps worlds;
  for (const auto& [id, map] : maps_) worlds.insert(map.world);
  for (const int world : worlds) {
    if (world == *worlds.begin() || world < *stayed_.begin()) continue;
    const auto leads_here = [&](const EdgeRow& row) {
      const int from = map_of(row.edge.from);
      return row.edge.kind == graph::EdgeKind::kGap && from >= 0 && map_of(row.edge.to) == world &&
             maps_.at(from).world != world;
    };
    const auto gap = std::find_if(edges_.begin(), edges_.end(), leads_here);
    SE3 T_new_old;
    if (gap != edges_.end()) {
      T_new_old = T_world_keyframe(gap->edge.from) * gap->edge.T_from_to * T_world_keyframe(gap->edge.to).inverse();
    } else if (world == *moved_.begin()) {
      T_new_old = merge.T_before * maps_.at(merge.map).T_world_map.inverse();
    } else {
      continue;
    }
    for (auto& [id, map] : maps_) {
      if (map.world == world) map.T_world_map = T_new_old * map.T_world_map;
    }
  }
}

GraphChange Split::change(int merge_id) const {
  GraphChange change;
  change.undone_merges = {{merge_id, ""}};
  for (const EdgeRow& row : edges_) {
    if (is_tie(row) && is_across(row)) change.weights.push_back({row.id, 0.0});
  }
  for (const auto& [id, keyframe] : keyframes_) {
    if (stayed_.contains(keyframe.map_id) || moved_.contains(keyframe.map_id)) {
      change.T_map_imu_optimised.push_back({id, keyframe.T_map_imu_optimised});
    }
  }
  for (const auto& [id, map] : maps_) {
    change.T_world_map.push_back({id, map.T_world_map});
    change.worlds.push_back({id, map.world});
  }
  return change;
}

Unmerged Split::report() const {
  const auto ties = [&](const EdgeRow& row) { return is_tie(row) && is_across(row); };
  return {{stayed_.begin(), stayed_.end()},
          {moved_.begin(), moved_.end()},
          static_cast<std::size_t>(std::count_if(edges_.begin(), edges_.end(), ties))};
}

/// The last merge that brought something to where this one did; nothing if there is none.
const MergeRow* later_merge(const MergeRow& merge, const std::vector<MergeRow>& merges, const std::vector<MapRow>& maps) {
  const auto world_of = [&](int map) {
    const auto found = std::find_if(maps.begin(), maps.end(), [map](const MapRow& row) { return row.id == map; });
    return found == maps.end() ? -1 : found->world;
  };
  for (std::size_t i = merges.size(); i-- > 0 && merges[i].id > merge.id;) {
    if (!merges[i].undone && world_of(merges[i].map) == world_of(merge.map)) return &merges[i];
  }
  return nullptr;
}

}  // namespace

Result<MergeRow> find_standing_merge(const Atlas& atlas, int merge_id) {
  const auto merges = atlas.merges();
  if (!merges) return merges.error();
  std::string known;
  for (const MergeRow& merge : *merges) {
    known += fmt::format(" {}", merge.id);
    if (merge.id != merge_id) continue;
    if (!merge.undone) return merge;
    return make_error(ErrorCode::kInvalid, "{}: merge {} was taken back already", atlas.folder(), merge_id);
  }
  return make_error(ErrorCode::kNotFound, "{}: there is no merge {}; there {}{}", atlas.folder(), merge_id,
                    merges->empty() ? "are none" : merges->size() == 1 ? "is" : "are", known);
}

Result<Unmerged> unmerge(Atlas& atlas, int merge_id) {
  const auto merges = atlas.merges();
  const auto maps = atlas.maps();
  const auto keyframes = atlas.keyframes();
  const auto edges = atlas.edges();
  const auto gravity = atlas.gravity();
  if (!merges || !maps) return merges ? maps.error() : merges.error();
  if (!keyframes || !edges || !gravity) return !keyframes ? keyframes.error() : edges ? gravity.error() : edges.error();
  const auto merge = find_standing_merge(atlas, merge_id);
  if (!merge) return merge.error();
  Split split(*maps, *keyframes, *edges, *gravity);
  if (const auto missing = split.missing_map(*merges)) {
    return make_error(ErrorCode::kInvalid, "{0}: map {1} is damaged, and others hang on it; see: mmlins maps {0} check",
                      atlas.folder(), *missing);
  }
  if (const MergeRow* later = later_merge(*merge, *merges, *maps)) {
    return make_error(ErrorCode::kInvalid, "{}: merge {} (map {} into {}) rests on merge {}; take that back first",
                      atlas.folder(), later->id, later->map, later->into, merge_id);
  }
  split.divide(*merge, *merges);
  if (!split.stayed().contains(merge->into)) {
    return make_error(ErrorCode::kInvalid, "{0}: maps {1} and {2} of merge {3} lie apart; see: mmlins maps {0} check",
                      atlas.folder(), merge->map, merge->into, merge_id);
  }
  for (const Maps* side : {&split.stayed(), &split.moved()}) {
    if (const Status status = split.settle(*side); !status) return status.error();
  }
  split.hang_on_gaps(*merge);
  if (const auto committed = atlas.apply(split.change(merge_id)); !committed) return committed.error();
  return split.report();
}

}  // namespace mmlins::atlas
