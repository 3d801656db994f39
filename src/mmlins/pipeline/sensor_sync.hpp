// SPDX-License-Identifier: MIT
#pragma once
// Brings measurements into an order that the odometry can use: a scan waits until the IMU has reached
// its end. Repairs clocks that jump backwards and leaves out scans from the future, so that one bad stamp does
// not end a recording.

#include <deque>
#include <memory>
#include <optional>
#include <vector>

#include "mmlins/sensor/imu_sample.hpp"
#include "mmlins/sensor/lidar_scan.hpp"

namespace mmlins::pipeline {

/// What the odometry gets next: samples first, then the scan that they reach over.
struct SyncedScan {
  sensor::ImuSamples imu;
  std::shared_ptr<const sensor::LidarScan> scan;
};

class SensorSync {
 public:
  void add(const sensor::ImuSample& sample);
  void add(sensor::LidarScan scan);
  /// No more data will come: scans no longer wait for the IMU.
  void finish() { finished_ = true; }

  /// The next scan whose IMU samples are complete, or nothing yet. A scan does not wait for more than a
  /// second of further scans: an IMU that has died must not stop the output.
  [[nodiscard]] std::optional<SyncedScan> next();

  [[nodiscard]] int num_clock_jumps() const { return static_cast<int>(offsets_.size()) - 1; }
  [[nodiscard]] int num_late_imu_samples() const { return num_late_imu_samples_; }
  /// Left out, as their stamps lay far ahead of the IMU and of scans that came later.
  [[nodiscard]] int num_scans_ahead() const { return num_scans_ahead_; }

 private:
  /// The offset among those used so far that brings `time` closest to the newest IMU sample.
  [[nodiscard]] Duration offset_for(Time time) const;
  void drop_scans_from_the_future();

  std::vector<Duration> offsets_{Duration(0)};  ///< added to stamps; the last one is in force for the IMU
  std::optional<Time> newest_imu_;
  Duration imu_period_{0};
  sensor::ImuSamples imu_;
  std::deque<std::shared_ptr<const sensor::LidarScan>> scans_;
  int num_late_imu_samples_ = 0;
  int num_scans_ahead_ = 0;
  bool finished_ = false;
};

}  // namespace mmlins::pipeline
