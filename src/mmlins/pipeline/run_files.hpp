// SPDX-License-Identifier: MIT
#pragma once
// The files of a run. docs/formats.md describes each.

#include <string>

#include "mmlins/pipeline/slam_system.hpp"

namespace mmlins::pipeline {

/// What a run was made from, for summary.json.
struct RunSource {
  std::string recording;
  std::string lidar_topic;
  std::string imu_topic;
  int num_threads = 1;
};

/// All that lies in the folder of a run, but for its atlas. report.html is written by the layer above.
inline constexpr const char* kRunFiles[] = {"odometry.tum", "trajectory.tum", "map.pcd",     "graph.g2o",    "health.csv", "closures.csv",
                                            "merges.json",  "summary.json",   "report.html", "config.yaml", "rig.yaml"};

/// Creates the folder if need be and checks that files can be written there, before anything is computed.
[[nodiscard]] Status prepare_folder(const std::string& folder);

/// Writes odometry.tum, trajectory.tum, map.pcd, graph.g2o, health.csv, closures.csv, merges.json, summary.json, config.yaml and rig.yaml. Each
/// file appears under its name only when it is complete.
[[nodiscard]] Status write_run(const std::string& folder, const RunResult& result, const RunSource& source,
                               const sensor::Rig& rig, const SlamConfig& config);

/// A time as files have it: seconds with nine decimals.
[[nodiscard]] std::string stamp(Time time);

/// Statistics of one stage over all scans.
struct StageStatistics {
  double mean_ms = 0.0;
  double median_ms = 0.0;
  double p99_ms = 0.0;
  double max_ms = 0.0;
};
[[nodiscard]] StageStatistics stage_statistics(std::vector<double> milliseconds);

/// Length of the way along the scan poses [m].
[[nodiscard]] double path_length(const RunResult& result);
/// Time from the first to the last scan [s].
[[nodiscard]] double recording_seconds(const RunResult& result);
/// Most memory that this process has held so far [MiB].
[[nodiscard]] double peak_memory_mib();

}  // namespace mmlins::pipeline
