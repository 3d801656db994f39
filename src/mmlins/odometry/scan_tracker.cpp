// SPDX-License-Identifier: MIT
#include "mmlins/odometry/scan_tracker.hpp"

#include <algorithm>
#include <numbers>

#include "mmlins/base/check.hpp"
#include "mmlins/base/stopwatch.hpp"
#include "mmlins/lidar/voxel_downsample.hpp"
#include "mmlins/odometry/lidar_measurement.hpp"

namespace mmlins::odometry {
namespace {

constexpr double kRadiansPerDegree = std::numbers::pi / 180.0;

std::unique_ptr<spatial::LocalMap> make_map(const LocalMapConfig& config, double range_noise) {
  if (config.kind == MapKind::kKnn) return std::make_unique<spatial::KnnMap>(config.knn, range_noise);
  return std::make_unique<spatial::PlaneMap>(config.planes, range_noise);
}

imu::ImuNoise imu_noise(const ImuModelConfig& config, const sensor::Rig& rig) {
  return {config.gyro_noise_factor * rig.gyro_noise_density, config.accel_noise_factor * rig.accel_noise_density,
          config.bias_walk_factor * rig.gyro_bias_walk, config.bias_walk_factor * rig.accel_bias_walk};
}

struct Evidence {
  bool trusted = false;  ///< matched, or the first scan of the map
  bool imu_gap = false;
};

/// State and cause from what is known of the scan.
void judge(ScanResult& result, const Evidence& evidence) {
  if (!evidence.trusted) {
    result.state = TrackingState::kBridging;
    result.cause = result.num_points == 0 ? Cause::kNoPoints : Cause::kTooFewMatches;
  } else if (result.observability.num_weak() > 0) {
    result.state = TrackingState::kDegraded;
    result.cause = Cause::kWeakDirections;
  } else {
    result.state = TrackingState::kTracking;
    result.cause = evidence.imu_gap ? Cause::kImuGap : Cause::kNone;
  }
}

}  // namespace

ScanTracker::ScanTracker(const OdometryConfig& config, const sensor::Rig& rig, const imu::Estimate& start)
    : config_(config),
      rig_(rig),
      noise_(imu_noise(config.imu, rig)),
      estimate_(start),
      map_(make_map(config.map, rig.range_noise)),
      leaf_(0.5 * (config.scan.min_leaf + config.scan.max_leaf)) {}

ScanResult ScanTracker::track(std::shared_ptr<const sensor::LidarScan> scan, const sensor::ImuBuffer& imu) {
  ScanResult result;
  result.time = scan->end_time;
  result.scan = scan;
  Stopwatch stopwatch;

  // 1. Where did the IMU say we went while the LiDAR was sweeping?
  const Motion motion = propagate_to(scan->end_time, imu);
  result.times.propagate = stopwatch.lap_ms();

  // 2. Straighten the scan with that motion: every point as seen from the IMU at the end of the scan.
  auto cloud_imu = std::make_shared<const lidar::Cloud>(
      lidar::deskew(*scan, motion.propagation.T_odom_imu, rig_.T_imu_lidar(), {rig_.min_range, rig_.max_range}));
  result.times.deskew = stopwatch.lap_ms();

  // 3. Thin it: finely for the map, more coarsely for matching.
  const lidar::Cloud map_points = lidar::voxel_downsample(*cloud_imu, leaf_ * config_.scan.map_leaf_share);
  const lidar::Cloud keypoints = lidar::voxel_downsample(map_points, leaf_);
  leaf_ = lidar::adapt_leaf(leaf_, keypoints.size(), static_cast<std::size_t>(config_.scan.target_keypoints),
                            {config_.scan.min_leaf, config_.scan.max_leaf});
  result.times.downsample = stopwatch.lap_ms();

  // 4. Correct the state against the map.
  LidarMeasurement measurement(keypoints.points, *map_, config_.matching,
                               {rig_.bearing_noise_deg * kRadiansPerDegree, rig_.T_imu_lidar().t});
  const bool first = num_insertions_ == 0 && cloud_imu->size() > 0;
  filter::UpdateReport update;
  update.estimate = motion.propagation.estimate;
  if (!first) {
    update = filter::iterated_update(
        motion.propagation.estimate,
        [&](const imu::NavState& state, const imu::ErrorMatrix& P) { return measurement.linearise(state, P); },
        {.max_iterations = config_.matching.max_iterations, .min_residuals = config_.matching.min_matches});
  }
  result.estimate = estimate_ = update.estimate;
  result.times.update = stopwatch.lap_ms();

  // 5. Say how well that went.
  const bool matched = update.status != filter::UpdateStatus::kTooFewResiduals;
  if (matched) {
    result.observability =
        degeneracy::analyse_observability(measurement.scan_information(estimate_.state), config_.observability);
  }
  result.num_points = static_cast<int>(cloud_imu->size());
  result.num_keypoints = static_cast<int>(keypoints.size());
  result.num_matches = update.information.num_residuals;
  result.iterations = update.iterations;
  result.residual_rms = measurement.residual_rms();
  judge(result, {.trusted = matched || first, .imu_gap = motion.has_gap});
  result.times.health = stopwatch.lap_ms();

  // 6. Grow the map with what was placed. A pose that nothing confirms never writes geometry.
  if ((matched || first) && insertion_is_due()) insert_into_map(map_points);
  result.times.insert = stopwatch.lap_ms();
  result.cloud_imu = std::move(cloud_imu);
  return result;
}

ScanTracker::Motion ScanTracker::propagate_to(Time time, const sensor::ImuBuffer& imu) const {
  const Time now = estimate_.state.time;
  const sensor::ImuSamples samples = imu.covering(now, time);
  MMLINS_CHECK(!samples.empty());
  const Duration silence = imu.longest_gap(now, time);
  Motion motion{imu::propagate(estimate_, samples, noise_), to_seconds(silence) > config_.imu.max_gap};
  // A silence longer than this step was doubted before: it counts only as far as it is new.
  if (motion.has_gap) motion.propagation.estimate.P += imu::doubt_after_gap(to_seconds(std::min(silence, time - now)));
  return motion;
}

bool ScanTracker::insertion_is_due() const {
  if (num_insertions_ < config_.map.initial_insertions) return true;
  const math::SE3 moved = last_insertion_.inverse() * estimate_.state.T_odom_imu();
  return moved.t.norm() >= config_.map.insert_distance ||
         math::so3_log(moved.R).norm() >= config_.map.insert_angle_deg * kRadiansPerDegree;
}

void ScanTracker::insert_into_map(const lidar::Cloud& cloud_imu) {
  if (cloud_imu.size() == 0) return;
  const math::SE3 T_odom_imu = estimate_.state.T_odom_imu();
  std::vector<Eigen::Vector3d> points_odom;
  points_odom.reserve(cloud_imu.size());
  for (const Eigen::Vector3f& p_imu : cloud_imu.points) points_odom.push_back(T_odom_imu * p_imu.cast<double>());
  map_->insert(points_odom, T_odom_imu.t);
  map_->evict_beyond(T_odom_imu.t, config_.map.radius);
  last_insertion_ = T_odom_imu;
  ++num_insertions_;
}

}  // namespace mmlins::odometry
