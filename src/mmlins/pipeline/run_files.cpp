// SPDX-License-Identifier: MIT
#include "mmlins/pipeline/run_files.hpp"

#include <sys/resource.h>

#include <algorithm>
#include <array>
#include <cstdlib>
#include <filesystem>
#include <fstream>
#include <nlohmann/json.hpp>
#include <numeric>
#include <utility>

#include "mmlins/base/text_file.hpp"
#include "mmlins/config/yaml_config.hpp"
#include "mmlins/eval/trajectory_file.hpp"
#include "mmlins/graph/g2o.hpp"
#include "mmlins/io/pcd_file.hpp"
#include "mmlins/pipeline/mapping_files.hpp"
#include "mmlins/pipeline/stages.hpp"

namespace mmlins::pipeline {
namespace {

namespace fs = std::filesystem;
using nlohmann::ordered_json;

std::string health_csv(const RunResult& result) {
  std::string text =
      "time,state,cause,map,points,keypoints,matches,iterations,residual_rms_m,explained,disagreement_m,disagreement_rad,"
      "std_x_m,std_y_m,std_z_m,std_roll_rad,std_pitch_rad,std_yaw_rad,"
      "v_x_m_s,v_y_m_s,v_z_m_s,down_x,down_y,down_z,std_tilt_rad";
  for (const char* block : {"t", "r"}) {
    for (int i = 1; i <= 3; ++i) text += fmt::format(",{0}{1}_std,{0}{1}_noise_share,{0}{1}_x,{0}{1}_y,{0}{1}_z", block, i);
  }
  for (const Stage& stage : kStages) text += fmt::format(",{}_ms", stage.name);
  text += '\n';
  for (const ScanRecord& r : result.scans) {
    text += fmt::format("{},{},{},{},{},{},{},{},{:.6f},{:.3f},{:.4f},{:.5f}", stamp(r.time), to_string(r.state),
                        to_string(r.cause), r.map_id, r.num_points, r.num_keypoints, r.num_matches, r.iterations, r.residual_rms,
                        r.explained, r.disagreement, r.disagreement_rotation);
    for (int i = 0; i < 3; ++i) text += fmt::format(",{:.6g}", r.position_std(i));
    for (int i = 0; i < 3; ++i) text += fmt::format(",{:.6g}", r.rotation_std(i));
    for (int i = 0; i < 3; ++i) text += fmt::format(",{:.4f}", r.v_imu(i));
    for (int i = 0; i < 3; ++i) text += fmt::format(",{:.6f}", r.down_imu(i));
    text += fmt::format(",{:.4g}", r.tilt_std);
    for (const auto* directions : {&r.observability.translation, &r.observability.rotation}) {
      for (const degeneracy::Direction& d : *directions) {
        text += fmt::format(",{:.4g},{:.3f},{:.3f},{:.3f},{:.3f}", d.std, d.noise_share, d.axis.x(), d.axis.y(), d.axis.z());
      }
    }
    for (const Stage& stage : kStages) text += fmt::format(",{:.3f}", stage.of(r));
    text += '\n';
  }
  return text;
}

ordered_json stages_json(const RunResult& result) {
  ordered_json stages;
  for (const Stage& stage : kStages) {
    std::vector<double> ms;
    for (const ScanRecord& r : result.scans) ms.push_back(stage.of(r));
    const StageStatistics s = stage_statistics(std::move(ms));
    stages[stage.name] = {{"mean_ms", s.mean_ms}, {"median_ms", s.median_ms}, {"p99_ms", s.p99_ms}, {"max_ms", s.max_ms}};
  }
  return stages;
}

ordered_json states_json(const RunResult& result) {
  ordered_json states;
  using odometry::TrackingState;
  for (const auto state : {TrackingState::kInitializing, TrackingState::kTracking, TrackingState::kDegraded,
                           TrackingState::kBridging, TrackingState::kLost, TrackingState::kRelocating}) {
    states[std::string(to_string(state))] =
        std::count_if(result.scans.begin(), result.scans.end(), [&](const ScanRecord& r) { return r.state == state; });
  }
  return states;
}

ordered_json maps_json(const RunResult& result) {
  ordered_json maps = ordered_json::array();
  for (const odometry::MapRecord& map : result.maps) {
    ordered_json entry = {{"id", map.id},
                          {"begin", stamp(map.begin)},
                          {"world", result.mapping.worlds[static_cast<std::size_t>(map.id)]},
                          {"began", std::string(to_string(map.beginning))},
                          {"last_believed", stamp(map.last_believed)},
                          {"fell_asleep", std::string(to_string(map.why_ended))}};
    if (map.gap) {
      const math::Vector6d sigma = map.gap->covariance.diagonal().cwiseSqrt();
      entry["gap"] = {{"from_map", map.gap->from_map},
                      {"seconds", to_seconds(map.gap->first - map.gap->last)},
                      {"motion_is_known", map.gap->is_known},
                      {"metres", map.gap->T_last_first.t.norm()},
                      {"std_rotation_rad", sigma.head<3>().maxCoeff()},
                      {"std_position_m", sigma.tail<3>().maxCoeff()}};
    }
    maps.push_back(std::move(entry));
  }
  return maps;
}

ordered_json mapping_json(const RunResult& result) {
  const MappingResult& mapping = result.mapping;
  ordered_json closures;
  using mmlins::mapping::ClosureState;
  for (const auto state : {ClosureState::kRefused, ClosureState::kWaiting, ClosureState::kConfirmed, ClosureState::kCounts,
                           ClosureState::kRejected}) {
    closures[std::string(to_string(state))] = std::count_if(mapping.closures.begin(), mapping.closures.end(),
                                                            [&](const auto& closure) { return closure.state == state; });
  }
  ordered_json seconds;
  for (const BackEndStage& stage : kBackEndStages) seconds[stage.name] = 1e-3 * stage.of(mapping);
  return {{"keyframes", mapping.keyframes.size()},
          {"closures", std::move(closures)},
          {"merges", std::count_if(mapping.merges.begin(), mapping.merges.end(), [](const auto& merge) { return !merge.undone; })},
          {"seconds", std::move(seconds)},
          {"seconds_between_maps", 1e-3 * mapping.times.fusion},
          {"rebuilt_local_maps", mapping.num_rebuilt},
          {"error", mapping.error}};
}

std::string summary_json(const RunResult& result, const RunSource& source, const std::string& config_yaml) {
  const double seconds = recording_seconds(result);
  ordered_json summary;
  summary["mmlins"] = MMLINS_VERSION;
  summary["recording"] = source.recording;
  summary["lidar_topic"] = source.lidar_topic;
  summary["imu_topic"] = source.imu_topic;
  summary["threads"] = source.num_threads;
  summary["scans"] = result.scans.size();
  summary["scans_by_state"] = states_json(result);
  summary["maps"] = maps_json(result);
  summary["mapping"] = mapping_json(result);
  summary["scans_left_out"] = {{"before_imu", result.num_scans_without_imu}, {"not_later", result.num_scans_not_later}};
  summary["scans_ahead_left_out"] = result.num_scans_ahead;
  summary["imu_samples_not_later"] = result.num_late_imu_samples;
  summary["clock_jumps_back"] = result.num_clock_jumps;
  summary["interrupted"] = result.interrupted;
  summary["read_error"] = result.read_error;
  summary["duration_s"] = seconds;
  summary["path_length_m"] = path_length(result);
  summary["map_points"] = result.map.num_points();
  summary["stages"] = stages_json(result);
  summary["wall_s"] = result.wall_seconds;
  summary["real_time_factor"] = seconds > 0.0 ? result.wall_seconds / seconds : 0.0;
  summary["peak_memory_mib"] = peak_memory_mib();
  summary["config"] = config_yaml;
  return summary.dump(2) + "\n";
}

math::Trajectory poses_of(const RunResult& result, math::SE3 ScanRecord::*pose) {
  math::Trajectory trajectory;
  for (const ScanRecord& r : result.scans) trajectory.push_back({r.time, r.*pose});
  return trajectory;
}

}  // namespace

std::string stamp(Time time) {
  const auto ns = to_ns(time);
  return fmt::format("{}.{:09}", ns / 1'000'000'000, ns % 1'000'000'000);
}

Status prepare_folder(const std::string& folder) {
  std::error_code error;
  fs::create_directories(folder, error);
  if (error) return make_error(ErrorCode::kIo, "cannot create the output folder {}: {}", folder, error.message());
  return write_text_file(folder + "/.mmlins-write-test", "").ok()
             ? (fs::remove(folder + "/.mmlins-write-test", error), Status{})
             : Status{make_error(ErrorCode::kIo, "cannot write to the output folder {}; choose another with --out", folder)};
}

Status write_run(const std::string& folder, const RunResult& result, const RunSource& source, const sensor::Rig& rig,
                 const SlamConfig& config) {
  SlamConfig config_copy = config;
  sensor::Rig rig_copy = rig;
  const std::string config_yaml = config::to_yaml(config_copy.fields(), true);
  const std::pair<const char*, std::string> texts[] = {
      {"health.csv", health_csv(result)},
      {"closures.csv", closures_csv(result)},
      {"merges.json", merges_json(result)},
      {"config.yaml", config_yaml},
      {"rig.yaml", config::to_yaml(rig_copy.fields(), true)},
      {"summary.json", summary_json(result, source, config::to_yaml(config_copy.fields(), false))},
  };
  if (Status status = eval::write_tum(folder + "/odometry.tum", poses_of(result, &ScanRecord::T_odom_imu)); !status) return status;
  if (Status status = eval::write_tum(folder + "/trajectory.tum", poses_of(result, &ScanRecord::T_world_imu)); !status) return status;
  if (Status status = io::write_pcd(folder + "/map.pcd", result.map.points_map(), result.map.intensities()); !status) {
    return status;
  }
  // One that does not hold together has no such file; why is told as an error of the back end.
  if (const auto g2o = graph::format_g2o(result.mapping.graph)) {
    if (Status status = write_text_file(folder + "/graph.g2o", *g2o); !status) return status;
  }
  for (const auto& [name, text] : texts) {
    if (Status status = write_text_file(folder + "/" + name, text); !status) return status;
  }
  return {};
}

StageStatistics stage_statistics(std::vector<double> milliseconds) {
  if (milliseconds.empty()) return {};
  std::sort(milliseconds.begin(), milliseconds.end());
  const auto size = milliseconds.size();
  return {std::accumulate(milliseconds.begin(), milliseconds.end(), 0.0) / static_cast<double>(size),
          milliseconds[size / 2], milliseconds[std::min(size - 1, size * 99 / 100)], milliseconds.back()};
}

double path_length(const RunResult& result) {
  double length = 0.0;
  for (std::size_t i = 1; i < result.scans.size(); ++i) {
    length += (result.scans[i].T_odom_imu.t - result.scans[i - 1].T_odom_imu.t).norm();
  }
  return length;
}

double recording_seconds(const RunResult& result) {
  return result.scans.empty() ? 0.0 : to_seconds(result.scans.back().time - result.scans.front().time);
}

double peak_memory_mib() {
  // getrusage would count what the parent held before it became this program.
  std::ifstream status("/proc/self/status");
  for (std::string line; std::getline(status, line);) {
    if (line.starts_with("VmHWM:")) return std::strtod(line.c_str() + 6, nullptr) / 1024.0;
  }
  rusage usage{};
  getrusage(RUSAGE_SELF, &usage);
  return static_cast<double>(usage.ru_maxrss) / 1024.0;
}

}  // namespace mmlins::pipeline
