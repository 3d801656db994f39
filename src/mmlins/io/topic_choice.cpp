// SPDX-License-Identifier: MIT
#include "mmlins/io/topic_choice.hpp"

#include <functional>
#include <string_view>
#include <vector>

#include "mmlins/io/ros_message_types.hpp"

namespace mmlins::io {
namespace {

/// One kind of sensor, in words for messages to the user.
struct Kind {
  std::string_view sensor;
  std::string_view types;
  std::string_view rig_key;
  bool (*is_type)(std::string_view);
};

constexpr Kind kLidar{"LiDAR", "sensor_msgs/PointCloud2 or Livox CustomMsg", "lidar_topic", is_lidar_type};
constexpr Kind kImu{"IMU", "sensor_msgs/Imu", "imu_topic",
                    [](std::string_view type) { return type == kImuType; }};

std::string list_of(const std::vector<BagTopic>& topics, const std::vector<std::size_t>& chosen) {
  std::string list;
  for (const std::size_t i : chosen)
    list += (list.empty() ? "" : ", ") + topics[i].name + " (" + topics[i].type + ")";
  return list.empty() ? "nothing" : list;
}

Result<std::size_t> choose(const Rosbag1Reader& reader, const Kind& kind, const std::string& wanted) {
  const auto& topics = reader.topics();
  std::vector<std::size_t> all;
  std::vector<std::size_t> candidates;
  for (std::size_t i = 0; i < topics.size(); ++i) {
    if (topics[i].num_messages == 0) continue;
    all.push_back(i);
    if (!kind.is_type(topics[i].type)) continue;
    if (topics[i].name == wanted) return i;
    candidates.push_back(i);
  }
  if (all.empty()) return make_error(ErrorCode::kInvalid, "{}: the bag holds no messages", reader.path());
  if (candidates.empty()) {
    return make_error(ErrorCode::kInvalid, "{}: no {} topic (type {}); the bag holds {}", reader.path(),
                      kind.sensor, kind.types, list_of(topics, all));
  }
  if (!wanted.empty()) {
    return make_error(ErrorCode::kNotFound,
                      "{}: no messages of the {} topic {}; set {} in the rig to one of: {}", reader.path(),
                      kind.sensor, wanted, kind.rig_key, list_of(topics, candidates));
  }
  if (candidates.size() > 1) {
    return make_error(ErrorCode::kInvalid, "{}: {} {} topics; set {} in the rig to one of: {}", reader.path(),
                      candidates.size(), kind.sensor, kind.rig_key, list_of(topics, candidates));
  }
  return candidates.front();
}

}  // namespace

Result<std::size_t> choose_lidar_topic(const Rosbag1Reader& reader, const sensor::Rig& rig) {
  return choose(reader, kLidar, rig.lidar_topic);
}

Result<std::size_t> choose_imu_topic(const Rosbag1Reader& reader, const sensor::Rig& rig) {
  return choose(reader, kImu, rig.imu_topic);
}

}  // namespace mmlins::io
