// SPDX-License-Identifier: MIT
#pragma once
// The odometry as its users see it: IMU samples and scans go in, one result per scan comes out. The
// first results wait until the start has been found; after that none does. Where the pose is lost, the map falls
// asleep, the IMU carries the pose on, and a new map begins as soon as one can be believed.

#include <memory>
#include <optional>
#include <vector>

#include "mmlins/imu/gyro_calibration.hpp"
#include "mmlins/odometry/map_record.hpp"
#include "mmlins/odometry/reference_detection.hpp"
#include "mmlins/odometry/restart.hpp"
#include "mmlins/odometry/startup.hpp"

namespace mmlins::odometry {

enum class ScanAdmission {
  kAccepted,
  kNotLater,  ///< ends no later than a scan that was taken before
  kNoImu,     ///< the IMU has not begun yet
};

class LidarInertialOdometry {
 public:
  LidarInertialOdometry(const OdometryConfig& config, const sensor::Rig& rig);

  [[nodiscard]] sensor::ImuAdmission add_imu(const sensor::ImuSample& sample) { return imu_.add(calibration_.apply(sample)); }

  struct Output {
    ScanAdmission admission = ScanAdmission::kAccepted;
    std::vector<ScanResult> results;  ///< none while the start is sought, then all that waited
  };
  /// Takes a scan. The IMU should have been given up to its end; where it has not, its last reading holds.
  [[nodiscard]] Output add_scan(ScanPointer scan);

  /// No more scans will come: starts with what there is, if it has not started yet.
  [[nodiscard]] std::vector<ScanResult> finish();

  /// Offers a local map for the active map, made of keyframes that lie better than what grew since.
  void offer(RebuiltMap rebuilt) {
    if (tracker_) tracker_->offer(std::move(rebuilt));
  }

  /// All maps so far, in order; the last one is awake unless the pose is lost.
  [[nodiscard]] const std::vector<MapRecord>& maps() const { return maps_; }

 private:
  [[nodiscard]] ScanResult track(const ScanPointer& scan);
  [[nodiscard]] ScanResult track_with_doubt(const ScanPointer& scan);
  [[nodiscard]] ScanResult track_by_reference(const ScanPointer& scan);
  /// Gives the new map on trial one more scan; true if it has taken over. It takes over from a map that is awake only
  /// once that has explained nothing for a while.
  bool try_new_map(const ScanPointer& scan, const imu::Estimate& before, bool collapsed, ScanResult& result);
  /// What to do with a scan that the active map does not explain; changes the result's state.
  void look_for_a_way_on(const ScanPointer& scan, const imu::Estimate& before, ScanResult& result);
  void fall_asleep(Cause cause);
  /// The way from the last scan that the old map explained to the beginning of the new one.
  [[nodiscard]] GapEdge gap_to_new_map() const;
  void wake_in_new_map();
  void learn_from(const ScanResult& result);
  [[nodiscard]] std::vector<ScanResult> try_to_start(const OdometryConfig& config);
  void refuse_start(const Start& start);
  [[nodiscard]] std::vector<ScanResult> begin_with(Start start);
  /// Results of the scans that fell out of the window before the start was found.
  [[nodiscard]] std::vector<ScanResult> results_before(const Start& start) const;

  OdometryConfig config_;
  sensor::Rig rig_;
  imu::GyroCalibration calibration_;
  sensor::ImuBuffer imu_;                 ///< with what the calibration knows taken out
  std::vector<ScanPointer> waiting_;
  std::vector<Time> dropped_;             ///< ends of the scans that waited for a start too long ago
  std::vector<Cause> why_dropped_;        ///< of each of them
  ScanPointer last_dropped_;              ///< the last of them
  std::optional<Time> next_attempt_;      ///< to start, after one that was refused
  double start_ms_ = 0.0;                 ///< spent on attempts to start
  std::unique_ptr<ScanTracker> tracker_;  ///< of the active map; while that sleeps, the IMU's, ready to return
  std::unique_ptr<Restart> restart_;      ///< a new map on trial, if there is one
  std::optional<Time> unexplained_since_;
  bool was_collapsed_ = false;            ///< the scan before was as small as under a cover
  double last_range_ = 0.0;               ///< median of the scan before [m]
  bool asleep_ = false;
  bool imu_was_silent_ = false;           ///< since the last scan that was believed, for longer than can be bridged
  int num_failed_trials_ = 0;
  std::vector<MapRecord> maps_;
  ReferenceDetection reference_;
};

}  // namespace mmlins::odometry
