// SPDX-License-Identifier: MIT
#pragma once
// The steady state of the odometry: one scan after the other against one local map, from a given start.

#include <memory>

#include "mmlins/filter/iterated_update.hpp"
#include "mmlins/odometry/motion_agreement.hpp"
#include "mmlins/odometry/odometry_config.hpp"
#include "mmlins/odometry/rebuilt_map.hpp"
#include "mmlins/odometry/return_search.hpp"
#include "mmlins/odometry/scan_result.hpp"
#include "mmlins/odometry/trust.hpp"
#include "mmlins/sensor/imu_buffer.hpp"
#include "mmlins/sensor/rig.hpp"

namespace mmlins::odometry {

/// The noise to reckon with: the rig's, with room for what data sheets leave out.
[[nodiscard]] imu::ImuNoise imu_noise(const ImuModelConfig& config, const sensor::Rig& rig);

class ScanTracker {
 public:
  /// Starts with an empty map at `start`; the map's frame lies at `T_odom_map`.
  ScanTracker(const OdometryConfig& config, const sensor::Rig& rig, const imu::Estimate& start,
              const math::SE3& T_odom_map = {});

  /// Propagate, straighten, match, correct, grow the map. A match that is not to be believed changes nothing:
  /// the IMU carries the pose on, and every later scan tries again to return into the map. A return from
  /// where the pose was in doubt is on trial for a while (RELOCATING), while the IMU goes on carrying it.
  /// @param scan  must end later than the current state
  /// @param imu   must hold samples from needs_imu_since() to the end of the scan
  [[nodiscard]] ScanResult track(std::shared_ptr<const sensor::LidarScan> scan, const sensor::ImuBuffer& imu);

  /// Moves on with the IMU alone, as if the scan had not been taken.
  [[nodiscard]] ScanResult carry(std::shared_ptr<const sensor::LidarScan> scan, const sensor::ImuBuffer& imu,
                                 Cause cause);

  /// From here on a match may be refused. While the start is sought, velocity and gravity are not what the
  /// filter takes them for, and every match is needed.
  void begin_to_doubt();

  [[nodiscard]] const imu::Estimate& estimate() const { return estimate_; }
  /// Replaces the estimate by a better one of the same time and frame.
  void set_estimate(const imu::Estimate& estimate);
  /// How far the pose may have drifted since it was last believed.
  struct Drift {
    double position = 0.0;  ///< standard deviation in the worst direction [m]
    double rotation = 0.0;  ///< [rad]
  };
  [[nodiscard]] Drift drift() const;
  /// The estimate after the last scan that was believed.
  [[nodiscard]] const imu::Estimate& last_trusted() const { return last_trusted_; }
  /// Whether the scan is so much smaller than usual that something must cover the sensor.
  [[nodiscard]] bool is_collapsed(const ScanResult& result) const;

  /// Where the map lies in odom.
  [[nodiscard]] const math::SE3& T_odom_map() const { return T_odom_map_; }
  /// Moves odom under everything: the pose becomes T_odom_imu, the map moves along.
  void call_the_pose(const math::SE3& T_odom_imu);

  /// Offers a local map in place of the one that grew. It is laid under the robot, which does not move, with one of the
  /// next scans that is tracked: if it explains that as well. A bridge forgets it.
  void offer(RebuiltMap rebuilt) { offered_.emplace(std::move(rebuilt)); }

  [[nodiscard]] Time needs_imu_since() const;

 private:
  struct Motion {
    imu::Propagation propagation;
    bool has_gap = false;  ///< the IMU was silent for longer than it may be
  };
  struct Prepared {
    std::shared_ptr<const lidar::Cloud> cloud_imu;  ///< straightened
    lidar::Cloud map_points;                        ///< thinned for the map
    lidar::Cloud keypoints;                         ///< and for matching
  };
  struct Match {
    filter::UpdateReport update;
    degeneracy::Observability observability;
    math::Matrix6d unweighted = math::Matrix6d::Zero();  ///< only for the reference detectors
    double residual_rms = 0.0;
    double analysis_ms = 0.0;  ///< time spent on the observability
    bool has_update = false;
    bool is_first = false;   ///< there is no map yet
    bool ambiguous = false;  ///< the map explains the scan elsewhere as well
  };
  [[nodiscard]] Drift drift_of(const imu::Estimate& estimate) const;
  [[nodiscard]] Motion propagate_to(const imu::Estimate& from, Time time, const sensor::ImuBuffer& imu) const;
  [[nodiscard]] Prepared prepare(const sensor::LidarScan& scan, const Motion& motion,
                                 StageTimes& times) const;
  /// A return from afar that has yet to prove itself, while the IMU goes on carrying the pose.
  struct Trial {
    imu::Estimate estimate;  ///< if the return is right
    Time since;
    int num_scans = 0;  ///< that agreed with it
  };
  [[nodiscard]] Match match(const Prepared& prepared, const imu::Estimate& prior) const;
  [[nodiscard]] bool is_far_off(const imu::Estimate& predicted) const;
  [[nodiscard]] Verdict judge(const Match& match, const Motion& carried, const sensor::ImuBuffer& imu, bool on_trial,
                              ScanResult& result);
  void believe(const imu::Estimate& updated, const imu::Estimate& predicted);
  [[nodiscard]] bool insertion_is_due() const;
  /// A scan and where it was seen from, in the frame of the map.
  struct Placed {
    std::vector<Eigen::Vector3f> points_imu;
    math::SE3 T_map_imu;
  };
  void grow_map(const lidar::Cloud& cloud_imu, bool returns, bool as_usual);
  void insert_into_map(const Placed& placed);
  /// Takes the map on offer if it is complete and explains the scan that was just believed.
  void consider_offer(const Prepared& prepared, ScanResult& result);

  OdometryConfig config_;
  sensor::Rig rig_;
  imu::ImuNoise noise_;
  imu::Estimate estimate_;
  imu::Estimate last_trusted_;
  math::SE3 T_odom_map_;
  LocalMapInPlace map_;
  TrustJudge judge_;
  MotionAgreement agreement_;
  double leaf_;
  bool is_bridging_ = false;
  bool doubts_ = false;
  int num_insertions_ = 0;
  math::SE3 T_map_last_insertion_;
  std::optional<Trial> trial_;       ///< of a return
  std::optional<MapOffer> offered_;
  std::optional<Placed> postponed_;  ///< enters the map if the next scan is believed
};

}  // namespace mmlins::odometry
