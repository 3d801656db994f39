// SPDX-License-Identifier: MIT
#include "mmlins/io/rosbag1_dataset.hpp"

#include <utility>

#include "mmlins/base/log.hpp"
#include "mmlins/io/imu_decode.hpp"
#include "mmlins/io/livox_decode.hpp"
#include "mmlins/io/ros_message_types.hpp"
#include "mmlins/io/to_scan.hpp"

namespace mmlins::io {
namespace {

constexpr double kStandardGravity = 9.80665;  // [m/s^2]

}  // namespace

Rosbag1Dataset::Rosbag1Dataset(Rosbag1Reader reader, const LidarInfo& lidar, const ImuInfo& imu,
                               Duration lidar_offset)
    : reader_(std::move(reader)),
      lidar_topic_(lidar.topic),
      is_livox_(is_livox_type(lidar.type)),
      time_model_(lidar.time),
      decoder_(lidar.time.field, nanoseconds_per(lidar.time.unit)),
      lidar_offset_(lidar_offset),
      accel_scale_(imu.accel_unit == sensor::AccelUnit::kStandardGravity ? kStandardGravity : 1.0),
      rejected_lidar_{lidar.topic},
      rejected_imu_{imu.topic} {
  for (const BagTopic& topic : reader_.topics()) {
    if (topic.name == lidar.topic || topic.name == imu.topic) num_total_ += topic.num_messages;
  }
}

Result<sensor::Item> Rosbag1Dataset::next() {
  while (true) {
    const auto message = reader_.next();
    if (!message.ok()) return message.error();
    if (!message->has_value()) {
      finish();
      return sensor::Item(sensor::EndOfData{});
    }
    ++num_read_;
    const RawMessage& raw = **message;
    const Bytes bytes(raw.data, raw.size);
    const bool is_lidar = reader_.topics()[raw.topic].name == lidar_topic_;
    auto item = is_lidar ? decode_lidar(bytes) : decode_imu_sample(bytes);
    if (item.ok()) return item;
    Rejected& rejected = is_lidar ? rejected_lidar_ : rejected_imu_;
    if (rejected.count++ == 0) {
      log::warning("{}: skipped a message, {:.3f} s into the recording: {}", rejected.topic,
                   to_seconds(raw.record_time - reader_.start_time()), item.error().message);
    }
  }
}

double Rosbag1Dataset::progress() const {
  return num_total_ == 0 ? 1.0 : static_cast<double>(num_read_) / static_cast<double>(num_total_);
}

Result<sensor::Item> Rosbag1Dataset::decode_lidar(Bytes message) {
  auto cloud = is_livox_ ? decode_livox(message) : decoder_.decode(message);
  if (!cloud.ok()) return cloud.error();
  return sensor::Item(to_scan(std::move(*cloud), time_model_, lidar_offset_));
}

Result<sensor::Item> Rosbag1Dataset::decode_imu_sample(Bytes message) const {
  auto sample = decode_imu(message);
  if (!sample.ok()) return sample.error();
  if (!sample->gyro.allFinite() || !sample->accel.allFinite()) {
    return make_error(ErrorCode::kInvalid, "angular rate or acceleration is not finite");
  }
  sample->accel *= accel_scale_;
  return sensor::Item(*sample);
}

/// Says how much was left out, once.
void Rosbag1Dataset::finish() {
  for (Rejected* rejected : {&rejected_lidar_, &rejected_imu_}) {
    if (rejected->count > 1) log::warning("{}: skipped {} messages in all", rejected->topic, rejected->count);
    rejected->count = 0;
  }
}

}  // namespace mmlins::io
