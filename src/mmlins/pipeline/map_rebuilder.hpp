// SPDX-License-Identifier: MIT
#pragma once
// What the back end has for the odometry: whenever places were recognised, a local map of what is around the
// robot.

#include <optional>
#include <vector>

#include "mmlins/keyframe/keyframe_store.hpp"
#include "mmlins/mapping/back_end_mapper.hpp"
#include "mmlins/odometry/rebuilt_map.hpp"

namespace mmlins::pipeline {

/// The keyframe's points, which keep it alive.
[[nodiscard]] odometry::PlacedPoints placed_points(const keyframe::KeyframePointer& keyframe,
                                                   const math::SE3& T_map_imu);

class MapRebuilder {
 public:
  MapRebuilder(const mapping::MappingConfig& mapping, const odometry::OdometryConfig& odometry,
               const sensor::Rig& rig);

  /// To be called after each keyframe, once the mapper has worked it off.
  /// @return nothing unless something was recognised and the robot has known surroundings
  [[nodiscard]] std::optional<odometry::RebuiltMap> after(const keyframe::Keyframe& keyframe,
                                                          const mapping::BackEndMapper& mapper,
                                                          keyframe::KeyframeStore& store);

  /// Time spent so far.
  [[nodiscard]] double milliseconds() const { return milliseconds_; }

 private:
  void look_for_news(const mapping::BackEndMapper& mapper);
  [[nodiscard]] std::optional<odometry::RebuiltMap> rebuild(const mapping::MapGraph& graph,
                                                            keyframe::KeyframeStore& store);

  mapping::RebuildConfig config_;
  odometry::OdometryConfig odometry_;
  sensor::Rig rig_;
  std::vector<math::SE3> T_map_imu_;  ///< of all keyframes as the odometry had them
  long num_known_ = 0;                ///< closures that count or confirm
  long num_undone_ = 0;               ///< merges
  std::size_t num_merges_ = 0;
  int map_id_ = -1;
  std::optional<math::SE3> T_map_world_;  ///< as the last map was made; none for the active map yet
  bool was_wrong_ = false;                ///< a merge was taken back since the last map was made
  bool has_news_ = false;                 ///< since the last map was made
  double quiet_until_ = 0.0;              ///< odometer [m]
  double milliseconds_ = 0.0;
};

}  // namespace mmlins::pipeline
