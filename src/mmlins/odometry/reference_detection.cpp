// SPDX-License-Identifier: MIT
#include "mmlins/odometry/reference_detection.hpp"

#include <Eigen/LU>
#include <algorithm>
#include <cmath>

namespace mmlins::odometry {
namespace {

// What FAST-LIO2's configurations are shipped with. Its noise is a variance per sample, multiplied by the square of
// the sample's time: as a density it depends on the rate [rad^2/s^2], [m^2/s^4], [m^2].
constexpr double kNoisePerSample = 0.1;
constexpr double kBiasNoisePerSample = 1e-4;
constexpr double kPointVariance = 0.001;
// The degeneracy factor below which the paper's comparison calls a scan degenerate.
constexpr double kDegeneracyFactor = 100.0;

imu::ImuNoise fast_lio2_noise(const sensor::ImuSamples& samples) {
  const double duration = to_seconds(samples.back().time - samples.front().time);
  const double rate_hz = static_cast<double>(samples.size() - 1) / std::max(duration, 1e-3);
  const double motion = std::sqrt(kNoisePerSample / std::max(rate_hz, 1.0));
  const double bias = std::sqrt(kBiasNoisePerSample / std::max(rate_hz, 1.0));
  return {motion, motion, bias, bias};
}

imu::ErrorMatrix updated(const imu::ErrorMatrix& P, const math::Matrix6d& H) {
  const math::Matrix6d M = math::Matrix6d::Identity() + P.topLeftCorner<6, 6>() * H;
  const math::Matrix6d gain = H * M.inverse();
  const imu::ErrorMatrix result = P - P.leftCols<6>() * gain * P.topRows<6>();
  return 0.5 * (result + result.transpose());
}

}  // namespace

void ReferenceDetection::restart() {
  P_.reset();
  count_ = 0;
}

bool ReferenceDetection::step(const imu::NavState& before, const sensor::ImuSamples& samples,
                              const math::Matrix6d& unweighted) {
  if (kind_ == DetectorKind::kZhang) return degeneracy::degeneracy_factor(unweighted) < kDegeneracyFactor;
  const imu::Estimate start{before, P_.value_or(imu::ErrorMatrix::Identity())};
  const bool is_first = !P_.has_value();
  P_ = updated(imu::propagate(start, samples, fast_lio2_noise(samples)).estimate.P, unweighted / kPointVariance);
  if (is_first) return false;
  const math::Matrix6d P_pose = P_->topLeftCorner<6, 6>();
  if (kind_ == DetectorKind::kPaper) {
    const auto verdict = degeneracy::paper_detector(P_pose, count_, {});
    count_ = verdict.num_minor_scans;
    return verdict.over_degenerate;
  }
  const auto verdict = degeneracy::published_rule(P_pose, count_);
  count_ = verdict.num_degraded_scans;
  return verdict.over_degenerate;
}

}  // namespace mmlins::odometry
