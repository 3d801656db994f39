// SPDX-License-Identifier: MIT
#include "mmlins/report/report_data.hpp"

namespace mmlins::report {
namespace {

constexpr std::size_t kMaxTruthPoints = 4000;

ordered_json to_json(const eval::Statistics& s) {
  return {{"rmse", s.rmse}, {"mean", s.mean}, {"median", s.median}, {"max", s.max}};
}

ordered_json evaluation_json(const eval::Evaluation& e) {
  ordered_json json = {{"ate_m", to_json(e.absolute.translation)},
                       {"rotation_deg", to_json(e.absolute.rotation)},
                       {"end_to_end_m", e.end_to_end.translation},
                       {"end_to_end_deg", e.end_to_end.rotation_deg},
                       {"matched", e.num_matched}};
  if (e.per_second) json["rpe_1s_m"] = to_json(e.per_second->translation);
  if (e.per_100m) json["rpe_100m_percent"] = to_json(e.per_100m->translation);
  return json;
}

std::string unit_name(sensor::TimeUnit unit) {
  switch (unit) {
    case sensor::TimeUnit::kAuto: return "?";
    case sensor::TimeUnit::kSeconds: return "s";
    case sensor::TimeUnit::kMilliseconds: return "ms";
    case sensor::TimeUnit::kMicroseconds: return "us";
    case sensor::TimeUnit::kNanoseconds: return "ns";
  }
  return "?";
}

std::string time_words(const io::PointTimeModel& time) {
  if (time.field.empty()) return "none: scans are taken as instantaneous";
  if (time.instantaneous) return fmt::format("{}: the same for all points of a scan", time.field);
  const char* origin = time.origin == io::TimeOrigin::kStamp    ? "after the stamp"
                       : time.origin == io::TimeOrigin::kEpoch ? "since the epoch"
                                                               : "on the sensor's own clock";
  return fmt::format("{} in {}, {}; stamp at the {} of the scan", time.field, unit_name(time.unit), origin,
                     time.stamp == sensor::StampReference::kEnd ? "end" : "start");
}

ordered_json lidar_json(const io::LidarInfo& lidar) {
  std::string fields;
  for (const io::PointField& field : lidar.fields) fields += (fields.empty() ? "" : " ") + field.name;
  return {{"topic", lidar.topic},
          {"type", lidar.type},
          {"fields", fields},
          {"point_time", time_words(lidar.time)},
          {"span_ms", 1e3 * to_seconds(lidar.time.span)},
          {"rate_hz", lidar.rate_hz},
          {"points_per_scan", lidar.points_per_scan},
          {"rings", lidar.num_rings}};
}

}  // namespace

ordered_json truth_json(const ReportInput& input) {
  if (input.truth == nullptr) return nullptr;
  const TruthComparison& truth = *input.truth;
  ordered_json x = ordered_json::array();
  ordered_json y = ordered_json::array();
  const std::size_t step = (truth.path_world.size() + kMaxTruthPoints - 1) / kMaxTruthPoints;
  for (std::size_t i = 0; i < truth.path_world.size(); i += step) {
    x.push_back(rounded(truth.path_world[i].x(), 6));
    y.push_back(rounded(truth.path_world[i].y(), 6));
  }
  return {{"file", truth.file},
          {"path_length_m", truth.trajectory.path_length},
          {"coverage_share", truth.trajectory.coverage.share},
          {"odometry", evaluation_json(truth.odometry)},
          {"trajectory", evaluation_json(truth.trajectory)},
          {"path", {{"x", std::move(x)}, {"y", std::move(y)}}}};
}

ordered_json recording_json(const ReportInput& input) {
  if (input.recording == nullptr) return nullptr;
  const io::RecordingInfo& info = *input.recording;
  ordered_json topics = ordered_json::array();
  for (const io::TopicInfo& topic : info.topics) {
    topics.push_back({{"name", topic.name},
                      {"type", topic.type},
                      {"messages", topic.num_messages},
                      {"rate_hz", topic.timing.rate_hz()},
                      {"gaps", topic.timing.num_gaps},
                      {"longest_gap_s", to_seconds(topic.timing.longest_gap)}});
  }
  ordered_json json = {{"path", info.path}, {"seconds", to_seconds(info.end - info.start)}, {"topics", std::move(topics)}};
  if (info.lidar) json["lidar"] = lidar_json(*info.lidar);
  if (info.imu) {
    json["imu"] = {{"topic", info.imu->topic},
                   {"unit", info.imu->accel_unit == sensor::AccelUnit::kStandardGravity ? "g" : "m/s^2"},
                   {"median_accel_norm", info.imu->median_accel_norm},
                   {"rate_hz", info.imu->rate_hz}};
  }
  return json;
}

}  // namespace mmlins::report
