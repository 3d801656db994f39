// SPDX-License-Identifier: MIT
#include "mmlins/pipeline/slam_system.hpp"

#include <utility>

#include "mmlins/base/log.hpp"
#include "mmlins/base/stopwatch.hpp"

namespace mmlins::pipeline {
namespace {

ScanRecord to_record(const odometry::ScanResult& result, double read_ms) {
  ScanRecord record;
  record.time = result.time;
  record.T_odom_imu = result.estimate.state.T_odom_imu();
  const imu::NavState& state = result.estimate.state;
  record.v_imu = state.R_odom_imu.transpose() * state.v_odom;
  record.down_imu = state.R_odom_imu.transpose() * state.gravity_odom.normalized();
  record.tilt_std = imu::tilt_deviation(result.estimate);
  record.state = result.state;
  record.cause = result.cause;
  record.num_points = result.num_points;
  record.num_keypoints = result.num_keypoints;
  record.num_matches = result.num_matches;
  record.iterations = result.iterations;
  record.residual_rms = result.residual_rms;
  record.explained = result.explained;
  record.disagreement = result.disagreement;
  record.disagreement_rotation = result.disagreement_rotation;
  record.map_id = result.map_id;
  record.position_std = result.estimate.P.diagonal().segment<3>(imu::kPosition).cwiseSqrt();
  record.rotation_std = result.estimate.P.diagonal().segment<3>(imu::kRotation).cwiseSqrt();
  record.observability = result.observability;
  record.read_ms = read_ms;
  record.times = result.times;
  return record;
}

class Runner {
 public:
  Runner(const sensor::Rig& rig, const SlamConfig& config, const Observer& observer)
      : odometry_(config.odometry, rig), observer_(observer) {
    result_.map = VoxelMapBuilder(config.output.map_voxel);
  }

  RunResult run(sensor::Dataset& dataset);

 private:
  /// False when there is nothing more to read.
  bool read_one(sensor::Dataset& dataset);
  void process(const SyncedScan& synced);
  void record(const odometry::ScanResult& result);

  SensorSync sync_;
  odometry::LidarInertialOdometry odometry_;
  const Observer& observer_;
  RunResult result_;
  double read_ms_ = 0.0;
  double progress_ = 0.0;
};

RunResult Runner::run(sensor::Dataset& dataset) {
  Stopwatch whole;
  Stopwatch stopwatch;
  bool more = true;
  while (more && !result_.interrupted) {
    more = read_one(dataset);
    if (!more) sync_.finish();
    progress_ = dataset.progress();
    read_ms_ += stopwatch.lap_ms();
    for (auto synced = sync_.next(); synced && !result_.interrupted; synced = sync_.next()) {
      process(*synced);
      stopwatch.lap_ms();
    }
  }
  for (const auto& late : odometry_.finish()) record(late);
  result_.maps = odometry_.maps();
  result_.num_late_imu_samples += sync_.num_late_imu_samples();
  result_.num_clock_jumps = sync_.num_clock_jumps();
  result_.wall_seconds = 1e-3 * whole.lap_ms();
  return std::move(result_);
}

bool Runner::read_one(sensor::Dataset& dataset) {
  Result<sensor::Item> item = dataset.next();
  if (!item) {
    result_.read_error = item.error().message;
    return false;
  }
  if (std::holds_alternative<sensor::EndOfData>(*item)) return false;
  if (auto* sample = std::get_if<sensor::ImuSample>(&*item)) {
    sync_.add(*sample);
  } else {
    sync_.add(std::move(std::get<sensor::LidarScan>(*item)));
  }
  return true;
}

void Runner::process(const SyncedScan& synced) {
  for (const sensor::ImuSample& sample : synced.imu) {
    if (odometry_.add_imu(sample) == sensor::ImuAdmission::kNotLater) ++result_.num_late_imu_samples;
  }
  const auto output = odometry_.add_scan(synced.scan);
  if (output.admission == odometry::ScanAdmission::kNoImu && result_.num_scans_without_imu++ == 0) {
    log::warning("the scan at {:.3f} s is older than the first IMU sample and is left out",
                 to_seconds(synced.scan->end_time.time_since_epoch()));
  }
  if (output.admission == odometry::ScanAdmission::kNotLater && result_.num_scans_not_later++ == 0) {
    log::warning("the scan at {:.3f} s is not later than the one before and is left out",
                 to_seconds(synced.scan->end_time.time_since_epoch()));
  }
  for (const auto& scan : output.results) record(scan);
}

void Runner::record(const odometry::ScanResult& result) {
  const auto& map = odometry_.maps()[static_cast<std::size_t>(result.map_id)];
  ScanRecord record = to_record(result, std::exchange(read_ms_, 0.0));
  record.T_map_imu = map.T_first_map * result.T_odom_map.inverse() * record.T_odom_imu;
  if (odometry::is_placed(result.state)) result_.map.add(result, record.T_map_imu);
  result_.scans.push_back(std::move(record));
  if (observer_ && !observer_(result_.scans.back(), progress_)) result_.interrupted = true;
}

}  // namespace

RunResult run(sensor::Dataset& dataset, const sensor::Rig& rig, const SlamConfig& config, const Observer& observer) {
  return Runner(rig, config, observer).run(dataset);
}

}  // namespace mmlins::pipeline
