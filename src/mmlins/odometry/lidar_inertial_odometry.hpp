// SPDX-License-Identifier: MIT
#pragma once
// The odometry as its users see it: IMU samples and scans go in, one result per scan comes out. The
// first results wait until the start has been found; after that none does.

#include <vector>

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

  [[nodiscard]] sensor::ImuAdmission add_imu(const sensor::ImuSample& sample) { return imu_.add(sample); }

  struct Output {
    ScanAdmission admission = ScanAdmission::kAccepted;
    std::vector<ScanResult> results;  ///< none while the start is sought, then all that waited
  };
  /// Takes a scan. The IMU should have been given up to its end; where it has not, its last reading holds.
  [[nodiscard]] Output add_scan(ScanPointer scan);

  /// No more scans will come: starts with what there is, if it has not started yet.
  [[nodiscard]] std::vector<ScanResult> finish();

 private:
  [[nodiscard]] std::vector<ScanResult> try_to_start(const OdometryConfig& config);

  OdometryConfig config_;
  sensor::Rig rig_;
  sensor::ImuBuffer imu_;
  std::vector<ScanPointer> waiting_;
  std::unique_ptr<ScanTracker> tracker_;
};

}  // namespace mmlins::odometry
