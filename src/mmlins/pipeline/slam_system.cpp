// SPDX-License-Identifier: MIT
#include "mmlins/pipeline/slam_system.hpp"

#include <cmath>
#include <deque>
#include <optional>
#include <utility>

#include "mmlins/base/log.hpp"
#include "mmlins/base/memory.hpp"
#include "mmlins/base/stopwatch.hpp"
#include "mmlins/keyframe/keyframe_builder.hpp"
#include "mmlins/pipeline/back_end.hpp"

namespace mmlins::pipeline {
namespace {

ScanRecord to_record(const odometry::ScanResult& result, double read_ms) {
  ScanRecord record;
  record.time = result.time;
  record.T_odom_imu = result.estimate.state.T_odom_imu();
  const imu::NavState& state = result.estimate.state;
  record.v_imu = state.R_odom_imu.transpose() * state.v_odom;
  if (result.carried) {
    record.carried = {result.carried->T_odom_imu(), result.carried->R_odom_imu.transpose() * result.carried->v_odom};
  }
  record.imu_was_silent = result.imu_was_silent;
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

/// Systems that ours is compared with know nothing of it.
bool feeds_back(const mapping::MappingConfig& config) {
  const bool is_ours = config.fusion == mapping::FusionKind::kDefault || config.fusion == mapping::FusionKind::kOff;
  return config.enabled && config.rebuild.enabled && is_ours;
}

std::optional<MapRebuilder> rebuilder(const SlamConfig& config, const sensor::Rig& rig) {
  if (!feeds_back(config.mapping)) return std::nullopt;
  return MapRebuilder(config.mapping, config.odometry, rig);
}

class Runner {
 public:
  Runner(const sensor::Rig& rig, const SlamConfig& config, const Observer& observer, atlas::Atlas* atlas)
      : config_(config),
        rig_(rig),
        odometry_(std::in_place, config.odometry, rig),
        builder_(config.mapping.keyframe),
        back_end_(config.mapping, atlas, mapping::make_mapper, rebuilder(config, rig)),
        observer_(observer) {}

  RunResult run(sensor::Dataset& dataset);

 private:
  /// False when there is nothing more to read.
  bool read_one(sensor::Dataset& dataset);
  void process(const SyncedScan& synced);
  void record(const odometry::ScanResult& result);
  /// Makes keyframes for the back end of what the odometry says.
  void hand_on(const odometry::ScanResult& result, const math::SE3& T_map_imu);
  void begin_map(const odometry::MapRecord& map);
  void hand_on(keyframe::Keyframe keyframe, const imu::Estimate& estimate);
  /// The IMU alone has carried the pose since the last scan that was placed.
  void hand_on_bridge(const math::Matrix6d& covariance);
  [[nodiscard]] bool is_far_carried(const math::Matrix6d& covariance) const;
  /// Offers the odometry what the back end has made of a keyframe some time ago, always at the same keyframe.
  void take_back();
  /// Hands on what was seen since the last keyframe.
  void finish_keyframe();
  /// Waits for the back end, and puts everything where it lies in the end.
  void settle();
  void take_from_mapper();
  /// Of all keyframes where they lie in the end; says if some are lost.
  void build_map();

  const SlamConfig& config_;
  const sensor::Rig& rig_;
  SensorSync sync_;
  std::optional<odometry::LidarInertialOdometry> odometry_;  ///< until the last scan is done
  keyframe::KeyframeBuilder builder_;
  imu::Estimate last_placed_;
  std::optional<math::Matrix6d> bridged_;  ///< covariance of the pose that the IMU carries, since the last placed scan
  int latest_map_ = -1;
  std::deque<keyframe::KeyframePointer> latest_;  ///< of the active map, of which the back end may still make something
  BackEnd back_end_;
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
  for (const auto& late : odometry_->finish()) record(late);
  result_.maps = odometry_->maps();
  odometry_.reset();  // what is done next needs the memory
  settle();
  result_.num_late_imu_samples += sync_.num_late_imu_samples();
  result_.num_scans_ahead = sync_.num_scans_ahead();
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
    if (odometry_->add_imu(sample) == sensor::ImuAdmission::kNotLater) ++result_.num_late_imu_samples;
  }
  const auto output = odometry_->add_scan(synced.scan);
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
  ScanRecord record = to_record(result, std::exchange(read_ms_, 0.0));
  record.T_map_imu = result.T_odom_map.inverse() * record.T_odom_imu;
  hand_on(result, record.T_map_imu);
  if (result.map_rebuilt) ++result_.mapping.num_rebuilt;
  result_.scans.push_back(std::move(record));
  if (observer_ && !observer_(result_.scans.back(), progress_)) result_.interrupted = true;
}

void Runner::begin_map(const odometry::MapRecord& map) {
  if (latest_map_ >= 0) {
    finish_keyframe();
    back_end_.add(EndOfMap{odometry_->maps()[static_cast<std::size_t>(latest_map_)]});
  }
  latest_map_ = map.id;
  bridged_.reset();
  latest_.clear();
  mapping::MapBegin begin{map.id, map.T_first_map, std::nullopt};
  if (map.gap && map.gap->is_known) begin.gap_covariance = map.gap->covariance;
  back_end_.add(BeginOfMap{begin, map});
}

void Runner::hand_on(const odometry::ScanResult& result, const math::SE3& T_map_imu) {
  while (latest_map_ < result.map_id) begin_map(odometry_->maps()[static_cast<std::size_t>(latest_map_ + 1)]);
  if (!odometry::is_placed(result.state)) {
    bridged_ = imu::pose_covariance(result.estimate);
    // What was seen until now is handed on at once: it may be long before there is more.
    if (is_far_carried(*bridged_)) finish_keyframe();
    return;
  }
  if (const auto bridged = std::exchange(bridged_, std::nullopt)) hand_on_bridge(*bridged);
  last_placed_ = result.estimate;
  const imu::NavState& state = result.estimate.state;
  std::vector<float> intensities;
  intensities.reserve(result.cloud_imu->size());
  for (const std::uint32_t source : result.cloud_imu->source) intensities.push_back(result.scan->intensities[source]);
  const keyframe::PlacedScan scan{result.map_id, result.time, T_map_imu,
                                  state.R_odom_imu.transpose() * state.gravity_odom.normalized(),
                                  result.cloud_imu->points, intensities};
  if (auto keyframe = builder_.add(scan)) hand_on(std::move(*keyframe), result.estimate);
}

void Runner::hand_on_bridge(const math::Matrix6d& covariance) {
  if (!is_far_carried(covariance)) return;
  finish_keyframe();
  latest_.clear();
  back_end_.add(Bridge{covariance});
}

bool Runner::is_far_carried(const math::Matrix6d& covariance) const {
  // What the IMU carries as well as registration tells is no worse than odometry.
  return std::sqrt(covariance.bottomRightCorner<3, 3>().trace()) >= config_.mapping.loop.confirmed_within;
}

void Runner::finish_keyframe() {
  if (auto last = builder_.finish()) hand_on(std::move(*last), last_placed_);
}

void Runner::hand_on(keyframe::Keyframe keyframe, const imu::Estimate& estimate) {
  result_.mapping.keyframes.push_back({keyframe.time, keyframe.map_id, keyframe.T_map_imu, {}});
  const auto shared = std::make_shared<const keyframe::Keyframe>(std::move(keyframe));
  back_end_.add(NewKeyframe{shared, imu::pose_covariance(estimate)});
  if (!feeds_back(config_.mapping)) return;
  latest_.push_back(shared);
  take_back();
}

void Runner::take_back() {
  const auto after = static_cast<std::size_t>(config_.mapping.rebuild.after);
  if (latest_.size() <= after) return;
  const keyframe::KeyframePointer asked = latest_.front();
  latest_.pop_front();
  auto rebuilt = back_end_.rebuilt_after(asked->id);
  if (!rebuilt || !odometry_) return;
  for (const auto& since : latest_) rebuilt->to_come.push_back(placed_points(since, since->T_map_imu));
  odometry_->offer(std::move(*rebuilt));
}

void Runner::build_map() {
  MappingResult& mapping = result_.mapping;
  result_.map = VoxelMapBuilder(config_.output.map_voxel);
  int num_lost = 0;
  for (int id = 0; id < static_cast<int>(mapping.keyframes.size()); ++id) {
    const KeyframePlace& place = mapping.keyframes[static_cast<std::size_t>(id)];
    const auto keyframe = back_end_.store().load(id);
    if (keyframe) {
      result_.map.add(**keyframe, place.T_world_imu);
    } else if (num_lost++ == 0 && mapping.error.empty()) {
      mapping.error = keyframe.error().message;
    }
  }
  if (num_lost == 0) return;
  log::warning("{} of {} keyframes cannot be read back and are missing from the map; mmlins maps DIR check tells more",
               num_lost, mapping.keyframes.size());
}

void Runner::settle() {
  finish_keyframe();
  if (latest_map_ >= 0) back_end_.add(EndOfMap{result_.maps[static_cast<std::size_t>(latest_map_)]});
  back_end_.finish();
  take_from_mapper();
  return_freed_memory();
  const MappingResult& mapping = result_.mapping;
  build_map();
  std::vector<bool> has_keyframe(result_.maps.size(), false);
  for (const KeyframePlace& place : mapping.keyframes) has_keyframe[static_cast<std::size_t>(place.map_id)] = true;
  std::vector<ScanPlace> scans;
  for (const ScanRecord& r : result_.scans) {
    // The scan with which a map begins is the last of its trial, but has its place in it already: if the map has one.
    const bool begins_map = !scans.empty() && scans.back().map_id != r.map_id && has_keyframe[static_cast<std::size_t>(r.map_id)];
    scans.push_back(
        {r.time, r.map_id, odometry::is_placed(r.state) || begins_map, r.T_map_imu, r.T_odom_imu, r.v_imu, r.carried, r.imu_was_silent});
  }
  const std::vector<math::SE3> poses = world_trajectory(scans, mapping.keyframes, rig_);
  for (std::size_t i = 0; i < poses.size(); ++i) result_.scans[i].T_world_imu = poses[i];
}

void Runner::take_from_mapper() {
  const auto mapper = back_end_.take_mapper();
  MappingResult& mapping = result_.mapping;
  mapping.graph = mapper->map_graph().graph();
  for (const odometry::MapRecord& map : result_.maps) mapping.worlds.push_back(mapper->map_graph().world_of(map.id));
  mapping.closures = mapper->closures();
  mapping.merges = mapper->merges();
  mapping.times = mapper->times();
  mapping.rebuild_ms = back_end_.rebuild_ms();
  mapping.error = back_end_.error();
  for (int id = 0; id < static_cast<int>(mapping.keyframes.size()); ++id) {
    mapping.keyframes[static_cast<std::size_t>(id)].T_world_imu = mapper->map_graph().T_world_keyframe(id);
  }
}

}  // namespace

RunResult run(sensor::Dataset& dataset, const sensor::Rig& rig, const SlamConfig& config, const Observer& observer,
              atlas::Atlas* atlas) {
  RunResult result = Runner(rig, config, observer, atlas).run(dataset);
  return_freed_memory();  // who writes the result needs some, and the keyframes do not any more
  return result;
}

}  // namespace mmlins::pipeline
