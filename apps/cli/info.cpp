// SPDX-License-Identifier: MIT
// mmlins info: what is in a recording, and how `run` would understand it.

#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <memory>
#include <nlohmann/json.hpp>
#include <string>
#include <vector>

#include "commands.hpp"
#include "mmlins/config/yaml_config.hpp"
#include "mmlins/io/open_dataset.hpp"

namespace mmlins::cli {
namespace {

using Json = nlohmann::ordered_json;

struct InfoOptions {
  std::string recording;
  std::string rig;
  bool json = false;
};

const char* type_name(io::FieldType type) {
  constexpr std::array kNames = {"unknown", "int8",    "uint8",   "int16", "uint16", "int32",
                                 "uint32",  "float32", "float64", "int64", "uint64"};
  const auto index = static_cast<std::size_t>(type);
  return index < kNames.size() ? kNames[index] : kNames[0];
}

const char* unit_name(sensor::TimeUnit unit) {
  switch (unit) {
    case sensor::TimeUnit::kMilliseconds:
      return "ms";
    case sensor::TimeUnit::kMicroseconds:
      return "us";
    case sensor::TimeUnit::kNanoseconds:
      return "ns";
    default:
      return "s";
  }
}

const char* origin_name(io::TimeOrigin origin) {
  switch (origin) {
    case io::TimeOrigin::kEpoch:
      return "absolute";
    case io::TimeOrigin::kOwnClock:
      return "own clock";
    default:
      return "relative";
  }
}

const char* stamp_name(sensor::StampReference stamp) {
  return stamp == sensor::StampReference::kEnd ? "end" : "start";
}
const char* accel_name(sensor::AccelUnit unit) {
  return unit == sensor::AccelUnit::kStandardGravity ? "g" : "m/s^2";
}

double seconds_between(Time from, Time to) { return to_seconds(to - from); }

// ---- JSON ----------------------------------------------------------------------------------------

Json gaps_json(const io::TopicTiming& timing, Time start) {
  Json json{{"count", timing.num_gaps}, {"longest_s", to_seconds(timing.longest_gap)}};
  json["longest_begins_at_s"] =
      timing.num_gaps > 0 ? Json(seconds_between(start, timing.longest_gap_start)) : Json();
  return json;
}

Json topic_json(const io::TopicInfo& topic, Time start) {
  return {{"name", topic.name},
          {"type", topic.type},
          {"messages", topic.num_messages},
          {"rate_hz", topic.timing.rate_hz()},
          {"timed_by", topic.timing.by_stamp ? "stamp" : "record time"},
          {"gaps", gaps_json(topic.timing, start)},
          {"not_forward", topic.timing.num_not_forward}};
}

Json lidar_json(const io::LidarInfo& lidar) {
  Json fields = Json::array();
  for (const auto& field : lidar.fields) {
    fields.push_back({{"name", field.name}, {"type", type_name(field.type)}, {"offset", field.offset}});
  }
  Json time;  // null: the points have no time
  if (!lidar.time.field.empty()) {
    time = {{"field", lidar.time.field},
            {"unit", unit_name(lidar.time.unit)},
            {"reference", origin_name(lidar.time.origin)},
            {"stamp", stamp_name(lidar.time.stamp)},
            {"instantaneous", lidar.time.instantaneous},
            {"span_s", to_seconds(lidar.time.span)}};
  }
  return {{"topic", lidar.topic},
          {"type", lidar.type},
          {"fields", fields},
          {"time", time},
          {"scan_rate_hz", lidar.rate_hz},
          {"points_per_scan", lidar.points_per_scan},
          {"rings", lidar.num_rings}};
}

Json to_json(const io::RecordingInfo& info) {
  Json topics = Json::array();
  for (const auto& topic : info.topics) topics.push_back(topic_json(topic, info.start));
  Json json{{"recording", info.path},
            {"start_ns", to_ns(info.start)},
            {"end_ns", to_ns(info.end)},
            {"duration_s", seconds_between(info.start, info.end)},
            {"messages", info.num_messages},
            {"topics", topics},
            {"lidar", Json()},
            {"imu", Json()},
            {"problems", info.problems}};
  if (info.lidar) json["lidar"] = lidar_json(*info.lidar);
  if (info.imu) {
    json["imu"] = {{"topic", info.imu->topic},
                   {"rate_hz", info.imu->rate_hz},
                   {"accel_unit", accel_name(info.imu->accel_unit)},
                   {"median_accel_norm", info.imu->median_accel_norm}};
  }
  return json;
}

// ---- text ----------------------------------------------------------------------------------------

std::string gaps_text(const io::TopicTiming& timing, Time start) {
  if (timing.num_gaps == 0) return "0";
  return fmt::format("{}, longest {:.3f} s at {:.3f} s", timing.num_gaps, to_seconds(timing.longest_gap),
                     seconds_between(start, timing.longest_gap_start));
}

void print_topics(const io::RecordingInfo& info) {
  std::size_t name_width = 5;
  std::size_t type_width = 4;
  for (const auto& topic : info.topics) {
    name_width = std::max(name_width, topic.name.size());
    type_width = std::max(type_width, topic.type.size());
  }
  fmt::print("\n{:<{}}  {:<{}}  {:>9}  {:>9}  {}\n", "topic", name_width, "type", type_width, "messages",
             "rate [Hz]", "gaps (over 3 periods)");
  for (const auto& topic : info.topics) {
    fmt::print("{:<{}}  {:<{}}  {:>9}  {:>9.2f}  {}", topic.name, name_width, topic.type, type_width,
               topic.num_messages, topic.timing.rate_hz(), gaps_text(topic.timing, info.start));
    if (topic.timing.num_not_forward > 0) fmt::print("; {} stamps not forward", topic.timing.num_not_forward);
    fmt::print("\n");
  }
}

std::string time_text(const io::PointTimeModel& time) {
  if (time.field.empty()) return "none: scans are taken as instantaneous, no deskewing";
  std::string text = fmt::format("field {} [{}], ", time.field, unit_name(time.unit));
  switch (time.origin) {
    case io::TimeOrigin::kStamp:
      text += "relative to the stamp of the cloud";
      break;
    case io::TimeOrigin::kEpoch:
      text += "absolute";
      break;
    case io::TimeOrigin::kOwnClock:
      text += "on the sensor's own clock, moved to the stamp of the cloud";
      break;
  }
  if (time.instantaneous) return text + "; the same for all points of a scan: no deskewing";
  return text + fmt::format("; stamp at scan {}; scans last {:.2f} ms", stamp_name(time.stamp),
                            1e3 * to_seconds(time.span));
}

void print_lidar(const io::LidarInfo& lidar) {
  std::string fields;
  for (const auto& field : lidar.fields) {
    fields += fmt::format("{}{} {}", fields.empty() ? "" : ", ", field.name, type_name(field.type));
  }
  if (fields.empty()) fields = "those of " + lidar.type;
  fmt::print("\nLiDAR     {}\n  scans   {:.2f} Hz, {} points", lidar.topic, lidar.rate_hz,
             lidar.points_per_scan);
  if (lidar.num_rings > 0) fmt::print(", {} ring{}", lidar.num_rings, lidar.num_rings == 1 ? "" : "s");
  fmt::print("\n  fields  {}\n  time    {}\n", fields, time_text(lidar.time));
}

void print_imu(const io::ImuInfo& imu) {
  fmt::print("\nIMU       {}\n  rate    {:.2f} Hz\n  accel   in {} (median length {:.3f})\n", imu.topic,
             imu.rate_hz, accel_name(imu.accel_unit), imu.median_accel_norm);
}

void print_use(const io::RecordingInfo& info, const sensor::Rig& rig, bool has_rig) {
  if (!info.problems.empty()) {
    fmt::print("\nrun       cannot use this recording as it is:\n");
    for (const auto& problem : info.problems) fmt::print("  {}\n", problem);
    return;
  }
  const auto& p = rig.p_imu_lidar;
  const auto& q = rig.q_imu_lidar_xyzw;
  const bool deskews = !info.lidar->time.field.empty() && !info.lidar->time.instantaneous;
  fmt::print("\nrun       uses {} and {}, {} deskewing\n", info.lidar->topic, info.imu->topic,
             deskews ? "with" : "without");
  fmt::print("  LiDAR on the IMU: p_imu_lidar [{}, {}, {}] m, q_imu_lidar_xyzw [{}, {}, {}, {}]{}\n", p[0],
             p[1], p[2], q[0], q[1], q[2], q[3], has_rig ? "" : " (no --rig given)");
}

void print_text(const io::RecordingInfo& info, const sensor::Rig& rig, bool has_rig) {
  fmt::print("recording {}\n  lasts   {:.3f} s, from {:.3f} to {:.3f}\n  holds   {} messages\n", info.path,
             seconds_between(info.start, info.end), to_seconds(info.start.time_since_epoch()),
             to_seconds(info.end.time_since_epoch()), info.num_messages);
  if (!info.topics.empty()) print_topics(info);
  if (info.lidar) print_lidar(*info.lidar);
  if (info.imu) print_imu(*info.imu);
  print_use(info, rig, has_rig);
}

int run_info(const InfoOptions& options) {
  sensor::Rig rig;
  if (!options.rig.empty()) {
    if (const Status status = config::apply_yaml_file(rig.fields(), options.rig); !status.ok())
      return fail(status.error());
    if (const Status status = sensor::validate(rig, options.rig); !status.ok()) return fail(status.error());
  }
  const auto info = io::inspect_recording(options.recording, rig);
  if (!info.ok()) return fail(info.error());
  if (info->num_messages == 0) return fail(make_error(ErrorCode::kInvalid, "{}", info->problems.front()));
  if (options.json) {
    fmt::print("{}\n", to_json(*info).dump(2, ' ', false, Json::error_handler_t::replace));
  } else {
    print_text(*info, rig, !options.rig.empty());
  }
  return 0;
}

}  // namespace

void add_info(CLI::App& program, int& exit_code) {
  auto options = std::make_shared<InfoOptions>();
  CLI::App* command = program.add_subcommand("info", "what is in a recording, and what run would use of it");
  command->add_option("recording", options->recording, "ROS 1 bag")->required();
  command->add_option("--rig", options->rig, "YAML file that describes the sensors");
  command->add_flag("--json", options->json, "print as JSON");
  command->callback([options, &exit_code] { exit_code = run_info(*options); });
}

}  // namespace mmlins::cli
