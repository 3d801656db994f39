// SPDX-License-Identifier: MIT
#include "mmlins/odometry/lidar_inertial_odometry.hpp"

#include <algorithm>
#include <numbers>
#include <utility>

#include "mmlins/base/log.hpp"

namespace mmlins::odometry {
namespace {

/// After so many fruitless trials what the IMU carried is taken to be wrong.
constexpr int kMaxCarriedTrials = 2;

}  // namespace

LidarInertialOdometry::LidarInertialOdometry(const OdometryConfig& config, const sensor::Rig& rig)
    : config_(config), rig_(rig), reference_(config.detector) {}

LidarInertialOdometry::Output LidarInertialOdometry::add_scan(ScanPointer scan) {
  Output output;
  if (imu_.empty() || (!tracker_ && scan->start_time < imu_.oldest())) {
    output.admission = ScanAdmission::kNoImu;
    return output;
  }
  const bool later = tracker_ ? scan->end_time > tracker_->estimate().state.time
                              : waiting_.empty() || scan->end_time > waiting_.back()->end_time;
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
  const Time trial_needs = restart_ ? restart_->needs_imu_since() : result.time;
  imu_.forget_before(std::min(tracker_->needs_imu_since(), trial_needs));
  return result;
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
  if (imu_.longest_gap(before.state.time, result.time) > from_seconds(imu::kLongestStep)) imu_was_silent_ = true;
  if (!asleep_ && imu_was_silent_) fall_asleep(Cause::kImuGap);
  if (!asleep_ && (drift.position > config_.restart.max_drift ||
                   drift.rotation > config_.restart.max_drift_deg * std::numbers::pi / 180.0)) {
    fall_asleep(result.cause);
  }
  if (asleep_) result.state = TrackingState::kLost;
  const bool blind = result.num_keypoints < config_.matching.min_matches;
  const bool collapsed = blind || tracker_->is_collapsed(result);
  // A scan in which a cover comes or goes shows both what is in front of it and what is behind.
  const bool changes = std::exchange(was_collapsed_, collapsed) != collapsed;
  if (blind) unexplained_since_.reset();
  if (blind || changes) {
    num_failed_trials_ = 0;
    restart_.reset();
    return;
  }
  if (!unexplained_since_) unexplained_since_ = result.time;
  if (!asleep_ && result.time - *unexplained_since_ < from_seconds(config_.restart.unexplained)) return;
  try_new_map(scan, before, collapsed, result);
}

bool LidarInertialOdometry::try_new_map(const ScanPointer& scan, const imu::Estimate& before, bool collapsed,
                                        ScanResult& result) {
  if (!restart_) {
    const bool distrusts_imu = imu_was_silent_ || num_failed_trials_ >= kMaxCarriedTrials;
    restart_ = std::make_unique<Restart>(config_, rig_, imu_was_silent_ ? tracker_->estimate() : before,
                                         tracker_->T_odom_map(),
                                         distrusts_imu ? Restart::Prior::kNone : Restart::Prior::kCarried);
  }
  const Restart::Progress progress = restart_->add(scan, imu_, collapsed);
  if (progress == Restart::Progress::kFailed) {
    ++num_failed_trials_;
    restart_.reset();
    return false;
  }
  if (asleep_ && !collapsed) result.state = TrackingState::kRelocating;
  if (progress == Restart::Progress::kOnTrial) return false;
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

void LidarInertialOdometry::wake_in_new_map() {
  const imu::Estimate& last = tracker_->last_trusted();
  const imu::Estimate& first = restart_->begin();
  GapEdge gap{maps_.back().id, last.state.time, first.state.time,
              last.state.T_odom_imu().inverse() * first.state.T_odom_imu(), !imu_was_silent_, first.P.topLeftCorner<6, 6>()};
  math::Matrix6d to_body = math::Matrix6d::Identity();
  to_body.bottomRightCorner<3, 3>() = first.state.R_odom_imu.transpose();
  gap.covariance = to_body * gap.covariance * to_body.transpose();
  const std::string verdict = restart_->verdict();
  const Time now = restart_->tracker().estimate().state.time;
  maps_.push_back({static_cast<int>(maps_.size()), restart_->beginning(), first.state.time, now, Cause::kNone, gap,
                   maps_.back().T_first_map * tracker_->T_odom_map().inverse() * restart_->tracker().T_odom_map()});
  const math::SE3 T_odom_imu = tracker_->estimate().state.T_odom_imu();
  tracker_ = restart_->take();
  tracker_->begin_to_doubt();
  tracker_->call_the_pose(with_heading_of(T_odom_imu, tracker_->estimate().state.T_odom_imu()));
  restart_.reset();
  unexplained_since_.reset();
  asleep_ = false;
  imu_was_silent_ = false;
  num_failed_trials_ = 0;
  log::info("map {} begins at {:.3f} s: {}", maps_.back().id, to_seconds(maps_.back().begin.time_since_epoch()), verdict);
}

std::vector<ScanResult> LidarInertialOdometry::finish() {
  if (tracker_ || waiting_.empty()) return {};
  OdometryConfig patient = config_;
  patient.start.rest_window = 0.0;
  patient.start.motion_window = 0.0;
  return try_to_start(patient);
}

std::vector<ScanResult> LidarInertialOdometry::try_to_start(const OdometryConfig& config) {
  const double window = to_seconds(waiting_.back()->end_time - waiting_.front()->start_time);
  if (window < std::min(config.start.rest_window, config.start.motion_window)) return {};
  std::unique_ptr<Start> start = find_start(config, rig_, waiting_, imu_);
  if (!start) return {};
  log::info("started {} after {:.1f} s", start->at_rest ? "at rest" : "in motion", window);
  tracker_ = std::move(start->tracker);
  tracker_->begin_to_doubt();
  waiting_.clear();
  maps_.push_back({0, start->at_rest ? MapBeginning::kAtRest : MapBeginning::kInMotion, start->results.front().time,
                   start->results.back().time, Cause::kNone, std::nullopt, {}});
  imu_.forget_before(tracker_->needs_imu_since());
  return std::move(start->results);
}

}  // namespace mmlins::odometry
