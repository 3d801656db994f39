// SPDX-License-Identifier: MIT
#include "mmlins/odometry/scan_tracker.hpp"

#include <Eigen/Eigenvalues>
#include <algorithm>
#include <cmath>
#include <numbers>
#include <utility>

#include "mmlins/base/check.hpp"
#include "mmlins/base/stopwatch.hpp"
#include "mmlins/degeneracy/disagreement.hpp"
#include "mmlins/degeneracy/soft_treatment.hpp"
#include "mmlins/imu/frame_change.hpp"
#include "mmlins/lidar/voxel_downsample.hpp"
#include "mmlins/odometry/lidar_measurement.hpp"

namespace mmlins::odometry {
namespace {

constexpr double kRadiansPerDegree = std::numbers::pi / 180.0;
/// However slow the sensor is: a wrong place explains one scan by chance, hardly so many in a row.
constexpr int kScansOfATrial = 5;

double largest_deviation(const imu::ErrorMatrix& P, int block) {
  const Eigen::SelfAdjointEigenSolver<math::Matrix3d> solver(P.block<3, 3>(block, block),
                                                             Eigen::EigenvaluesOnly);
  return std::sqrt(std::max(0.0, solver.eigenvalues()(2)));
}

/// Median range of the cloud, from a part of its points [m].
double median_range(const lidar::Cloud& cloud) {
  constexpr std::size_t kStride = 16;
  if (cloud.size() == 0) return 0.0;
  std::vector<float> squared;
  squared.reserve(cloud.size() / kStride + 1);
  for (std::size_t i = 0; i < cloud.size(); i += kStride) squared.push_back(cloud.points[i].squaredNorm());
  const auto middle = squared.begin() + static_cast<std::ptrdiff_t>(squared.size() / 2);
  std::nth_element(squared.begin(), middle, squared.end());
  return std::sqrt(*middle);
}

/// How far the update moved the pose, against the doubt of the prediction. The floor keeps a prediction that
/// is sure of itself from calling the LiDAR's own errors a contradiction [rad], [m].
double return_chi2(const imu::Estimate& updated, const imu::Estimate& predicted, const math::Matrix6d& H) {
  constexpr double kRotationFloor = 0.01;
  constexpr double kPositionFloor = 0.05;
  math::Matrix6d P = predicted.P.topLeftCorner<6, 6>();
  P.diagonal().head<3>().array() += kRotationFloor * kRotationFloor;
  P.diagonal().tail<3>().array() += kPositionFloor * kPositionFloor;
  return degeneracy::innovation_chi2(imu::minus(updated.state, predicted.state).head<6>(), P, H);
}

ScanResult result_of(const std::shared_ptr<const sensor::LidarScan>& scan) {
  ScanResult result;
  result.time = scan->end_time;
  result.scan = scan;
  return result;
}

void set_state(ScanResult& result, const Verdict& verdict, bool has_imu_gap) {
  result.cause = verdict.cause;
  if (!verdict.trusted) {
    result.state = TrackingState::kBridging;
  } else if (result.observability.num_weak() > 0) {
    result.state = TrackingState::kDegraded;
    result.cause = Cause::kWeakDirections;
  } else {
    result.state = TrackingState::kTracking;
    result.cause = has_imu_gap ? Cause::kImuGap : Cause::kNone;
  }
}

}  // namespace

imu::ImuNoise imu_noise(const ImuModelConfig& config, const sensor::Rig& rig) {
  return {config.gyro_noise_factor * rig.gyro_noise_density,
          config.accel_noise_factor * rig.accel_noise_density, config.bias_walk_factor * rig.gyro_bias_walk,
          config.bias_walk_factor * rig.accel_bias_walk};
}

ScanTracker::ScanTracker(const OdometryConfig& config, const sensor::Rig& rig, const imu::Estimate& start,
                         const math::SE3& T_odom_map)
    : config_(config),
      rig_(rig),
      noise_(imu_noise(config.imu, rig)),
      estimate_(start),
      last_trusted_(start),
      T_odom_map_(T_odom_map),
      map_{make_local_map(config.map, rig.range_noise), {}},
      judge_(config.trust),
      agreement_(config.trust, noise_, from_seconds(config.imu.max_gap)),
      leaf_(0.5 * (config.scan.min_leaf + config.scan.max_leaf)) {}

ScanResult ScanTracker::track(std::shared_ptr<const sensor::LidarScan> scan, const sensor::ImuBuffer& imu) {
  ScanResult result = result_of(scan);
  Stopwatch stopwatch;

  // 1. Where did the IMU say we went while the LiDAR was sweeping?
  const Motion carried = propagate_to(estimate_, scan->end_time, imu);
  const Motion motion = trial_ ? propagate_to(trial_->estimate, scan->end_time, imu) : carried;
  result.carried = carried.propagation.estimate.state;
  result.times.propagate = stopwatch.lap_ms();

  // 2. Straighten the scan with that motion, and thin it.
  const Prepared prepared = prepare(*scan, motion, result.times);
  stopwatch.lap_ms();

  // 3. Correct the state against the map.
  const Match matched = match(prepared, motion.propagation.estimate);
  result.num_points = static_cast<int>(prepared.cloud_imu->size());
  result.num_keypoints = static_cast<int>(prepared.keypoints.size());
  result.num_matches = matched.update.information.num_residuals;
  result.iterations = matched.update.iterations;
  result.residual_rms = matched.residual_rms;
  result.observability = matched.observability;
  result.unweighted_information = matched.unweighted;
  result.pull = {matched.update.linearised_at, matched.update.information.H, matched.update.information.b};
  result.explained = static_cast<double>(result.num_matches) / std::max(1, result.num_keypoints);
  result.median_range = median_range(*prepared.cloud_imu);
  result.times.update = stopwatch.lap_ms() - matched.analysis_ms;

  // 4. Is that to be believed?
  const bool on_trial = is_far_off(carried.propagation.estimate) &&
                        !(trial_ && trial_->num_scans >= kScansOfATrial &&
                          result.time - trial_->since >= from_seconds(config_.restart.trial));
  const Verdict verdict = judge(matched, carried, imu, on_trial, result);
  set_state(result, verdict, motion.has_gap);
  result.times.health = stopwatch.lap_ms() + matched.analysis_ms;

  // 5. Grow the map with what was placed. A pose that nothing confirms never writes geometry.
  if (!verdict.trusted) {
    trial_.reset();
    postponed_.reset();
  } else if (on_trial) {
    trial_ = Trial{matched.update.estimate, trial_ ? trial_->since : result.time, trial_ ? trial_->num_scans + 1 : 1};
    result.state = TrackingState::kRelocating;
  } else {
    trial_.reset();
    const bool returns = is_bridging_;
    believe(matched.update.estimate, carried.propagation.estimate);
    leaf_ = lidar::adapt_leaf(leaf_, prepared.keypoints.size(),
                              static_cast<std::size_t>(config_.scan.target_keypoints),
                              {config_.scan.min_leaf, config_.scan.max_leaf});
    if (postponed_) insert_into_map(*std::exchange(postponed_, std::nullopt));
    grow_map(prepared.map_points, returns, judge_.is_explained_as_usual(result.explained));
    consider_offer(prepared, result);
  }
  result.estimate = estimate_;
  result.T_odom_map = T_odom_map_;
  result.cloud_imu = prepared.cloud_imu;
  result.times.insert = stopwatch.lap_ms();
  return result;
}

ScanResult ScanTracker::carry(std::shared_ptr<const sensor::LidarScan> scan, const sensor::ImuBuffer& imu,
                              Cause cause) {
  ScanResult result = result_of(scan);
  Stopwatch stopwatch;
  const Motion motion = propagate_to(estimate_, scan->end_time, imu);
  result.times.propagate = stopwatch.lap_ms();
  const Prepared prepared = prepare(*scan, motion, result.times);
  result.num_points = static_cast<int>(prepared.cloud_imu->size());
  result.num_keypoints = static_cast<int>(prepared.keypoints.size());
  result.median_range = median_range(*prepared.cloud_imu);
  result.cloud_imu = prepared.cloud_imu;
  set_state(result, {false, cause}, motion.has_gap);
  estimate_ = motion.propagation.estimate;
  is_bridging_ = true;
  offered_.reset();
  result.estimate = estimate_;
  result.T_odom_map = T_odom_map_;
  return result;
}

void ScanTracker::begin_to_doubt() {
  doubts_ = true;
  agreement_.clear();
}

void ScanTracker::set_estimate(const imu::Estimate& estimate) {
  MMLINS_CHECK(estimate.state.time == estimate_.state.time);
  estimate_ = last_trusted_ = estimate;
  agreement_.clear();
  agreement_.add(estimate_);
}

ScanTracker::Prepared ScanTracker::prepare(const sensor::LidarScan& scan, const Motion& motion,
                                           StageTimes& times) const {
  Stopwatch stopwatch;
  Prepared prepared;
  // Every point as seen from the IMU at the end of the scan.
  prepared.cloud_imu = std::make_shared<const lidar::Cloud>(lidar::deskew(
      scan, motion.propagation.T_odom_imu, rig_.T_imu_lidar(), {rig_.min_range, rig_.max_range}));
  times.deskew = stopwatch.lap_ms();
  prepared.map_points = lidar::voxel_downsample(*prepared.cloud_imu, leaf_ * config_.scan.map_leaf_share);
  prepared.keypoints = lidar::voxel_downsample(prepared.map_points, leaf_);
  times.downsample = stopwatch.lap_ms();
  return prepared;
}

ScanTracker::Match ScanTracker::match(const Prepared& prepared, const imu::Estimate& prior) const {
  Match result;
  result.update.estimate = prior;
  result.is_first = num_insertions_ == 0 && prepared.cloud_imu->size() > 0;
  if (result.is_first) return result;
  const PlacedMap map(*map_.map, (T_odom_map_ * map_.T_map_cells).inverse());
  const BeamNoise noise{rig_.bearing_noise_deg * kRadiansPerDegree, rig_.T_imu_lidar().t};
  LidarMeasurement measurement(prepared.keypoints.points, map, config_.matching, noise);
  // Who returns from afar has a long way to the right place, and half of it would be believed as firmly.
  const bool from_afar = !trial_ && is_far_off(prior);
  // What is covered is refused anyway.
  const bool searches = from_afar && !judge_.has_collapsed({prior.state.time, static_cast<int>(prepared.cloud_imu->size()),
                                                            median_range(*prepared.cloud_imu)});
  const auto found = searches ? search_return(prepared.keypoints, prior, map, config_.matching, noise) : std::nullopt;
  const int max_iterations = config_.matching.max_iterations * (from_afar ? kPatienceFromAfar : 1);
  // What the scan determines is settled once, where the IMU predicts the pose: it must not flicker from
  // iteration to iteration.
  bool is_analysed = false;
  result.update = filter::iterated_update(
      prior,
      [&](const imu::NavState& state, const imu::ErrorMatrix& P) {
        filter::PoseInformation information = measurement.linearise(state, P);
        if (information.num_residuals < config_.matching.min_matches) return information;
        if (!std::exchange(is_analysed, true)) {
          Stopwatch stopwatch;
          result.observability =
              degeneracy::analyse_observability(measurement.scan_information(state), config_.observability);
          result.analysis_ms = stopwatch.lap_ms();
        }
        // The planes of a map that has just begun are all doubtful: nothing could start without them.
        if (!config_.matching.soften_weak_directions || !judge_.knows_the_usual()) return information;
        const auto soft =
            degeneracy::soften({information.H, information.b}, result.observability, config_.observability);
        information.H = soft.H;
        information.b = soft.b;
        return information;
      },
      {.max_iterations = max_iterations, .min_residuals = config_.matching.min_matches},
      found ? &found->start : nullptr);
  result.ambiguous = found && (!found->covered || fits_elsewhere(result.update.estimate.state.p_odom, found->rivals,
                                                               result.observability));
  result.has_update = result.update.status != filter::UpdateStatus::kTooFewResiduals;
  if (!result.has_update) result.observability = {};
  if (result.has_update && config_.detector != DetectorKind::kDefault) {
    result.unweighted = measurement.unweighted_information(result.update.estimate.state);
  }
  result.residual_rms = measurement.residual_rms();
  return result;
}

bool ScanTracker::is_far_off(const imu::Estimate& predicted) const {
  if (!doubts_ || config_.detector != DetectorKind::kDefault) return false;
  return is_bridging_ && drift_of(predicted).position > config_.trust.doubtful_drift;
}

Verdict ScanTracker::judge(const Match& match, const Motion& carried, const sensor::ImuBuffer& imu, bool on_trial,
                           ScanResult& result) {
  estimate_ = carried.propagation.estimate;
  if (match.is_first) return {true, Cause::kNone};
  Evidence evidence{result.time,
                    result.num_points,
                    result.median_range,
                    match.has_update,
                    result.explained,
                    result.residual_rms,
                    drift().position,
                    0.0,
                    false,
                    match.ambiguous,
                    on_trial};
  // While the start is sought, and in the systems that ours is compared with, every match is believed.
  if (!doubts_ || config_.detector != DetectorKind::kDefault) {
    if (match.has_update) judge_.learn(evidence);
    is_bridging_ = !match.has_update;
    if (is_bridging_) offered_.reset();
    return {match.has_update, match.has_update         ? Cause::kNone
                              : result.num_points == 0 ? Cause::kNoPoints
                                                       : Cause::kTooFewMatches};
  }
  std::optional<Disagreement> disagreement;
  if (match.has_update) {
    evidence.return_chi2 = return_chi2(match.update.estimate, estimate_, match.update.information.H);
    disagreement = agreement_.compare(match.update.estimate, imu);
  }
  if (disagreement) {
    result.disagreement = disagreement->position;
    result.disagreement_rotation = disagreement->rotation;
    evidence.imu_disagrees = disagreement->beyond_doubt;
  }
  const Verdict verdict = judge_.judge(evidence);
  if (verdict.trusted) return verdict;
  if (verdict.cause == Cause::kImuDisagrees && evidence.imu_disagrees) {
    // The scans of the last second were wrong as well. What they did to the pose stays in odom, which never
    // jumps.
    const math::SE3 T_odom_imu = estimate_.state.T_odom_imu();
    estimate_ = disagreement->imu_alone;
    result.was_deceived = true;
    call_the_pose(T_odom_imu);
  }
  agreement_.clear();
  is_bridging_ = true;
  offered_.reset();
  return verdict;
}

void ScanTracker::believe(const imu::Estimate& updated, const imu::Estimate& predicted) {
  const bool returns = std::exchange(is_bridging_, false);
  const math::SE3 T_predicted = predicted.state.T_odom_imu();
  estimate_ = updated;
  const double turn =
      math::so3_log(math::Matrix3d(T_predicted.R.transpose() * updated.state.R_odom_imu)).norm();
  const double step = (updated.state.p_odom - T_predicted.t).norm();
  if (returns && (step > config_.trust.max_step || turn > config_.trust.max_step_deg * kRadiansPerDegree)) {
    call_the_pose(T_predicted);
  }
  last_trusted_ = estimate_;
  agreement_.add(estimate_);
}

void ScanTracker::call_the_pose(const math::SE3& T_odom_imu) {
  math::SE3 T_new_odom = T_odom_imu * estimate_.state.T_odom_imu().inverse();
  // Rounding would otherwise triple with every map: after sixteen of them it is no rotation any more.
  T_new_odom.R = math::nearest_rotation(T_new_odom.R);
  estimate_ = imu::transformed(T_new_odom, estimate_);
  last_trusted_ = imu::transformed(T_new_odom, last_trusted_);
  if (trial_) trial_->estimate = imu::transformed(T_new_odom, trial_->estimate);
  T_odom_map_ = T_new_odom * T_odom_map_;
  agreement_.clear();
}

ScanTracker::Drift ScanTracker::drift() const { return drift_of(estimate_); }

ScanTracker::Drift ScanTracker::drift_of(const imu::Estimate& estimate) const {
  return {largest_deviation(estimate.P, imu::kPosition) - largest_deviation(last_trusted_.P, imu::kPosition),
          largest_deviation(estimate.P, imu::kRotation) - largest_deviation(last_trusted_.P, imu::kRotation)};
}

bool ScanTracker::is_collapsed(const ScanResult& result) const {
  return judge_.has_collapsed({result.time, result.num_points, result.median_range});
}

Time ScanTracker::needs_imu_since() const {
  return std::min(estimate_.state.time, agreement_.needs_imu_since().value_or(estimate_.state.time));
}

ScanTracker::Motion ScanTracker::propagate_to(const imu::Estimate& from, Time time, const sensor::ImuBuffer& imu) const {
  const Time now = from.state.time;
  const sensor::ImuSamples samples = imu.covering(now, time);
  MMLINS_CHECK(!samples.empty());
  const Duration silence = imu.longest_gap(now, time);
  Motion motion{imu::propagate(from, samples, noise_), to_seconds(silence) > config_.imu.max_gap};
  // A silence longer than this step was doubted before: it counts only as far as it is new.
  if (motion.has_gap)
    motion.propagation.estimate.P += imu::doubt_after_gap(to_seconds(std::min(silence, time - now)));
  return motion;
}

bool ScanTracker::insertion_is_due() const {
  if (num_insertions_ < config_.map.initial_insertions) return true;
  const math::SE3 moved =
      T_map_last_insertion_.inverse() * T_odom_map_.inverse() * estimate_.state.T_odom_imu();
  return moved.t.norm() >= config_.map.insert_distance ||
         math::so3_log(moved.R).norm() >= config_.map.insert_angle_deg * kRadiansPerDegree;
}

void ScanTracker::grow_map(const lidar::Cloud& cloud_imu, bool returns, bool as_usual) {
  // A scan in which a cover comes or goes shows the cover as well. It goes when the robot returns into its
  // map, it comes when the next scan is not believed.
  if (cloud_imu.size() == 0 || !insertion_is_due() || (returns && num_insertions_ > 0)) return;
  const Placed placed{cloud_imu.points, T_odom_map_.inverse() * estimate_.state.T_odom_imu()};
  if (num_insertions_ > 0 && !as_usual) {
    postponed_ = placed;
  } else {
    insert_into_map(placed);
  }
}

void ScanTracker::insert_into_map(const Placed& placed) {
  map_.insert(placed.points_imu, placed.T_map_imu);
  map_.evict_beyond(placed.T_map_imu, config_.map.radius);
  if (offered_) offered_->insert(placed.points_imu, placed.T_map_imu);
  T_map_last_insertion_ = placed.T_map_imu;
  ++num_insertions_;
}

void ScanTracker::consider_offer(const Prepared& prepared, ScanResult& result) {
  if (!offered_ || result.state != TrackingState::kTracking) return;
  const PlacedView view{prepared.keypoints.points, T_odom_map_.inverse() * estimate_.state.T_odom_imu(), estimate_.P};
  const MapOffer::Answer answer = offered_->consider(map_, view, config_, rig_);
  result.map_rebuilt = answer == MapOffer::Answer::kTaken;
  if (answer != MapOffer::Answer::kNotYet) offered_.reset();
}

}  // namespace mmlins::odometry
