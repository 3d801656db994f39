// SPDX-License-Identifier: MIT
#pragma once
// A new map on trial: started in motion with what the IMU carried through the gap, and believed only after it has
// proved itself for a while.

#include <memory>
#include <string>

#include "mmlins/odometry/scan_tracker.hpp"

namespace mmlins::odometry {

class Restart {
 public:
  /// @param carried     where the IMU is taken to be; its pose begins the new map
  /// @param T_odom_map  of the map before, whose coordinates the new one continues
  Restart(const OdometryConfig& config, const sensor::Rig& rig, const imu::Estimate& carried, const math::SE3& T_odom_map);

  enum class Progress { kOnTrial, kProven, kFailed };
  /// @param is_collapsed  whether the scan is as small as under a cover
  [[nodiscard]] Progress add(const std::shared_ptr<const sensor::LidarScan>& scan, const sensor::ImuBuffer& imu,
                             bool is_collapsed);

  /// Why the trial failed, or has not been passed yet.
  [[nodiscard]] const std::string& verdict() const { return verdict_; }
  [[nodiscard]] const imu::Estimate& begin() const { return begin_; }
  [[nodiscard]] const ScanTracker& tracker() const { return *tracker_; }
  [[nodiscard]] std::unique_ptr<ScanTracker> take() { return std::move(tracker_); }

 private:
  /// Empty if the new map may be believed.
  [[nodiscard]] std::string objection(double elapsed, bool is_collapsed) const;
  /// Whether the scans themselves saw the robot move by a good deal.
  [[nodiscard]] bool has_seen_motion() const;

  RestartConfig config_;
  imu::Estimate begin_;
  std::unique_ptr<ScanTracker> tracker_;
  std::string verdict_;
};

}  // namespace mmlins::odometry
