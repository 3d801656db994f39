// SPDX-License-Identifier: MIT
#include "mmlins/odometry/lidar_inertial_odometry.hpp"

#include <utility>

#include "mmlins/base/log.hpp"

namespace mmlins::odometry {

LidarInertialOdometry::LidarInertialOdometry(const OdometryConfig& config, const sensor::Rig& rig)
    : config_(config), rig_(rig) {}

LidarInertialOdometry::Output LidarInertialOdometry::add_scan(ScanPointer scan) {
  Output output;
  if (imu_.empty() || (!tracker_ && scan->start_time < imu_.oldest())) {
    output.admission = ScanAdmission::kNoImu;
    return output;
  }
  const bool later = tracker_ ? scan->end_time > tracker_->estimate().state.time
                              : waiting_.empty() || scan->end_time > waiting_.back()->end_time;
  if (!later) {
    output.admission = ScanAdmission::kNotLater;
    return output;
  }
  if (tracker_) {
    output.results.push_back(tracker_->track(std::move(scan), imu_));
    imu_.forget_before(tracker_->estimate().state.time);
    return output;
  }
  waiting_.push_back(std::move(scan));
  output.results = try_to_start(config_);
  return output;
}

std::vector<ScanResult> LidarInertialOdometry::finish() {
  if (tracker_ || waiting_.empty()) return {};
  OdometryConfig patient = config_;
  patient.start.rest_window = 0.0;
  patient.start.motion_window = 0.0;
  return try_to_start(patient);
}

std::vector<ScanResult> LidarInertialOdometry::try_to_start(const OdometryConfig& config) {
  const double window = to_seconds(waiting_.back()->end_time - waiting_.front()->start_time);
  if (window < std::min(config.start.rest_window, config.start.motion_window)) return {};
  std::unique_ptr<Start> start = find_start(config, rig_, waiting_, imu_);
  if (!start) return {};
  log::info("started {} after {:.1f} s", start->at_rest ? "at rest" : "in motion", window);
  tracker_ = std::move(start->tracker);
  waiting_.clear();
  imu_.forget_before(tracker_->estimate().state.time);
  return std::move(start->results);
}

}  // namespace mmlins::odometry
