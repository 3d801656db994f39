// SPDX-License-Identifier: MIT
#include "mmlins/odometry/startup.hpp"

#include <Eigen/Cholesky>
#include <algorithm>
#include <cmath>
#include <optional>

#include "mmlins/base/check.hpp"
#include "mmlins/base/result.hpp"
#include "mmlins/odometry/inertial_alignment.hpp"
#include "mmlins/odometry/pose_measurement.hpp"

namespace mmlins::odometry {
namespace {

using imu::ErrorMatrix;
using imu::Estimate;
using initialization::BiasDeviation;
using initialization::Verdict;
using imu::NavState;
using math::Matrix3d;
using math::Vector3d;

// The heading and place of the first pose define the frame: their errors are nil by choice [rad], [m].
constexpr double kDefinedByFrame = 1e-5;
constexpr double kAlignedSpeedDeviation = 0.5;    // [m/s]
constexpr double kAlignedForceDeviation = 0.5;    // as a measurement of gravity [m/s^2]
constexpr double kFirstPassShare = 0.25;          // of the window

struct Deviation {
  Vector3d mean = Vector3d::Zero();
  double largest = 0.0;
};

template <typename Reading>
Deviation deviation_of(const sensor::ImuSamples& samples, const Reading& reading) {
  Deviation result;
  for (const auto& sample : samples) result.mean += reading(sample) / static_cast<double>(samples.size());
  Vector3d variance = Vector3d::Zero();
  for (const auto& sample : samples) {
    variance += (reading(sample) - result.mean).cwiseAbs2() / static_cast<double>(samples.size());
  }
  result.largest = std::sqrt(variance.maxCoeff());
  return result;
}

Vector3d gyro_of(const sensor::ImuSample& sample) { return sample.gyro; }
Vector3d accel_of(const sensor::ImuSample& sample) { return sample.accel; }

/// Mean specific force over the window, in the IMU frame of its first sample.
Vector3d mean_force_at_start(const sensor::ImuSamples& samples) {
  Matrix3d R_first_now = Matrix3d::Identity();
  Vector3d sum = Vector3d::Zero();
  for (std::size_t i = 0; i + 1 < samples.size(); ++i) {
    const double dt = to_seconds(samples[i + 1].time - samples[i].time);
    sum += R_first_now * samples[i].accel * dt;
    R_first_now = R_first_now * math::so3_exp(0.5 * (samples[i].gyro + samples[i + 1].gyro) * dt);
  }
  const double duration = to_seconds(samples.back().time - samples.front().time);
  return duration > 0.0 ? Vector3d(sum / duration) : samples.front().accel;
}

/// Turns the frame so that gravity points along -z and the heading is zero; the physics stays as it was.
NavState levelled(NavState state) {
  const Vector3d up_imu = state.R_odom_imu.transpose() * -state.gravity_odom.normalized();
  const Matrix3d R_level = Eigen::Quaterniond::FromTwoVectors(up_imu, Vector3d::UnitZ()).toRotationMatrix();
  const double heading = std::atan2(R_level(1, 0), R_level(0, 0));
  const Matrix3d R_new = Eigen::AngleAxisd(-heading, Vector3d::UnitZ()).toRotationMatrix() * R_level;
  state.v_odom = R_new * state.R_odom_imu.transpose() * state.v_odom;
  state.R_odom_imu = R_new;
  state.p_odom.setZero();
  state.gravity_odom = Vector3d(0.0, 0.0, -imu::kGravity);
  return state;
}

/// How wide the prior is, before the IMU's mean force ties gravity to the accelerometer's bias.
struct PriorWidth {
  double speed;
  double gyro_bias;
  double accel_bias;
  double force;  ///< of the mean specific force as a measurement of gravity [m/s^2]
};

ErrorMatrix prior_covariance(const NavState& state, const PriorWidth& width) {
  imu::ErrorVector sigma;
  sigma << Vector3d::Constant(kDefinedByFrame), Vector3d::Constant(kDefinedByFrame), Vector3d::Constant(width.speed),
      Vector3d::Constant(width.gyro_bias), Vector3d::Constant(width.accel_bias), Eigen::Vector2d::Constant(0.5);
  const ErrorMatrix P = sigma.cwiseAbs2().asDiagonal();
  // The mean force f = accel bias - R^T gravity: gravity and bias become as correlated as they are.
  Eigen::Matrix<double, 3, imu::kErrorSize> H = Eigen::Matrix<double, 3, imu::kErrorSize>::Zero();
  H.block<3, 3>(0, imu::kAccelBias).setIdentity();
  H.block<3, 2>(0, imu::kGravityDirection) =
      -state.R_odom_imu.transpose() * math::sphere_plus_jacobian(state.gravity_odom);
  const Matrix3d S = H * P * H.transpose() + width.force * width.force * Matrix3d::Identity();
  const Eigen::Matrix<double, imu::kErrorSize, 3> PHt = P * H.transpose();
  return P - PHt * S.inverse() * PHt.transpose();
}

PriorWidth prior_width(const OdometryConfig& config, const BiasDeviation& biases, bool at_rest) {
  const initialization::PriorConfig& rest = config.initialization.prior;
  if (at_rest) return {rest.rest_speed, rest.rest_gyro, biases.accel, rest.rest_accel};
  return {config.start.motion_speed, biases.gyro, biases.accel, config.start.motion_accel};
}

Start run_window(const OdometryConfig& config, const sensor::Rig& rig, const std::vector<ScanPointer>& scans,
                 const sensor::ImuBuffer& imu, const Estimate& prior) {
  Start start;
  start.prior = prior;
  start.tracker = std::make_unique<ScanTracker>(config, rig, prior);
  for (const ScanPointer& scan : scans) {
    ScanResult result = start.tracker->track(scan, imu);
    if (is_placed(result.state)) result.state = TrackingState::kInitializing;
    start.results.push_back(std::move(result));
  }
  return start;
}

/// Speed at the end of the window, and how far the robot came, say that it never moved.
bool scans_say_rest(const Start& start, const StartConfig& config, double window) {
  const NavState& end = start.tracker->estimate().state;
  return end.v_odom.norm() < config.rest_speed && end.p_odom.norm() < config.rest_speed * window;
}

/// The prior of the next pass: velocity and gravity from the positions of this one. Biases are not carried
/// over: a pass may blame them for what the unknown velocity did.
std::optional<Estimate> prior_from_pass(const Start& pass, const sensor::ImuSamples& samples,
                                        const BiasDeviation& biases) {
  math::Trajectory T_odom_imu;
  for (const ScanResult& result : pass.results) {
    T_odom_imu.push_back({result.time, result.estimate.state.T_odom_imu()});
  }
  NavState begin = pass.prior.state;
  const auto aligned = align_inertially(samples, T_odom_imu, begin);
  if (!aligned) return std::nullopt;
  begin.v_odom = aligned->v_odom;
  begin.gravity_odom = aligned->gravity_odom;
  begin = levelled(begin);
  return Estimate{begin,
                  prior_covariance(begin, {kAlignedSpeedDeviation, biases.gyro, biases.accel, kAlignedForceDeviation})};
}

/// Poses that the scans gave, without those that none was matched for.
initialization::PoseMeasurements poses_of(const Start& start, const RestartConfig& config) {
  initialization::PoseMeasurements poses;
  for (const ScanResult& result : start.results) {
    if (!is_placed(result.state)) continue;
    poses.push_back(poses.empty() ? initialization::defining_pose(result.time, result.estimate.state.T_odom_imu())
                                  : measured_pose(result, config));
  }
  return poses;
}

/// Velocity, gravity and biases once more, from what the scans alone say of the poses: judged, and if accepted what the
/// tracker goes on with.
void confirm(Start& start, const OdometryConfig& config, const sensor::Rig& rig, const sensor::ImuBuffer& imu) {
  if (start.acceptance.verdict == Verdict::kNotConverged) return;
  const initialization::PoseMeasurements poses = poses_of(start, config.restart);
  if (poses.empty() || poses.back().time != start.results.back().time) {
    start.acceptance = {Verdict::kTooFewPoses, "the last scan matches nothing"};
    return;
  }
  const initialization::Window window{poses, imu.covering(poses.front().time, poses.back().time),
                                      imu_noise(config.imu, rig)};
  const BiasDeviation biases = bias_deviation(rig);
  const initialization::StatePrior prior =
      start.at_rest ? rest_prior(poses.front(), window.samples, config.initialization.prior, biases)
                    : cold_prior(poses.front().time, biases);
  const initialization::Initialization found = initialization::initialize(window, prior, config.initialization);
  start.acceptance = found.acceptance;
  if (!found.acceptance.accepted()) return;
  start.tracker->set_estimate(found.solution.estimate);
  start.results.back().estimate = found.solution.estimate;
}

/// Goes over the window again and again, at first only over its beginning: a map that was built with a wrong
/// velocity misleads the scans after it, so it is thrown away early.
Start start_in_motion(const OdometryConfig& config, const sensor::Rig& rig, const std::vector<ScanPointer>& scans,
                      const sensor::ImuBuffer& imu, Estimate prior) {
  for (int pass = 1;; ++pass) {
    const double share = std::min(1.0, kFirstPassShare * std::pow(2.0, pass - 1));
    const auto count = std::max<std::size_t>(std::min<std::size_t>(5, scans.size()),
                                             static_cast<std::size_t>(share * static_cast<double>(scans.size())));
    const bool whole = count >= scans.size();
    Start start = run_window(config, rig, {scans.begin(), scans.begin() + static_cast<std::ptrdiff_t>(count)}, imu, prior);
    const sensor::ImuSamples samples = imu.covering(prior.state.time, start.results.back().time);
    const std::optional<Estimate> next = prior_from_pass(start, samples, bias_deviation(rig));
    const double change = next ? (next->state.v_odom - prior.state.v_odom).norm() : 0.0;
    if (whole && change < config.start.settled_speed) return start;
    if (whole && pass >= config.start.max_passes) {
      start.acceptance = {Verdict::kNotConverged,
                          fmt::format("the velocity had not settled after {} passes: {:.2f} m/s in the last", pass, change)};
      return start;
    }
    if (next) prior = *next;
  }
}

}  // namespace

bool imu_is_quiet(const sensor::ImuSamples& samples, const StartConfig& config, const BiasDeviation& biases) {
  if (samples.size() < 10) return false;
  const Deviation gyro = deviation_of(samples, gyro_of);
  const Deviation accel = deviation_of(samples, accel_of);
  return gyro.largest < config.rest_gyro_deviation && gyro.mean.norm() < 5.0 * biases.gyro &&
         accel.largest < config.rest_accel_deviation;
}

Estimate start_prior(const sensor::ImuSamples& samples, const OdometryConfig& config, const BiasDeviation& biases,
                     bool at_rest) {
  MMLINS_CHECK(!samples.empty());
  NavState state;
  state.time = samples.front().time;
  const Vector3d force = at_rest ? deviation_of(samples, accel_of).mean : mean_force_at_start(samples);
  if (at_rest) state.gyro_bias = deviation_of(samples, gyro_of).mean;
  state.gravity_odom = force.norm() > 0.0 ? Vector3d(-force.normalized() * imu::kGravity) : state.gravity_odom;
  state = levelled(state);
  return {state, prior_covariance(state, prior_width(config, biases, at_rest))};
}

std::vector<Estimate> carried_back(const Estimate& begin, const std::vector<Time>& times, const sensor::ImuBuffer& imu,
                                   const imu::ImuNoise& noise) {
  std::vector<Estimate> estimates;
  Estimate now = begin;
  for (auto time = times.rbegin(); time != times.rend(); ++time) {
    const sensor::ImuSamples samples = imu.covering(*time, now.state.time);
    for (std::size_t i = samples.size(); i-- > 1;) {
      imu::ImuStep step = imu::step_between(samples[i - 1], samples[i]);
      const ErrorMatrix Q = imu::step_noise(step, noise);
      step.dt = -step.dt;
      const ErrorMatrix F = imu::transition(now.state, step);
      now = {imu::integrate(now.state, step), F * now.P * F.transpose() + Q};
    }
    now.state.time = *time;
    estimates.push_back(now);
  }
  std::reverse(estimates.begin(), estimates.end());
  return estimates;
}

std::unique_ptr<Start> find_start(const OdometryConfig& config, const sensor::Rig& rig,
                                  const std::vector<ScanPointer>& scans, const sensor::ImuBuffer& imu) {
  const BiasDeviation biases = bias_deviation(rig);
  const sensor::ImuSamples samples = imu.covering(scans.front()->start_time, scans.back()->end_time);
  const double window = to_seconds(samples.back().time - samples.front().time);
  const bool quiet = imu_is_quiet(samples, config.start, biases);
  const bool long_enough = window >= config.start.motion_window;
  if (!quiet && !long_enough) return nullptr;

  const Estimate prior = start_prior(samples, config, biases, false);
  if (quiet) {
    const Start trial = run_window(config, rig, scans, imu, prior);
    if (scans_say_rest(trial, config.start, window)) {
      auto start = std::make_unique<Start>(
          run_window(config, rig, scans, imu, start_prior(samples, config, biases, true)));
      start->at_rest = true;
      confirm(*start, config, rig, imu);
      if (start->acceptance.accepted() || !long_enough) return start;
    }
    if (!long_enough) return nullptr;
  }

  auto start = std::make_unique<Start>(start_in_motion(config, rig, scans, imu, prior));
  confirm(*start, config, rig, imu);
  return start;
}

}  // namespace mmlins::odometry
