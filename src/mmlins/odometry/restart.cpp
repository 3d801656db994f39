// SPDX-License-Identifier: MIT
#include "mmlins/odometry/restart.hpp"

#include <fmt/format.h>

#include <Eigen/Eigenvalues>
#include <cmath>
#include <numbers>

#include "mmlins/imu/frame_change.hpp"

namespace mmlins::odometry {
namespace {

constexpr double kDegrees = 180.0 / std::numbers::pi;

template <int Size>
double largest_deviation(const imu::ErrorMatrix& P, int begin) {
  const Eigen::Matrix<double, Size, Size> block = P.block<Size, Size>(begin, begin);
  const Eigen::SelfAdjointEigenSolver<Eigen::Matrix<double, Size, Size>> solver(block, Eigen::EigenvaluesOnly);
  return std::sqrt(std::max(0.0, solver.eigenvalues()(Size - 1)));
}

}  // namespace

Restart::Restart(const OdometryConfig& config, const sensor::Rig& rig, const imu::Estimate& carried,
                 const math::SE3& T_odom_map)
    : config_(config.restart),
      begin_(carried),
      tracker_(std::make_unique<ScanTracker>(config, rig, imu::with_pose_taken_for_granted(carried), T_odom_map)) {}

Restart::Progress Restart::add(const std::shared_ptr<const sensor::LidarScan>& scan, const sensor::ImuBuffer& imu,
                               bool is_collapsed) {
  const ScanResult result = tracker_->track(scan, imu);
  if (result.state == TrackingState::kBridging) {
    verdict_ = to_string(result.cause);
    return Progress::kFailed;
  }
  const double elapsed = to_seconds(result.time - begin_.state.time);
  verdict_ = objection(elapsed, is_collapsed);
  if (verdict_.empty()) return Progress::kProven;
  return elapsed < config_.patience ? Progress::kOnTrial : Progress::kFailed;
}

std::string Restart::objection(double elapsed, bool is_collapsed) const {
  if (elapsed < config_.trial) return fmt::format("on trial for {:.1f} of {:.1f} s", elapsed, config_.trial);
  const imu::ErrorMatrix& P = tracker_->estimate().P;
  const double speed = largest_deviation<3>(P, imu::kVelocity);
  if (speed > config_.max_speed_deviation) return fmt::format("velocity known to {:.2f} m/s only", speed);
  const double tilt = largest_deviation<2>(P, imu::kGravityDirection) * kDegrees;
  if (tilt > config_.max_tilt_deviation_deg) return fmt::format("gravity known to {:.1f} deg only", tilt);
  if (is_collapsed && !has_seen_motion()) return "the scans have collapsed and show no motion";
  return "";
}

bool Restart::has_seen_motion() const {
  const math::SE3 moved = begin_.state.T_odom_imu().inverse() * tracker_->estimate().state.T_odom_imu();
  return moved.t.norm() > config_.confirming_motion ||
         math::so3_log(moved.R).norm() * kDegrees > config_.confirming_turn_deg;
}

}  // namespace mmlins::odometry
