// SPDX-License-Identifier: MIT
#pragma once
// One recording from its first to its last measurement: odometry in this thread, the back end in one beside it. The same
// recording gives the same results whatever the machine is doing.

#include <functional>
#include <optional>
#include <string>
#include <vector>

#include "mmlins/odometry/lidar_inertial_odometry.hpp"
#include "mmlins/atlas/atlas.hpp"
#include "mmlins/mapping/back_end_mapper.hpp"
#include "mmlins/pipeline/config.hpp"
#include "mmlins/pipeline/sensor_sync.hpp"
#include "mmlins/pipeline/voxel_map_builder.hpp"
#include "mmlins/pipeline/world_trajectory.hpp"
#include "mmlins/sensor/dataset.hpp"

namespace mmlins::pipeline {

/// One line of health.csv: what is kept of a scan, small enough to keep for hours.
struct ScanRecord {
  Time time;
  math::SE3 T_odom_imu;
  math::SE3 T_map_imu;          ///< in the frame of its own map
  math::SE3 T_world_imu;        ///< in the frame of the first map, as known at the end of the run
  std::optional<CarriedPose> carried;  ///< by the IMU alone from the scan before
  bool imu_was_silent = false;         ///< for part of the way from the scan before
  int map_id = 0;
  math::Vector3d v_imu = math::Vector3d::Zero();             ///< velocity along the axes of the IMU [m/s]
  math::Vector3d down_imu = -math::Vector3d::UnitZ();         ///< unit, where gravity points, along the axes of the IMU
  double tilt_std = 0.0;                                      ///< of `down_imu`, largest [rad]
  odometry::TrackingState state = odometry::TrackingState::kInitializing;
  odometry::Cause cause = odometry::Cause::kNone;
  int num_points = 0;
  int num_keypoints = 0;
  int num_matches = 0;
  int iterations = 0;
  double residual_rms = 0.0;                                  ///< [m]
  double explained = 0.0;                                     ///< share of the keypoints that match the map
  double disagreement = 0.0;                                  ///< of IMU and LiDAR over the last second [m]
  double disagreement_rotation = 0.0;                         ///< [rad]
  math::Vector3d position_std = math::Vector3d::Zero();       ///< along the axes of odom [m]
  math::Vector3d rotation_std = math::Vector3d::Zero();       ///< about the axes of the IMU [rad]
  degeneracy::Observability observability;
  double read_ms = 0.0;                                       ///< reading and decoding since the scan before
  odometry::StageTimes times;

  [[nodiscard]] double total_ms() const { return read_ms + times.total(); }
};

/// What the back end made of it.
struct MappingResult {
  std::vector<KeyframePlace> keyframes;
  graph::PoseGraph graph;
  std::vector<int> worlds;      ///< of each map: the first one of those that it was joined to
  std::vector<mapping::Closure> closures;
  std::vector<mapping::Merge> merges;
  mapping::MapperTimes times;
  double rebuild_ms = 0.0;      ///< spent on local maps for the odometry
  int num_rebuilt = 0;          ///< of them, those that it took
  std::string error;            ///< of the store of keyframes, the pose graph or the atlas; empty if there was none
};

struct RunResult {
  std::vector<ScanRecord> scans;
  std::vector<odometry::MapRecord> maps;
  MappingResult mapping;
  VoxelMapBuilder map{1.0};     ///< in the frame of the first map
  int num_scans_without_imu = 0;
  int num_scans_not_later = 0;
  int num_scans_ahead = 0;      ///< of the IMU and of scans that came later
  int num_late_imu_samples = 0;
  int num_clock_jumps = 0;
  double wall_seconds = 0.0;
  bool interrupted = false;
  std::string read_error;       ///< why reading ended early; empty if it did not
};

/// Called after every scan; returns false to stop and keep what there is.
using Observer = std::function<bool(const ScanRecord& latest, double progress)>;

/// Runs the whole dataset.
/// @param atlas  where the maps are kept as they grow; none: in memory alone
[[nodiscard]] RunResult run(sensor::Dataset& dataset, const sensor::Rig& rig, const SlamConfig& config,
                            const Observer& observer, atlas::Atlas* atlas = nullptr);

}  // namespace mmlins::pipeline
