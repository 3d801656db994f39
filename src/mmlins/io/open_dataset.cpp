// SPDX-License-Identifier: MIT
#include "mmlins/io/open_dataset.hpp"

#include <optional>
#include <utility>

#include "mmlins/base/log.hpp"
#include "mmlins/io/probe.hpp"
#include "mmlins/io/ros_message_types.hpp"
#include "mmlins/io/rosbag1_dataset.hpp"
#include "mmlins/io/topic_choice.hpp"
#include "mmlins/io/topic_timing.hpp"

namespace mmlins::io {
namespace {

/// The topics that are used; the rest of what is known stands in RecordingInfo.
struct Examined {
  RecordingInfo info;
  std::vector<std::size_t> used_topics;
};

/// Chooses the topics and looks at their first messages. What stands in the way goes to info.problems.
Result<Examined> examine(Rosbag1Reader& reader, const sensor::Rig& rig) {
  Examined examined;
  RecordingInfo& info = examined.info;
  info.path = reader.path();
  info.start = reader.start_time();
  info.end = reader.end_time();
  info.num_messages = reader.num_messages();
  for (std::size_t i = 0; i < reader.topics().size(); ++i) {
    const auto times = reader.record_times(i);
    if (!times.ok()) return times.error();
    const BagTopic& topic = reader.topics()[i];
    info.topics.push_back({topic.name, topic.type, topic.num_messages, measure_timing(*times, false)});
  }
  const auto add_problem = [&info](const Error& error) {
    if (info.problems.empty() || info.problems.back() != error.message)
      info.problems.push_back(error.message);
  };
  if (const auto topic = choose_lidar_topic(reader, rig); !topic.ok()) {
    add_problem(topic.error());
  } else if (auto lidar = probe_lidar(reader, *topic, rig); !lidar.ok()) {
    add_problem(lidar.error());
  } else {
    info.lidar = std::move(*lidar);
    examined.used_topics.push_back(*topic);
  }
  if (const auto topic = choose_imu_topic(reader, rig); !topic.ok()) {
    add_problem(topic.error());
  } else if (auto imu = probe_imu(reader, *topic, rig); !imu.ok()) {
    add_problem(imu.error());
  } else {
    info.imu = std::move(*imu);
    examined.used_topics.push_back(*topic);
  }
  return examined;
}

/// The stamps of all messages that have a header, for the given topics.
Result<std::vector<std::vector<Time>>> read_stamps(Rosbag1Reader& reader,
                                                   const std::vector<std::size_t>& topics) {
  std::vector<std::vector<Time>> stamps(reader.topics().size());
  if (const Status status = reader.select(topics); !status.ok()) return status.error();
  while (true) {
    const auto message = reader.next();
    if (!message.ok()) return message.error();
    if (!message->has_value()) return stamps;
    ByteReader bytes(Bytes((*message)->data, (*message)->size));
    const Time stamp = bytes.header();
    if (bytes.ok()) stamps[(*message)->topic].push_back(stamp);
  }
}

}  // namespace

Result<OpenedDataset> open_dataset(const std::string& path, const sensor::Rig& rig) {
  auto reader = Rosbag1Reader::open(path);
  if (!reader.ok()) return reader.error();
  auto examined = examine(*reader, rig);
  if (!examined.ok()) return examined.error();
  const RecordingInfo& info = examined->info;
  if (!info.problems.empty()) return Error{ErrorCode::kInvalid, info.problems.front()};
  if (info.lidar->time.field.empty()) {
    log::warning(
        "{}: the points have no time: scans are taken as instantaneous, deskewing is off; "
        "if they have one, name it in time_field of the rig",
        info.lidar->topic);
  }
  if (const Status status = reader->select(examined->used_topics); !status.ok()) return status.error();
  OpenedDataset opened;
  opened.dataset = std::make_unique<Rosbag1Dataset>(std::move(*reader), *info.lidar, *info.imu,
                                                    from_seconds(rig.lidar_time_offset));
  opened.info = std::move(examined->info);
  return opened;
}

Result<RecordingInfo> inspect_recording(const std::string& path, const sensor::Rig& rig) {
  auto reader = Rosbag1Reader::open(path);
  if (!reader.ok()) return reader.error();
  auto examined = examine(*reader, rig);
  if (!examined.ok()) return examined.error();
  RecordingInfo info = std::move(examined->info);
  std::vector<std::size_t> sensors;
  for (std::size_t i = 0; i < info.topics.size(); ++i) {
    if (is_lidar_type(info.topics[i].type) || info.topics[i].type == kImuType) sensors.push_back(i);
  }
  const auto stamps = read_stamps(*reader, sensors);
  if (!stamps.ok()) return stamps.error();
  for (const std::size_t i : sensors) {
    TopicInfo& topic = info.topics[i];
    topic.timing = measure_timing((*stamps)[i], true);
    if (info.lidar && topic.name == info.lidar->topic) info.lidar->rate_hz = topic.timing.rate_hz();
    if (info.imu && topic.name == info.imu->topic) info.imu->rate_hz = topic.timing.rate_hz();
  }
  return info;
}

}  // namespace mmlins::io
