// SPDX-License-Identifier: MIT
#pragma once
// An atlas with maps of six keyframes each, which lie where the gaps between them say, and which can be joined.

#include <gtest/gtest.h>

#include <algorithm>
#include <vector>

#include "mmlins/atlas/export.hpp"
#include "mmlins/graph/optimize.hpp"
#include "tests/atlas/example.hpp"

namespace mmlins::atlas {

inline constexpr int kPerMap = 6;
inline const SE3 kStep{math::so3_exp({0.0, 0.0, 0.2}), {1.0, 0.1, 0.0}};
inline const SE3 kGap{math::so3_exp({0.0, 0.0, -0.4}), {4.0, 2.0, 0.0}};

inline SE3 nth_pose(int n) {
  SE3 T;
  for (int i = 0; i < n; ++i) T = T * kStep;
  return T;
}

inline EdgeRow edge_of(int from, int to, const SE3& T, graph::EdgeKind kind, double information = 1e4) {
  EdgeRow row;
  row.edge.from = from;
  row.edge.to = to;
  row.edge.T_from_to = T;
  row.edge.information = information * math::Matrix6d::Identity();
  row.edge.kind = kind;
  row.edge.robust = kind == graph::EdgeKind::kLoop || kind == graph::EdgeKind::kMerge;
  return row;
}

inline const SE3 kElsewhere{math::so3_exp({0.0, 0.0, 1.0}), {-3.0, 5.0, 0.0}};

inline void fill_with_chain(Atlas& atlas, int num_maps, bool has_gaps) {
  SE3 T_world_map;
  for (int map = 0; map < num_maps; ++map) {
    if (map > 0) T_world_map = T_world_map * nth_pose(kPerMap - 1) * kGap;
    MapRow row = example_map(map);
    row.T_world_map = T_world_map;
    ASSERT_TRUE(atlas.add_map(row).ok());
    for (int i = 0; i < kPerMap; ++i) {
      keyframe::Keyframe kf = example_keyframe(map * kPerMap + i, map);
      kf.T_map_imu = nth_pose(i);
      ASSERT_TRUE(atlas.add_keyframe(kf).ok());
      if (i > 0) {
        ASSERT_TRUE(atlas.add_edge(edge_of(kf.id - 1, kf.id, kStep, graph::EdgeKind::kOdometry)).ok());
      } else if (map > 0 && has_gaps) {
        ASSERT_TRUE(atlas.add_edge(edge_of(kf.id - 1, kf.id, kGap, graph::EdgeKind::kGap, 1.0)).ok());
      }
    }
  }
  ASSERT_TRUE(atlas.commit().ok());
}

/// What joins a map to another by one closure, as the back end does: all that hangs together is optimised.
inline GraphChange chain_merge(const Atlas& atlas, int map, int into, const SE3& T_into_map) {
  GraphChange change;
  const int from = into * kPerMap + 2, to = map * kPerMap + 3;
  change.new_edges = {
      edge_of(from, to, nth_pose(2).inverse() * T_into_map * nth_pose(3), graph::EdgeKind::kMerge, 1e6)};
  const auto maps = *atlas.maps();
  std::vector<int> all;
  for (const MapRow& row : maps) all.push_back(row.id);
  graph::PoseGraph graph = *pose_graph(atlas, all);
  graph.edges.push_back(change.new_edges[0].edge);
  const auto optimised = graph::optimize(graph, {});
  for (const graph::Node& node : optimised->graph.nodes) {
    change.T_map_imu_optimised.push_back({static_cast<int>(node.id), node.T_map_node});
  }
  for (const graph::Anchor& anchor : optimised->graph.anchors) {
    change.T_world_map.push_back({anchor.map, anchor.T_world_map});
  }
  const auto at = [&](int id) { return maps[static_cast<std::size_t>(id)]; };
  for (const MapRow& row : maps) {
    if (row.world == at(map).world) change.worlds.push_back({row.id, at(into).world});
  }
  change.new_merges = {{0, Time{}, map, into, "merge", "{}", at(map).T_world_map, {}, false}};
  return change;
}

/// Poses of all keyframes in their worlds.
inline std::vector<SE3> poses_of(const Atlas& atlas) {
  std::vector<SE3> poses;
  const auto maps = *atlas.maps();
  const auto keyframes = *atlas.keyframes();
  for (const KeyframeRow& row : keyframes) {
    poses.push_back(maps[static_cast<std::size_t>(row.map_id)].T_world_map * row.T_map_imu_optimised);
  }
  return poses;
}

inline std::vector<int> worlds_of(const Atlas& atlas) {
  std::vector<int> worlds;
  const auto maps = *atlas.maps();
  for (const MapRow& row : maps) worlds.push_back(row.world);
  return worlds;
}

inline double most_apart(const std::vector<SE3>& a, const std::vector<SE3>& b) {
  double most = 0.0;
  for (std::size_t i = 0; i < a.size(); ++i) most = std::max(most, math::se3_log(a[i].inverse() * b[i]).norm());
  return most;
}

}  // namespace mmlins::atlas
