// SPDX-License-Identifier: MIT
#pragma once
// What is in a recording and how it was understood.

#include <cstddef>
#include <cstdint>
#include <optional>
#include <string>
#include <vector>

#include "mmlins/base/time.hpp"
#include "mmlins/io/point_field.hpp"
#include "mmlins/io/point_time.hpp"
#include "mmlins/sensor/rig.hpp"

namespace mmlins::io {

/// Spacing of the messages of one topic.
struct TopicTiming {
  bool by_stamp = false;  ///< true: from the stamps in the messages; false: from the times of recording
  Time first;
  Time last;
  Duration median_period{0};  ///< 0 with fewer than two messages
  int num_gaps = 0;           ///< distances of more than three median periods
  Duration longest_gap{0};
  Time longest_gap_start;   ///< the last message before it
  int num_not_forward = 0;  ///< messages whose time is not later than that of the message before

  /// [Hz]; 0 if unknown.
  [[nodiscard]] double rate_hz() const {
    return median_period.count() > 0 ? 1.0 / to_seconds(median_period) : 0.0;
  }
};

struct TopicInfo {
  std::string name;
  std::string type;
  std::size_t num_messages = 0;
  TopicTiming timing;
};

/// The LiDAR topic that is used, judged by its first scans.
struct LidarInfo {
  std::string topic;
  std::string type;
  std::vector<PointField> fields;
  PointTimeModel time;
  double rate_hz = 0.0;               ///< scans per second
  std::size_t points_per_scan = 0;    ///< median of valid points
  int num_rings = 0;                  ///< distinct laser numbers; 0 without such a field
  std::size_t num_scans_sampled = 0;  ///< how many scans this rests on
};

/// The inertial topic that is used, judged by its first samples.
struct ImuInfo {
  std::string topic;
  sensor::AccelUnit accel_unit = sensor::AccelUnit::kMetresPerSecondSquared;
  double median_accel_norm = 0.0;  ///< as recorded, in the unit of the recording
  double rate_hz = 0.0;
};

struct RecordingInfo {
  std::string path;
  Time start;  ///< earliest record time
  Time end;    ///< latest record time
  std::size_t num_messages = 0;
  std::vector<TopicInfo> topics;   ///< in alphabetical order
  std::optional<LidarInfo> lidar;  ///< nothing if no topic could be chosen
  std::optional<ImuInfo> imu;
  std::vector<std::string> problems;  ///< why it cannot be used as it is; empty if it can
};

}  // namespace mmlins::io
