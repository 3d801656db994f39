// SPDX-License-Identifier: MIT
#pragma once
// From placed scans to keyframes: one for every metre or turn, with everything that was seen since the one before.

#include <optional>
#include <span>

#include "mmlins/base/config_fields.hpp"
#include "mmlins/keyframe/keyframe.hpp"
#include "mmlins/spatial/voxel_table.hpp"

namespace mmlins::keyframe {

struct KeyframeConfig {
  double distance = 1.0;
  double angle_deg = 10.0;
  double voxel = 0.2;

  [[nodiscard]] Fields fields();
};

/// A scan whose place in its map is believed.
struct PlacedScan {
  int map_id = 0;
  Time time;
  math::SE3 T_map_imu;
  math::Vector3d down_imu = -math::Vector3d::UnitZ();  ///< direction of gravity, unit
  std::span<const Eigen::Vector3f> points_imu;         ///< straightened to `time` [m]
  std::span<const float> intensities;                  ///< of each point, or empty
};

class KeyframeBuilder {
 public:
  explicit KeyframeBuilder(const KeyframeConfig& config);

  /// @pre the scan belongs to the map of the one before, or finish() was called
  /// @return the keyframe that is due at this scan
  [[nodiscard]] std::optional<Keyframe> add(const PlacedScan& scan);
  /// @return a last keyframe of the map, at the last scan, if that saw anything since the one before
  [[nodiscard]] std::optional<Keyframe> finish();

 private:
  struct Seen {
    Eigen::Vector3f p_map;
    std::uint16_t intensity = 0;
  };
  [[nodiscard]] bool is_due(const PlacedScan& scan) const;
  [[nodiscard]] Keyframe take();

  KeyframeConfig config_;
  int next_id_ = 0;
  std::optional<math::SE3> T_map_last_;  ///< the keyframe before, none at the beginning of a map
  std::optional<Keyframe> latest_;       ///< the last scan since then, without points
  spatial::VoxelTable<Seen> seen_;       ///< since the keyframe before
};

}  // namespace mmlins::keyframe
