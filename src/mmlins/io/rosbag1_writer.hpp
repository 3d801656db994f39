// SPDX-License-Identifier: MIT
#pragma once
// Recordings as ROS 1 bags, readable by every tool that reads bags: scans as sensor_msgs/PointCloud2,
// inertial samples as sensor_msgs/Imu. The same calls write the same bytes.

#include <cstdint>
#include <map>
#include <string>
#include <vector>

#include "mmlins/base/result.hpp"
#include "mmlins/base/time.hpp"
#include "mmlins/io/rosbag1/rosbag1_raw_writer.hpp"
#include "mmlins/sensor/imu_sample.hpp"
#include "mmlins/sensor/lidar_scan.hpp"

namespace mmlins::io {

/// Write in the order of `record_time`: readers are fastest on such bags. The file appears under its own
/// name when close() succeeds; a writer destroyed before that leaves nothing behind.
class RosbagWriter {
 public:
  /// Errors: the folder is missing or cannot be written to.
  [[nodiscard]] static Result<RosbagWriter> create(const std::string& path);

  /// Stamp: scan.start_time. Fields: x, y, z [m], intensity, time [s after the stamp] as float32, ring as
  /// uint16; without rings the field is left out.
  /// @param record_time  later than the epoch; not before the end of the scan in a realistic recording
  [[nodiscard]] Status write_scan(const std::string& topic, const std::string& frame_id,
                                  const sensor::LidarScan& scan, Time record_time);
  /// Angular rate [rad/s] and specific force [m/s^2]; orientation is marked as unknown.
  [[nodiscard]] Status write_imu(const std::string& topic, const std::string& frame_id,
                                 const sensor::ImuSample& sample, Time record_time);
  /// Completes the file and gives it its name.
  [[nodiscard]] Status close();

 private:
  explicit RosbagWriter(Rosbag1RawWriter writer) : writer_(std::move(writer)) {}

  Rosbag1RawWriter writer_;
  std::map<std::string, std::uint32_t> sequence_;  // per topic: the number of its next message
  std::vector<std::uint8_t> buffer_;               // kept for its capacity
};

}  // namespace mmlins::io
