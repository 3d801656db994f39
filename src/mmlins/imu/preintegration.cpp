// SPDX-License-Identifier: MIT
#include "mmlins/imu/preintegration.hpp"

#include <algorithm>

#include "mmlins/base/check.hpp"

namespace mmlins::imu {
namespace {

using Iterator = sensor::ImuSamples::const_iterator;

sensor::ImuSample sample_at(const sensor::ImuSamples& samples, Iterator next, Time time) {
  if (next == samples.end()) return {time, samples.back().gyro, samples.back().accel};
  if (next == samples.begin() || next->time == time) return {time, next->gyro, next->accel};
  const auto& before = *std::prev(next);
  const double s = to_seconds(time - before.time) / to_seconds(next->time - before.time);
  return {time, before.gyro + s * (next->gyro - before.gyro),
          before.accel + s * (next->accel - before.accel)};
}

/// The samples of the span, the first and the last exactly at its ends.
sensor::ImuSamples stretch_of(const sensor::ImuSamples& samples, Iterator from, Iterator to,
                              const TimeSpan& span) {
  sensor::ImuSamples stretch{sample_at(samples, from, span.begin)};
  stretch.insert(stretch.end(), from, to);
  if (stretch.size() > 1 && stretch[1].time == span.begin) stretch.erase(stretch.begin());
  if (span.end > span.begin) stretch.push_back(sample_at(samples, to, span.end));
  return stretch;
}

/// Longest time between neighbours among the samples that the span touches, and its ends where none lie
/// beyond.
double longest_step_in(const sensor::ImuSamples& samples, Iterator from, Iterator to, const TimeSpan& span) {
  const bool exact = from != samples.end() && from->time == span.begin;
  Time last = from == samples.begin() || exact ? span.begin : std::prev(from)->time;
  Duration longest{0};
  for (; from != to; ++from) {
    longest = std::max(longest, from->time - last);
    last = from->time;
  }
  return to_seconds(std::max(longest, (to == samples.end() ? span.end : to->time) - last));
}

}  // namespace

Preintegration preintegrate(const sensor::ImuSamples& samples, const TimeSpan& span, const ImuBias& bias,
                            const ImuNoise& noise) {
  MMLINS_CHECK(!samples.empty() && span.begin <= span.end);
  const auto earlier = [](const sensor::ImuSample& sample, Time time) { return sample.time < time; };
  const Iterator from = std::lower_bound(samples.begin(), samples.end(), span.begin, earlier);
  const Iterator to = std::lower_bound(from, samples.end(), span.end, earlier);
  const sensor::ImuSamples stretch = stretch_of(samples, from, to, span);

  Preintegration result;
  result.span = span;
  result.bias = bias;
  result.longest_step = longest_step_in(samples, from, to, span);
  // Strapdown integration from rest at the origin of a world without gravity.
  NavState state;
  state.gyro_bias = bias.gyro;
  state.accel_bias = bias.accel;
  state.gravity_odom.setZero();
  constexpr int n = Preintegration::kSize;
  for (std::size_t i = 1; i < stretch.size(); ++i) {
    const ImuStep step = step_between(stretch[i - 1], stretch[i]);
    const ErrorMatrix whole = transition(state, step);
    const Eigen::Matrix<double, n, n> F = whole.topLeftCorner<n, n>();
    result.covariance = F * result.covariance * F.transpose() + step_noise(step, noise).topLeftCorner<n, n>();
    if (step.dt > kLongestStep) result.covariance += doubt_after_gap(step.dt).topLeftCorner<n, n>();
    result.bias_jacobian = F * result.bias_jacobian + whole.block<n, 6>(0, kGyroBias);
    state = integrate(state, step);
  }
  result.delta = {state.R_odom_imu, state.p_odom, state.v_odom};
  return result;
}

ImuDelta corrected(const Preintegration& motion, const ImuBias& bias) {
  math::Vector6d change;
  change << bias.gyro - motion.bias.gyro, bias.accel - motion.bias.accel;
  const Eigen::Matrix<double, Preintegration::kSize, 1> d = motion.bias_jacobian * change;
  return {motion.delta.R * math::so3_exp(d.segment<3>(kRotation)), motion.delta.p + d.segment<3>(kPosition),
          motion.delta.v + d.segment<3>(kVelocity)};
}

}  // namespace mmlins::imu
