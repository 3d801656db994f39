// SPDX-License-Identifier: MIT
#pragma once
// Maps out of the atlas, in the frame of their world, with the optimised poses.

#include <span>
#include <string>
#include <vector>

#include "mmlins/atlas/atlas.hpp"
#include "mmlins/graph/pose_graph.hpp"

namespace mmlins::atlas {

struct WorldKeyframe {
  int id = 0;
  int map_id = 0;
  Time time;
  SE3 T_world_imu;
};
/// The keyframes of some maps in the order of time.
[[nodiscard]] Result<std::vector<WorldKeyframe>> world_keyframes(const Atlas& atlas,
                                                                 std::span<const int> map_ids);

/// The graph of some maps: the edges between them that were not rejected, and gravity. The anchor of the map
/// with the lowest id is the fixed one. An edge's provenance is replaced by its id in the atlas.
[[nodiscard]] Result<graph::PoseGraph> pose_graph(const Atlas& atlas, std::span<const int> map_ids);

enum class CloudFormat { kPcd, kPly };

struct CloudOptions {
  CloudFormat format = CloudFormat::kPcd;
  double voxel = 0.1;  ///< one measured point per cell of this edge; 0: all points [m]
};

struct CloudReport {
  std::size_t num_points = 0;
  std::size_t num_keyframes = 0;
  std::size_t num_lost = 0;  ///< keyframes whose points cannot be read
  std::string first_loss;    ///< why, for the first of them
};

/// Writes the points of some maps, float32 x y z [m] and intensity, little-endian; the file appears under its
/// name when it is complete. Never holds more than one keyframe, and the cells that keyframes to come may
/// still meet: it goes through the maps along the x axis of their world, not in the order of time.
[[nodiscard]] Result<CloudReport> export_cloud(const Atlas& atlas, std::span<const int> map_ids,
                                               const std::string& path, const CloudOptions& options);

}  // namespace mmlins::atlas
