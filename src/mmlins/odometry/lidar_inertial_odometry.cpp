// SPDX-License-Identifier: MIT
#include "mmlins/odometry/lidar_inertial_odometry.hpp"

#include <algorithm>
#include <iterator>
#include <numbers>
#include <utility>

#include "mmlins/base/log.hpp"
#include "mmlins/base/stopwatch.hpp"
#include "mmlins/imu/hindsight.hpp"

namespace mmlins::odometry {
namespace {

/// After so many fruitless trials what the IMU carried is taken to be wrong.
constexpr int kMaxCarriedTrials = 2;
/// From one scan to the next the median range of what is not covered keeps at least this share.
constexpr double kGradual = 0.7;

imu::GyroCalibrationConfig calibration_config(const ImuModelConfig& config, const sensor::Rig& rig) {
  const imu::ImuNoise noise = imu_noise(config, rig);
  return {config.gyro_scale_deviation, rig.gyro_turn_on_bias, noise.gyro_bias_walk, noise.gyro};
}

}  // namespace

LidarInertialOdometry::LidarInertialOdometry(const OdometryConfig& config, const sensor::Rig& rig)
    : config_(config), rig_(rig), calibration_(calibration_config(config.imu, rig)), reference_(config.detector) {}

LidarInertialOdometry::Output LidarInertialOdometry::add_scan(ScanPointer scan) {
  Output output;
  if (imu_.empty() || (!tracker_ && scan->start_time < imu_.oldest())) {
    output.admission = ScanAdmission::kNoImu;
    return output;
  }
  const ScanPointer& last = waiting_.empty() ? last_dropped_ : waiting_.back();
  const bool later = tracker_ ? scan->end_time > tracker_->estimate().state.time : !last || scan->end_time > last->end_time;
  if (!later) {
    output.admission = ScanAdmission::kNotLater;
    return output;
  }
  if (tracker_) {
    output.results.push_back(track(scan));
    return output;
  }
  waiting_.push_back(std::move(scan));
  output.results = try_to_start(config_);
  return output;
}

ScanResult LidarInertialOdometry::track(const ScanPointer& scan) {
  ScanResult result = config_.detector == DetectorKind::kDefault ? track_with_doubt(scan) : track_by_reference(scan);
  result.map_id = maps_.back().id;
  learn_from(result);
  const Time trial_needs = restart_ ? restart_->needs_imu_since() : result.time;
  const Time calibration_needs = calibration_.needs_imu_since().value_or(result.time);
  imu_.forget_before(std::min({tracker_->needs_imu_since(), trial_needs, calibration_needs}));
  return result;
}

void LidarInertialOdometry::learn_from(const ScanResult& result) {
  // Attitudes that lean on the gyroscope itself would only confirm what it says.
  if (result.state != TrackingState::kTracking || result.cause != Cause::kNone) {
    calibration_.interrupt();
  } else {
    calibration_.add(result.time, result.estimate.state.R_odom_imu, imu_);
  }
}

ScanResult LidarInertialOdometry::track_with_doubt(const ScanPointer& scan) {
  const imu::Estimate before = tracker_->estimate();
  ScanResult result = tracker_->track(scan, imu_);
  if (!is_placed(result.state)) {
    look_for_a_way_on(scan, before, result);
    return result;
  }
  if (asleep_) log::info("back in map {}", maps_.back().id);
  asleep_ = false;
  was_collapsed_ = false;
  last_range_ = result.median_range;
  imu_was_silent_ = false;
  num_failed_trials_ = 0;
  restart_.reset();
  unexplained_since_.reset();
  maps_.back().last_believed = result.time;
  maps_.back().why_ended = Cause::kNone;
  return result;
}

void LidarInertialOdometry::look_for_a_way_on(const ScanPointer& scan, const imu::Estimate& before, ScanResult& result) {
  const ScanTracker::Drift drift = tracker_->drift();
  result.imu_was_silent = imu_.longest_gap(before.state.time, result.time) > from_seconds(imu::kLongestStep);
  imu_was_silent_ = imu_was_silent_ || result.imu_was_silent;
  if (!asleep_ && imu_was_silent_) fall_asleep(Cause::kImuGap);
  if (!asleep_ && (drift.position > config_.restart.max_drift ||
                   drift.rotation > config_.restart.max_drift_deg * std::numbers::pi / 180.0)) {
    fall_asleep(result.cause);
  }
  const bool returning = result.state == TrackingState::kRelocating;
  if (asleep_ && !returning) result.state = TrackingState::kLost;
  const bool blind = result.num_keypoints < config_.matching.min_matches;
  const bool collapsed = blind || tracker_->is_collapsed(result);
  // A scan in which a cover comes or goes shows both what is in front of it and what is behind. It comes from one scan
  // to the next; who drives into a narrow place sees the walls draw near.
  const double range_before = std::exchange(last_range_, result.median_range);
  const bool abrupt = std::min(range_before, result.median_range) < kGradual * std::max(range_before, result.median_range);
  const bool changes = std::exchange(was_collapsed_, collapsed) != collapsed && abrupt;
  // Under a cover nothing tells of the old map yet: while the IMU may still carry the pose, it is worth waiting for.
  const bool waits_for_sight = blind || (collapsed && !asleep_);
  if (waits_for_sight) unexplained_since_.reset();
  // Nor may a trial begin with the state before such a scan: it was wrong.
  if (waits_for_sight || changes || result.was_deceived) {
    num_failed_trials_ = 0;
    restart_.reset();
    return;
  }
  if (!unexplained_since_ || returning) unexplained_since_ = result.time;
  try_new_map(scan, before, collapsed, result);
}

bool LidarInertialOdometry::try_new_map(const ScanPointer& scan, const imu::Estimate& before, bool collapsed,
                                        ScanResult& result) {
  Stopwatch stopwatch;
  const bool returning = result.state == TrackingState::kRelocating;
  if (!restart_) {
    const bool distrusts_imu = imu_was_silent_ || (asleep_ && num_failed_trials_ >= kMaxCarriedTrials);
    restart_ = std::make_unique<Restart>(config_, rig_, imu_was_silent_ ? tracker_->estimate() : before,
                                         tracker_->T_odom_map(),
                                         distrusts_imu ? Restart::Prior::kNone : Restart::Prior::kCarried);
  }
  const Restart::Progress progress = restart_->add(scan, imu_, collapsed);
  result.times.start += stopwatch.lap_ms();
  if (progress == Restart::Progress::kFailed) {
    // Under a cover a failed trial says nothing of the IMU.
    if (asleep_ && !collapsed) ++num_failed_trials_;
    restart_.reset();
    return false;
  }
  if (asleep_ && !collapsed) result.state = TrackingState::kRelocating;
  // The old map comes first, as long as it explains what is seen.
  if (progress == Restart::Progress::kOnTrial || returning) return false;
  if (!asleep_ && unexplained_since_) {
    // Where the pose cannot be far off, what the map does not explain is in its way rather than elsewhere.
    const bool near = tracker_->drift().position < config_.trust.doubtful_drift;
    const double wait = near ? config_.restart.unexplained_near : config_.restart.unexplained;
    if (result.time - *unexplained_since_ < from_seconds(wait)) return false;
  }
  if (!asleep_) fall_asleep(result.cause);
  result.state = TrackingState::kRelocating;
  wake_in_new_map();
  result.estimate = tracker_->estimate();
  result.T_odom_map = tracker_->T_odom_map();
  return true;
}

ScanResult LidarInertialOdometry::track_by_reference(const ScanPointer& scan) {
  const imu::Estimate before = tracker_->estimate();
  ScanResult result =
      asleep_ ? tracker_->carry(scan, imu_, maps_.back().why_ended) : tracker_->track(scan, imu_);
  if (asleep_) {
    result.state = TrackingState::kLost;
    if (result.num_keypoints < config_.matching.min_matches) {
      restart_.reset();
    } else if (try_new_map(scan, before, false, result)) {
      reference_.restart();
    }
  } else {
    maps_.back().last_believed = result.time;
    const sensor::ImuSamples samples = imu_.covering(before.state.time, result.time);
    if (reference_.step(before.state, samples, result.unweighted_information)) fall_asleep(Cause::kWeakDirections);
  }
  return result;
}

void LidarInertialOdometry::fall_asleep(Cause cause) {
  asleep_ = true;
  maps_.back().why_ended = cause;
  log::warning("map {} falls asleep at {:.3f} s: {}", maps_.back().id,
               to_seconds(tracker_->estimate().state.time.time_since_epoch()), to_string(cause));
}

GapEdge LidarInertialOdometry::gap_to_new_map() const {
  const imu::Estimate& last = tracker_->last_trusted();
  const imu::Estimate& first = restart_->begin();
  GapEdge gap{maps_.back().id, last.state.time, first.state.time,
              last.state.T_odom_imu().inverse() * first.state.T_odom_imu(), !imu_was_silent_, imu::pose_covariance(first)};
  // What was found without regard to what was carried does not tell how the two hang together.
  if (!gap.is_known || !restart_->has_used_prior()) return gap;
  const imu::Estimate& now = restart_->tracker().estimate();
  const auto carried = imu::in_hindsight(tracker_->estimate(), now);
  if (!carried) {
    log::warning("what map {} found contradicts what the IMU carried: nothing is known of the way to it", maps_.size());
    gap.is_known = false;
    return gap;
  }
  const math::SE3 T_now_first = now.state.T_odom_imu().inverse() * first.state.T_odom_imu();
  gap.T_last_first = last.state.T_odom_imu().inverse() * carried->state.T_odom_imu() * T_now_first;
  const math::Matrix6d to_first = math::adjoint(T_now_first.inverse());
  gap.covariance = to_first * imu::pose_covariance(*carried) * to_first.transpose();
  return gap;
}

void LidarInertialOdometry::wake_in_new_map() {
  const GapEdge gap = gap_to_new_map();
  const math::SE3 T_map_last = tracker_->T_odom_map().inverse() * tracker_->last_trusted().state.T_odom_imu();
  const math::SE3 T_map_first = restart_->tracker().T_odom_map().inverse() * restart_->begin().state.T_odom_imu();
  const std::string verdict = restart_->verdict();
  const Time now = restart_->tracker().estimate().state.time;
  maps_.push_back({static_cast<int>(maps_.size()), restart_->beginning(), gap.first, now, Cause::kNone, gap,
                   maps_.back().T_first_map * T_map_last * gap.T_last_first * T_map_first.inverse()});
  const math::SE3 T_odom_imu = tracker_->estimate().state.T_odom_imu();
  tracker_ = restart_->take();
  tracker_->call_the_pose(with_heading_of(T_odom_imu, tracker_->estimate().state.T_odom_imu()));
  restart_.reset();
  unexplained_since_.reset();
  asleep_ = false;
  imu_was_silent_ = false;
  num_failed_trials_ = 0;
  log::info("map {} begins at {:.3f} s: {}", maps_.back().id, to_seconds(maps_.back().begin.time_since_epoch()), verdict);
}

std::vector<ScanResult> LidarInertialOdometry::finish() {
  if (tracker_) return {};
  if (waiting_.empty() && last_dropped_) {  // there must be a scan to begin with
    waiting_.push_back(std::move(last_dropped_));
    dropped_.pop_back();
    why_dropped_.pop_back();
  }
  if (waiting_.empty()) return {};
  OdometryConfig patient = config_;
  patient.start.rest_window = 0.0;
  patient.start.motion_window = 0.0;
  Stopwatch stopwatch;
  const std::unique_ptr<Start> start = find_start(patient, rig_, waiting_, imu_);
  start_ms_ += stopwatch.lap_ms();
  const bool accepted = start->acceptance.accepted();
  if (!accepted) refuse_start(*start);
  std::vector<ScanResult> results = begin_with(std::move(*start));
  if (accepted) return results;
  // Poses are given, but nothing is claimed of them.
  maps_.back().why_ended = Cause::kNoStart;
  for (ScanResult& result : results) {
    result.state = TrackingState::kLost;
    if (result.cause != Cause::kNoPoints) result.cause = Cause::kNoStart;
  }
  return results;
}

std::vector<ScanResult> LidarInertialOdometry::try_to_start(const OdometryConfig& config) {
  const Time now = waiting_.back()->end_time;
  const double window = to_seconds(now - waiting_.front()->start_time);
  if (window < std::min(config.start.rest_window, config.start.motion_window)) return {};
  if (next_attempt_ && now < *next_attempt_) return {};
  Stopwatch stopwatch;
  std::unique_ptr<Start> start = find_start(config, rig_, waiting_, imu_);
  start_ms_ += stopwatch.lap_ms();
  if (!start) return {};
  if (start->acceptance.accepted()) return begin_with(std::move(*start));
  refuse_start(*start);
  next_attempt_ = now + from_seconds(config.start.retry);
  // Scans that nothing was seen in are no use at the beginning of the next window.
  std::size_t blind = 0;
  while (blind < start->results.size() && !is_placed(start->results[blind].state)) ++blind;
  const Time oldest = now - from_seconds(config.initialization.window.cold_max);
  while (!waiting_.empty() && (blind > 0 || waiting_.front()->start_time < oldest)) {
    blind -= std::min<std::size_t>(blind, 1);
    dropped_.push_back(waiting_.front()->end_time);
    why_dropped_.push_back(waiting_.front()->size() == 0 ? Cause::kNoPoints : Cause::kNoStart);
    last_dropped_ = std::move(waiting_.front());
    waiting_.erase(waiting_.begin());
  }
  return {};
}

void LidarInertialOdometry::refuse_start(const Start& start) {
  log::info("no start at {:.3f} s: {}", to_seconds(waiting_.back()->end_time.time_since_epoch()), start.acceptance.reason);
}

std::vector<ScanResult> LidarInertialOdometry::begin_with(Start start) {
  if (start.acceptance.accepted()) {
    const Time first = dropped_.empty() ? waiting_.front()->start_time : dropped_.front();
    log::info("started {} after {:.1f} s: {}", start.at_rest ? "at rest" : "in motion",
              to_seconds(waiting_.back()->end_time - first), start.acceptance.reason);
  }
  std::vector<ScanResult> results = results_before(start);
  maps_.push_back({0, start.at_rest ? MapBeginning::kAtRest : MapBeginning::kInMotion, start.results.front().time,
                   start.results.back().time, Cause::kNone, std::nullopt, {}});
  std::move(start.results.begin(), start.results.end(), std::back_inserter(results));
  // The results of the start tell of a part of that time themselves.
  double told = 0.0;
  for (const ScanResult& result : results) told += result.times.total();
  results.back().times.start += std::max(0.0, std::exchange(start_ms_, 0.0) - told);
  tracker_ = std::move(start.tracker);
  tracker_->begin_to_doubt();
  waiting_.clear();
  dropped_.clear();
  why_dropped_.clear();
  last_dropped_.reset();
  imu_.forget_before(tracker_->needs_imu_since());
  return results;
}

std::vector<ScanResult> LidarInertialOdometry::results_before(const Start& start) const {
  std::vector<ScanResult> results;
  for (const imu::Estimate& estimate : carried_back(start.prior, dropped_, imu_, imu_noise(config_.imu, rig_))) {
    ScanResult result;
    result.time = estimate.state.time;
    result.estimate = estimate;
    result.state = TrackingState::kLost;
    result.cause = why_dropped_[results.size()];
    results.push_back(std::move(result));
  }
  return results;
}

}  // namespace mmlins::odometry
