// SPDX-License-Identifier: MIT
#include <algorithm>
#include <array>

#include "mmlins/pipeline/stages.hpp"
#include "mmlins/report/report_data.hpp"

namespace mmlins::report {
namespace {

using pipeline::kStages;
using pipeline::ScanRecord;
using pipeline::Stage;

constexpr int kNumBins = 40;

std::vector<double> milliseconds_of(const pipeline::RunResult& result, const Stage& stage) {
  std::vector<double> ms;
  for (const ScanRecord& scan : result.scans) ms.push_back(stage.of(scan));
  return ms;
}

ordered_json stages_json(const pipeline::RunResult& result) {
  ordered_json stages;
  for (const Stage& stage : kStages) {
    const auto s = pipeline::stage_statistics(milliseconds_of(result, stage));
    stages[stage.name] = {{"mean_ms", s.mean_ms}, {"median_ms", s.median_ms}, {"p99_ms", s.p99_ms}, {"max_ms", s.max_ms}};
  }
  return stages;
}

ordered_json states_json(const pipeline::RunResult& result) {
  ordered_json states;
  for (int i = 0; i <= static_cast<int>(odometry::TrackingState::kRelocating); ++i) {
    const auto state = static_cast<odometry::TrackingState>(i);
    states[std::string(to_string(state))] = std::count_if(result.scans.begin(), result.scans.end(),
                                                          [&](const ScanRecord& r) { return r.state == state; });
  }
  return states;
}

ordered_json back_end_json(const pipeline::MappingResult& mapping) {
  ordered_json closures;
  for (int i = 0; i <= static_cast<int>(mapping::ClosureState::kRejected); ++i) {
    const auto state = static_cast<mapping::ClosureState>(i);
    closures[std::string(to_string(state))] =
        std::count_if(mapping.closures.begin(), mapping.closures.end(), [&](const auto& c) { return c.state == state; });
  }
  ordered_json seconds;
  for (const pipeline::BackEndStage& stage : pipeline::kBackEndStages) seconds[stage.name] = 1e-3 * stage.of(mapping);
  return {{"keyframes", mapping.keyframes.size()},
          {"closures", std::move(closures)},
          {"merges", std::count_if(mapping.merges.begin(), mapping.merges.end(), [](const auto& merge) { return !merge.undone; })},
          {"seconds", std::move(seconds)},
          {"seconds_between_maps", 1e-3 * mapping.times.fusion},
          {"rebuilt_local_maps", mapping.num_rebuilt}};
}

}  // namespace

ordered_json figures_json(const ReportInput& input) {
  const pipeline::RunResult& result = input.result;
  const double seconds = pipeline::recording_seconds(result);
  const Histogram histogram = histogram_of(milliseconds_of(result, kStages.back()), kNumBins);
  ordered_json figures;
  figures["mmlins"] = MMLINS_VERSION;
  figures["recording"] = input.source.recording;
  figures["lidar_topic"] = input.source.lidar_topic;
  figures["imu_topic"] = input.source.imu_topic;
  figures["threads"] = input.source.num_threads;
  figures["scans"] = result.scans.size();
  figures["scans_by_state"] = states_json(result);
  figures["mapping"] = back_end_json(result.mapping);
  figures["scans_ahead_left_out"] = result.num_scans_ahead;
  figures["scans_left_out"] = {{"before_imu", result.num_scans_without_imu}, {"not_later", result.num_scans_not_later}};
  figures["imu_samples_not_later"] = result.num_late_imu_samples;
  figures["clock_jumps_back"] = result.num_clock_jumps;
  figures["interrupted"] = result.interrupted;
  figures["read_error"] = result.read_error;
  figures["duration_s"] = seconds;
  figures["path_length_m"] = pipeline::path_length(result);
  figures["map_points"] = result.map.num_points();
  figures["stages"] = stages_json(result);
  figures["histogram"] = {{"step_ms", histogram.step}, {"counts", histogram.counts}};
  figures["wall_s"] = result.wall_seconds;
  figures["real_time_factor"] = seconds > 0.0 ? result.wall_seconds / seconds : 0.0;
  figures["peak_memory_mib"] = pipeline::peak_memory_mib();
  return figures;
}

}  // namespace mmlins::report
