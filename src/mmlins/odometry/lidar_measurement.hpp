// SPDX-License-Identifier: MIT
#pragma once
// Point-to-plane residuals of a straightened scan against the local map, with a variance for each.
// docs/math/eskf.md, section 4.

#include <Eigen/Core>
#include <vector>

#include "mmlins/degeneracy/observability.hpp"
#include "mmlins/filter/iterated_update.hpp"
#include "mmlins/odometry/odometry_config.hpp"
#include "mmlins/spatial/local_map.hpp"

namespace mmlins::odometry {

/// What the noise of one beam depends on.
struct BeamNoise {
  double bearing = 0.0;                                    ///< standard deviation of a beam's direction [rad]
  Eigen::Vector3d p_imu_lidar = Eigen::Vector3d::Zero();   ///< where the beams come from [m]
};

/// A map and where it lies: its frame is that of odom until a return into it, which must not let odom jump.
struct PlacedMap {
  PlacedMap(const spatial::LocalMap& local_map, const math::SE3& T = {}) : map(local_map), T_map_odom(T) {}
  /// The plane near a point of odom, in the coordinates of odom.
  [[nodiscard]] spatial::PlaneMatch match(const Eigen::Vector3d& p_odom, double gate) const;

  const spatial::LocalMap& map;
  math::SE3 T_map_odom;
};

class LidarMeasurement {
 public:
  /// @param keypoints_imu  points in the IMU frame; map and points must outlive the measurement
  LidarMeasurement(const std::vector<Eigen::Vector3f>& keypoints_imu, const PlacedMap& map,
                   const MatchingConfig& config, const BeamNoise& noise);

  /// Matches every keypoint from `state` and linearises. Eqs. (15)-(19).
  [[nodiscard]] filter::PoseInformation linearise(const imu::NavState& state, const imu::ErrorMatrix& P);

  /// What the matches of the last linearisation say about the pose at `state`, before any robust weight: an
  /// outlier takes nothing from the geometry. docs/math/degeneracy.md, Eqs. (1), (5).
  [[nodiscard]] degeneracy::ScanInformation scan_information(const imu::NavState& state) const;

  /// Sum of J^T J over the matches of the last linearisation, all of weight one.
  [[nodiscard]] math::Matrix6d unweighted_information(const imu::NavState& state) const;

  /// Root mean square of the residuals at the last linearisation [m].
  [[nodiscard]] double residual_rms() const { return residual_rms_; }

 private:
  /// Residuals that share a plane share its error, so the plane's information must be capped. Eq. (18).
  void count_sharers();

  const std::vector<Eigen::Vector3f>& keypoints_imu_;
  PlacedMap map_;
  MatchingConfig config_;
  BeamNoise noise_;
  std::vector<spatial::PlaneMatch> matches_;
  std::vector<int> sharers_;   ///< per match: how many residuals use the same plane
  double residual_rms_ = 0.0;
};

}  // namespace mmlins::odometry
