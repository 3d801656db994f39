// SPDX-License-Identifier: MIT
#pragma once
// What the map database holds, as plain data. docs/formats.md, "Atlas".

#include <cstdint>
#include <string>
#include <vector>

#include "mmlins/base/time.hpp"
#include "mmlins/graph/pose_graph.hpp"
#include "mmlins/math/se3.hpp"
#include "mmlins/place/place_descriptor.hpp"

namespace mmlins::atlas {

using math::SE3;
using math::Vector3d;

enum class MapState { kActive, kSleeping };

struct MapRow {
  int id = 0;
  MapState state = MapState::kActive;
  int world = 0;          ///< maps that were merged share a world: the lowest id of a map in it
  std::string beginning;  ///< how it began: "at rest", "in motion", "after a gap"
  std::string why_ended;  ///< empty: it has not
  Time begin;
  Time last;        ///< of the last scan placed in it
  SE3 T_world_map;  ///< its anchor
};

/// Where the points of a keyframe lie.
struct RecordPlace {
  int chunk = 0;            ///< number of the chunk file
  std::int64_t offset = 0;  ///< of the record in the file [bytes]
};

struct KeyframeRow {
  int id = 0;  ///< unique among all maps
  int map_id = 0;
  Time time;
  SE3 T_map_imu;            ///< as the odometry had it; never changed
  SE3 T_map_imu_optimised;  ///< the same until the graph is optimised
  Vector3d down_imu = -Vector3d::UnitZ();
  int num_points = 0;
  RecordPlace place;
};

/// The ids of its nodes are those of keyframes.
struct EdgeRow {
  std::int64_t id = 0;  ///< 0: the atlas gives the next one when it is added
  graph::Edge edge;
  double weight = 1.0;   ///< 0: rejected as false
  std::string evidence;  ///< JSON: why it is believed
};

struct GravityRow {
  int keyframe_id = 0;
  Vector3d up_imu = Vector3d::UnitZ();  ///< unit vector
  double sigma = 0.01;                  ///< standard deviation per axis [rad]
};

/// A submap by which a place is recognised.
struct PlaceRow {
  int map_id = 0;
  int submap_id = 0;
  SE3 T_map_submap;
  std::vector<int> keyframe_ids;
  place::Footprint footprint;
};

struct MergeRow {
  int id = 0;  ///< 0: the atlas gives the next one when it is added
  Time time;   ///< of the recording, when it was decided
  int map = 0;
  int into = 0;
  std::string kind;
  std::string evidence;  ///< JSON: why it is believed
  SE3 T_before;          ///< anchor of `map` before and after
  SE3 T_after;
  bool undone = false;
};

/// A pose for the keyframe or map of this id.
struct PosedId {
  int id = 0;
  SE3 pose;
};
struct EdgeWeight {
  std::int64_t id = 0;
  double weight = 0.0;
};
struct MapWorld {
  int map_id = 0;
  int world = 0;
};

/// A merge that was taken back.
struct UndoneMerge {
  int id = 0;
  std::string evidence;  ///< JSON that replaces what stood there; empty: that stays
};

/// What the back end found out, to be written all at once.
struct GraphChange {
  std::vector<MergeRow> new_merges;
  std::vector<UndoneMerge> undone_merges;
  std::vector<EdgeRow> new_edges;
  std::vector<EdgeWeight> weights;
  std::vector<PosedId> T_map_imu_optimised;  ///< of keyframes
  std::vector<PosedId> T_world_map;          ///< of maps
  std::vector<MapWorld> worlds;
};

}  // namespace mmlins::atlas
