// SPDX-License-Identifier: MIT
#include "mmlins/odometry/restart.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <limits>
#include <numbers>
#include <numeric>
#include <utility>

#include "mmlins/imu/frame_change.hpp"
#include "mmlins/initialization/paper_initializer.hpp"
#include "mmlins/odometry/pose_measurement.hpp"

namespace mmlins::odometry {
namespace {

constexpr int kMaxPasses = 6;
// Scans by which is judged what a young map explains: before, it was younger still.
constexpr std::size_t kLatest = 3;
// Between passes; straightening a scan of 0.1 s then changes by 3 mm [m/s].
constexpr double kSettledSpeed = 0.03;
constexpr double kRadiansPerDegree = std::numbers::pi / 180.0;

}  // namespace

math::SE3 with_heading_of(const math::SE3& T_odom_heading, const math::SE3& T_odom_level) {
  // What of the rotation between the two is about z, however the IMU is mounted.
  const math::Matrix3d R = T_odom_heading.R * T_odom_level.R.transpose();
  const double turn = std::atan2(R(1, 0) - R(0, 1), R(0, 0) + R(1, 1));
  return {math::so3_exp(math::Vector3d(0.0, 0.0, turn)) * T_odom_level.R, T_odom_heading.t};
}

Restart::Restart(const OdometryConfig& config, const sensor::Rig& rig, const imu::Estimate& carried,
                 const math::SE3& T_odom_map, Prior prior)
    : config_(config),
      rig_(rig),
      noise_(imu_noise(config.imu, rig)),
      begin_(carried),
      T_odom_map_(T_odom_map),
      prior_(prior),
      tracker_(std::make_unique<ScanTracker>(config, rig, imu::with_pose_taken_for_granted(carried), T_odom_map)) {}

Restart::Progress Restart::add(const Scan& scan, const sensor::ImuBuffer& imu, bool is_collapsed) {
  if (proven_) return follow(scan, imu);
  const Progress progress = prior_ == Prior::kNone ? add_without_prior(scan, imu, is_collapsed)
                                                   : add_with_prior(scan, imu, is_collapsed);
  proven_ = progress == Progress::kProven;
  if (proven_) tracker_->begin_to_doubt();
  return progress;
}

Restart::Progress Restart::follow(const Scan& scan, const sensor::ImuBuffer& imu) {
  const ScanResult result = tracker_->track(scan, imu);
  if (is_placed(result.state)) return Progress::kProven;
  verdict_ = to_string(result.cause);
  return Progress::kFailed;
}

Restart::Progress Restart::add_with_prior(const Scan& scan, const sensor::ImuBuffer& imu, bool is_collapsed) {
  const ScanResult result = tracker_->track(scan, imu);
  if (!is_placed(result.state)) {
    verdict_ = to_string(result.cause);
    return Progress::kFailed;
  }
  scans_.push_back(scan);
  take(result);
  if (config_.initialization.mode == initialization::InitializationMode::kPaper) {
    if (static_cast<int>(poses_.size()) < config_.initialization.window.paper_frames) return Progress::kOnTrial;
    return initialize_as_in_the_paper(imu) ? Progress::kProven : Progress::kFailed;
  }
  const double elapsed = to_seconds(result.time - begin_.state.time);
  if (elapsed < config_.restart.trial) return Progress::kOnTrial;
  if (is_collapsed && !has_seen_motion()) {
    verdict_ = "the scans have collapsed and show no motion";
  } else if (initialize(imu) && explains_enough(is_collapsed)) {
    return Progress::kProven;
  }
  return elapsed < config_.restart.patience ? Progress::kOnTrial : Progress::kFailed;
}

Restart::Progress Restart::add_without_prior(const Scan& scan, const sensor::ImuBuffer& imu, bool is_collapsed) {
  if (is_collapsed) return Progress::kFailed;
  scans_.push_back(scan);
  const double elapsed = to_seconds(scans_.back()->end_time - scans_.front()->start_time);
  if (elapsed < std::min(config_.start.rest_window, config_.start.motion_window)) return Progress::kOnTrial;
  if (next_attempt_ && scan->end_time < *next_attempt_) return Progress::kOnTrial;
  std::unique_ptr<Start> start = find_start(config_, rig_, scans_, imu);
  if (!start) return Progress::kOnTrial;
  verdict_ = start->acceptance.reason;
  next_attempt_ = scan->end_time + from_seconds(config_.start.retry);
  if (!start->acceptance.accepted()) {
    return elapsed < config_.initialization.window.cold_max ? Progress::kOnTrial : Progress::kFailed;
  }
  for (const ScanResult& result : start->results) {
    if (result.state == TrackingState::kBridging) return Progress::kFailed;
  }
  beginning_ = start->at_rest ? MapBeginning::kAtRest : MapBeginning::kInMotion;
  tracker_ = std::move(start->tracker);
  // The new frame is level like odom; heading and place are those that the IMU carried to its first pose.
  const math::SE3 T_start_first = start->prior.state.T_odom_imu();
  const math::SE3 T_odom_first = with_heading_of(begin_.state.T_odom_imu(), T_start_first);
  tracker_->call_the_pose(T_odom_first * T_start_first.inverse() * tracker_->estimate().state.T_odom_imu());
  return Progress::kProven;
}

initialization::Window Restart::window(const sensor::ImuBuffer& imu) const {
  return {poses_, imu.covering(poses_.front().time, poses_.back().time), noise_};
}

bool Restart::initialize(const sensor::ImuBuffer& imu) {
  const imu::Estimate carried =
      imu::propagate(begin_, imu.covering(begin_.state.time, poses_.front().time), noise_).estimate;
  // Scans that were straightened with a wrong velocity give wrong poses, and so a velocity that is only less wrong.
  math::Vector3d v_before = math::Vector3d::Constant(std::numeric_limits<double>::infinity());
  for (int pass = 1;; ++pass) {
    const auto found = initialization::initialize(
        window(imu), initialization::carried_over_prior(carried, poses_.front().T_odom_imu), config_.initialization);
    verdict_ = found.acceptance.reason;
    const math::Vector3d v_found = found.solution.estimate.state.v_odom;
    const bool settled = (v_found - v_before).norm() < kSettledSpeed;
    v_before = v_found;
    if (settled && found.acceptance.accepted()) {
      tracker_->set_estimate(found.solution.estimate);
      return true;
    }
    if (pass == kMaxPasses || found.solution.status != initialization::SolveStatus::kSolved) return false;
    if (!go_over_again(found.solution, imu)) return false;
  }
}

bool Restart::go_over_again(const initialization::MapSolution& solution, const sensor::ImuBuffer& imu) {
  // The solution begins at the end of the first scan; what it says of the velocity there holds at its beginning.
  const imu::NavState then = imu::propagate(begin_, imu.covering(begin_.state.time, poses_.front().time), noise_).estimate.state;
  const imu::NavState& found = solution.states.front();
  imu::Estimate again{begin_.state, solution.estimate.P};
  again.state.v_odom += found.v_odom - then.v_odom;
  again.state.gyro_bias = found.gyro_bias;
  again.state.accel_bias = found.accel_bias;
  again.state.gravity_odom = found.gravity_odom;
  tracker_ = std::make_unique<ScanTracker>(config_, rig_, imu::with_pose_taken_for_granted(again), T_odom_map_);
  poses_.clear();
  explained_.clear();
  for (const Scan& scan : scans_) {
    const ScanResult result = tracker_->track(scan, imu);
    if (!is_placed(result.state)) {
      verdict_ = "the scans no longer match when straightened";
      return false;
    }
    take(result);
  }
  return true;
}

void Restart::take(const ScanResult& result) {
  poses_.push_back(poses_.empty() ? initialization::defining_pose(result.time, result.estimate.state.T_odom_imu())
                                  : measured_pose(result, config_.restart));
  explained_.push_back(result.explained);
}

bool Restart::explains_enough(bool is_collapsed) {
  const std::size_t num = std::min(explained_.size(), kLatest);
  const double share = std::accumulate(explained_.end() - static_cast<std::ptrdiff_t>(num), explained_.end(), 0.0) /
                       static_cast<double>(num);
  if (share >= (is_collapsed ? config_.restart.min_explained_collapsed : config_.restart.min_explained)) return true;
  verdict_ = fmt::format("the new map explains {:.0f} % of the scans", 100.0 * share);
  return false;
}

bool Restart::initialize_as_in_the_paper(const sensor::ImuBuffer& imu) {
  const initialization::PaperSolution found = initialization::solve_paper(window(imu));
  if (found.status != initialization::PaperStatus::kSolved) {
    verdict_ = "the four frames do not determine velocity and gravity";
    return false;
  }
  tracker_->set_estimate(found.estimate);
  return true;
}

bool Restart::has_seen_motion() const {
  const math::SE3 moved = poses_.front().T_odom_imu.inverse() * poses_.back().T_odom_imu;
  return moved.t.norm() > config_.restart.confirming_motion ||
         math::so3_log(moved.R).norm() > config_.restart.confirming_turn_deg * kRadiansPerDegree;
}

}  // namespace mmlins::odometry
