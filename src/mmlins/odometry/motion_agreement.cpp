// SPDX-License-Identifier: MIT
#include "mmlins/odometry/motion_agreement.hpp"

#include <cmath>
#include <numbers>

namespace mmlins::odometry {
namespace {

constexpr double kRadiansPerDegree = std::numbers::pi / 180.0;
constexpr double kSigmas = 3.0;

double deviation(const imu::ErrorMatrix& P, int block) { return std::sqrt(P.block<3, 3>(block, block).trace()); }

}  // namespace

std::optional<Disagreement> MotionAgreement::compare(const imu::Estimate& now, const sensor::ImuBuffer& imu) const {
  if (past_.empty()) return std::nullopt;
  const imu::Estimate& then = past_.front();
  const double window = to_seconds(now.state.time - then.state.time);
  if (window < config_.agreement_window) return std::nullopt;
  if (imu.longest_gap(then.state.time, now.state.time) > max_gap_) return std::nullopt;
  const sensor::ImuSamples samples = imu.covering(then.state.time, now.state.time);
  imu::NavState alone = then.state;
  for (std::size_t i = 1; i < samples.size(); ++i) {
    alone = imu::integrate(alone, imu::step_between(samples[i - 1], samples[i]));
  }
  Disagreement result;
  result.position = (now.state.p_odom - alone.p_odom).norm();
  result.rotation = math::so3_log(math::Matrix3d(now.state.R_odom_imu.transpose() * alone.R_odom_imu)).norm();
  const double max_rotation = config_.max_disagreement_deg * kRadiansPerDegree;
  if (result.position <= config_.max_disagreement && result.rotation <= max_rotation) return result;
  // Only now is it worth asking how much of that the IMU's own doubt explains.
  result.imu_alone = imu::propagate(then, samples, noise_).estimate;
  result.beyond_doubt =
      result.position > config_.max_disagreement + kSigmas * deviation(result.imu_alone.P, imu::kPosition) ||
      result.rotation > max_rotation + kSigmas * deviation(result.imu_alone.P, imu::kRotation);
  return result;
}

void MotionAgreement::clear() {
  past_.clear();
  settled_at_.reset();
}

void MotionAgreement::add(const imu::Estimate& trusted) {
  if (!settled_at_) settled_at_ = trusted.state.time + from_seconds(config_.agreement_window);
  if (trusted.state.time < *settled_at_) return;
  past_.push_back(trusted);
  const Time window_begin = trusted.state.time - from_seconds(config_.agreement_window);
  while (past_.size() > 1 && past_[1].state.time <= window_begin) past_.pop_front();
}

std::optional<Time> MotionAgreement::needs_imu_since() const {
  if (past_.empty()) return std::nullopt;
  return past_.front().state.time;
}

}  // namespace mmlins::odometry
