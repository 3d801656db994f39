// SPDX-License-Identifier: MIT
#pragma once
// What the odometry says about one scan.

#include <memory>
#include <optional>
#include <string_view>

#include "mmlins/degeneracy/observability.hpp"
#include "mmlins/imu/propagation.hpp"
#include "mmlins/lidar/deskew.hpp"
#include "mmlins/sensor/lidar_scan.hpp"

namespace mmlins::odometry {

enum class TrackingState {
  kInitializing,  ///< part of the window from which the start was found
  kTracking,      ///< matched against the map, in all six directions
  kDegraded,      ///< matched, but the scan leaves directions to the IMU
  kBridging,      ///< not matched: the IMU carried the pose here, and its drift is still within the budget
  kLost,          ///< the budget is spent, the map sleeps; the IMU goes on carrying the pose
  kRelocating,    ///< the LiDAR sees again: a return from afar is on trial, or, as the map sleeps, a new one
};

enum class Cause {
  kNone,
  kNoPoints,        ///< the scan is empty within the range gate
  kBlocked,         ///< the scan has collapsed to what is near, or to few points, and the map does not explain it
  kTooFewMatches,   ///< there are points, but the map does not explain them
  kWeakDirections,  ///< the geometry does not determine all six directions; see observability
  kAmbiguous,       ///< after an absence: several places fit, or the pose is in more doubt than a search can cover
  kImuDisagrees,    ///< the scan matches, but moves otherwise than the IMU feels: what it shows moves along
  kImuGap,          ///< matched, but the IMU was silent for part of the way
  kNoStart,         ///< velocity and gravity were not found well enough to begin a map with
};

/// Whether the scan was matched, so that its points may be drawn where the pose says.
[[nodiscard]] bool is_placed(TrackingState state);
[[nodiscard]] std::string_view to_string(TrackingState state);
[[nodiscard]] std::string_view to_string(Cause cause);

/// Milliseconds spent on one scan.
struct StageTimes {
  double propagate = 0.0;
  double deskew = 0.0;
  double downsample = 0.0;
  double update = 0.0;
  double health = 0.0;
  double insert = 0.0;
  double start = 0.0;  ///< the search for a start since the result before, and new maps on trial

  [[nodiscard]] double total() const { return propagate + deskew + downsample + update + health + insert + start; }
};

/// What the scan alone says about the pose: d^T H d + 2 b^T d + const around `T_odom_imu`, with
/// d = [rotation (on the right); position (added, in odom)].
struct ScanPull {
  math::SE3 T_odom_imu;
  math::Matrix6d H = math::Matrix6d::Zero();
  math::Vector6d b = math::Vector6d::Zero();
};

struct ScanResult {
  Time time;                 ///< end of the scan; the pose is the one at this time
  int map_id = 0;            ///< the map that the scan belongs to, or that fell asleep last
  math::SE3 T_odom_map;      ///< where that map lies; odom itself never jumps
  imu::Estimate estimate;    ///< T_odom_imu, velocity, biases; the covariance is that against the map
  bool was_deceived = false;    ///< the IMU contradicts the scans of the last second: what it alone makes of them was taken up
  bool imu_was_silent = false;  ///< for part of the way from the scan before: the motion there is not known
  std::optional<imu::NavState> carried;  ///< what the IMU alone made of the way from the scan before; none at the start
  TrackingState state = TrackingState::kInitializing;
  Cause cause = Cause::kNone;
  int num_points = 0;        ///< within the range gate
  int num_keypoints = 0;     ///< left to match after thinning
  int num_matches = 0;
  int iterations = 0;
  double residual_rms = 0.0;             ///< of the matches, point to plane [m]
  double median_range = 0.0;             ///< of the scan [m]
  bool map_rebuilt = false;              ///< from here on a map made of keyframes is matched against
  double explained = 0.0;                ///< share of the keypoints that match the map
  double disagreement = 0.0;             ///< of IMU and LiDAR about the motion of the last second [m]
  double disagreement_rotation = 0.0;    ///< the same for rotation [rad]
  std::shared_ptr<const sensor::LidarScan> scan;
  std::shared_ptr<const lidar::Cloud> cloud_imu;  ///< straightened scan in the IMU frame at `time`
  degeneracy::Observability observability;  ///< of the matches; all zero without an update
  math::Matrix6d unweighted_information = math::Matrix6d::Zero();  ///< for the reference detectors; else zero
  ScanPull pull;                            ///< zero without an update
  StageTimes times;
};

}  // namespace mmlins::odometry
