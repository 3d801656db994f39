// SPDX-License-Identifier: MIT
#pragma once
// All parameters of the odometry, and their only defaults.

#include "mmlins/base/config_fields.hpp"
#include "mmlins/degeneracy/observability.hpp"
#include "mmlins/initialization/initialization_config.hpp"
#include "mmlins/odometry/trust.hpp"
#include "mmlins/spatial/knn_map.hpp"
#include "mmlins/spatial/plane_map.hpp"

namespace mmlins::odometry {

enum class MapKind { kPlanes, kKnn };
enum class DetectorKind { kDefault, kPaper, kPublished, kZhang };

struct ImuModelConfig {
  double gyro_noise_factor = 1.5;
  double accel_noise_factor = 10.0;
  double bias_walk_factor = 1.0;
  double gyro_scale_deviation = 0.01;
  double max_gap = 0.1;

  [[nodiscard]] Fields fields();
};

struct ScanConfig {
  int target_keypoints = 2000;
  double min_leaf = 0.1;
  double max_leaf = 1.5;
  double map_leaf_share = 0.5;

  [[nodiscard]] Fields fields();
};

struct MatchingConfig {
  int max_iterations = 5;
  int min_matches = 50;
  double gate_sigmas = 3.0;
  double huber_sigmas = 1.0;
  bool soften_weak_directions = false;

  [[nodiscard]] Fields fields();
};

struct LocalMapConfig {
  MapKind kind = MapKind::kPlanes;
  double radius = 150.0;
  double insert_distance = 0.1;
  double insert_angle_deg = 2.0;
  int initial_insertions = 5;
  spatial::PlaneMapConfig planes;
  spatial::KnnMapConfig knn;

  [[nodiscard]] Fields fields();
};

struct StartConfig {
  double rest_window = 1.0;
  double motion_window = 2.0;
  double rest_gyro_deviation = 0.02;
  double rest_accel_deviation = 0.2;
  double rest_speed = 0.1;
  double motion_accel = 1.5;
  double motion_speed = 15.0;
  double settled_speed = 0.03;
  int max_passes = 12;
  double retry = 0.5;

  [[nodiscard]] Fields fields();
};

/// When the map falls asleep, and what a new one has to prove.
struct RestartConfig {
  double max_drift = 1.0;
  double max_drift_deg = 5.0;
  double unexplained = 0.6;
  double unexplained_near = 1.7;
  double trial = 0.6;
  double patience = 3.0;
  double min_explained = 0.35;
  double min_explained_collapsed = 0.6;
  double pose_deviation = 0.005;
  double pose_deviation_deg = 0.03;
  double confirming_motion = 0.5;
  double confirming_turn_deg = 15.0;

  [[nodiscard]] Fields fields();
};

/// When a local map made of keyframes takes the place of the one that grew.
struct RebuiltMapConfig {
  double deviation = 0.05;
  double deviation_deg = 0.2;
  double settle = 0.005;
  double settle_deg = 0.03;
  double min_explained = 0.97;
  double max_residual = 1.1;
  int patience = 10;

  [[nodiscard]] Fields fields();
};

struct OdometryConfig {
  DetectorKind detector = DetectorKind::kDefault;
  ImuModelConfig imu;
  ScanConfig scan;
  MatchingConfig matching;
  LocalMapConfig map;
  RebuiltMapConfig rebuilt;
  StartConfig start;
  TrustConfig trust;
  RestartConfig restart;
  initialization::InitializationConfig initialization;
  degeneracy::ObservabilityConfig observability;

  [[nodiscard]] Fields fields();
};

}  // namespace mmlins::odometry
