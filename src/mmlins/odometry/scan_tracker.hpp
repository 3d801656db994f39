// SPDX-License-Identifier: MIT
#pragma once
// The steady state of the odometry: one scan after the other against one local map, from a given start.

#include <memory>

#include "mmlins/odometry/odometry_config.hpp"
#include "mmlins/odometry/scan_result.hpp"
#include "mmlins/sensor/imu_buffer.hpp"
#include "mmlins/sensor/rig.hpp"
#include "mmlins/spatial/local_map.hpp"

namespace mmlins::odometry {

class ScanTracker {
 public:
  /// Starts with an empty map at `start`.
  ScanTracker(const OdometryConfig& config, const sensor::Rig& rig, const imu::Estimate& start);

  /// Propagate, straighten, match, correct, grow the map.
  /// @param scan  must end later than the current state
  /// @param imu   must hold samples from the current state to the end of the scan
  [[nodiscard]] ScanResult track(std::shared_ptr<const sensor::LidarScan> scan, const sensor::ImuBuffer& imu);

  [[nodiscard]] const imu::Estimate& estimate() const { return estimate_; }

 private:
  struct Motion {
    imu::Propagation propagation;
    bool has_gap = false;  ///< the IMU was silent for longer than it may be
  };
  [[nodiscard]] Motion propagate_to(Time time, const sensor::ImuBuffer& imu) const;
  [[nodiscard]] bool insertion_is_due() const;
  void insert_into_map(const lidar::Cloud& cloud_imu);

  OdometryConfig config_;
  sensor::Rig rig_;
  imu::ImuNoise noise_;
  imu::Estimate estimate_;
  std::unique_ptr<spatial::LocalMap> map_;
  double leaf_;
  int num_insertions_ = 0;
  math::SE3 last_insertion_;
};

}  // namespace mmlins::odometry
