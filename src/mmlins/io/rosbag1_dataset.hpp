// SPDX-License-Identifier: MIT
#pragma once
// The measurements in a ROS 1 bag, once it is known which topics to read and how.

#include <cstddef>
#include <string>

#include "mmlins/io/point_cloud2_decode.hpp"
#include "mmlins/io/recording_info.hpp"
#include "mmlins/io/rosbag1/rosbag1_reader.hpp"
#include "mmlins/sensor/dataset.hpp"

namespace mmlins::io {

class Rosbag1Dataset : public sensor::Dataset {
 public:
  /// @param reader        with exactly the two topics selected
  /// @param lidar_offset  added to all LiDAR times
  Rosbag1Dataset(Rosbag1Reader reader, const LidarInfo& lidar, const ImuInfo& imu, Duration lidar_offset);

  [[nodiscard]] Result<sensor::Item> next() override;
  [[nodiscard]] double progress() const override;

 private:
  /// Messages of one topic that could not be used.
  struct Rejected {
    std::string topic;
    std::size_t count = 0;
  };

  [[nodiscard]] Result<sensor::Item> decode_lidar(Bytes message);
  [[nodiscard]] Result<sensor::Item> decode_imu_sample(Bytes message) const;
  void finish();

  Rosbag1Reader reader_;
  std::string lidar_topic_;
  bool is_livox_;
  PointTimeModel time_model_;
  PointCloud2Decoder decoder_;
  Duration lidar_offset_;
  double accel_scale_;  // [m/s^2] in one unit of the recording
  std::size_t num_read_ = 0;
  std::size_t num_total_ = 0;
  Rejected rejected_lidar_;
  Rejected rejected_imu_;
};

}  // namespace mmlins::io
