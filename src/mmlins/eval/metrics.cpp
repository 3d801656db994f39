// SPDX-License-Identifier: MIT
#include "mmlins/eval/metrics.hpp"

#include <algorithm>
#include <cmath>
#include <cstdlib>
#include <numbers>

#include "mmlins/base/check.hpp"

namespace mmlins::eval {
namespace {

using math::SE3;

constexpr double kDegrees = 180.0 / std::numbers::pi;
constexpr double kSegment = 100.0;  ///< [m]
constexpr int kGapFactor = 3;       ///< a period this many times the median is a gap

double angle_deg(const math::Matrix3d& R) { return kDegrees * math::so3_log(R).norm(); }

Duration median_period(const math::Trajectory& trajectory) {
  std::vector<Duration> periods;
  for (std::size_t i = 1; i < trajectory.size(); ++i)
    periods.push_back(trajectory[i].time - trajectory[i - 1].time);
  if (periods.empty()) return Duration::zero();
  const auto middle = periods.begin() + static_cast<std::ptrdiff_t>(periods.size() / 2);
  std::nth_element(periods.begin(), middle, periods.end());
  return *middle;
}

/// What the estimated motion from one pose to another has too much: identity if it is right.
SE3 motion_error(const PosePair& from, const PosePair& to) {
  const SE3 true_motion = from.T_truth_imu.inverse() * to.T_truth_imu;
  const SE3 estimated_motion = from.T_estimate_imu.inverse() * to.T_estimate_imu;
  return true_motion.inverse() * estimated_motion;
}

/// Collects one kind of error into its figures.
struct Errors {
  std::vector<double> translation;
  std::vector<double> rotation;

  void add(const SE3& error, double factor = 1.0) {
    translation.push_back(factor * error.t.norm());
    rotation.push_back(factor * angle_deg(error.R));
  }
  ErrorFigures figures() const { return {statistics_of(translation), statistics_of(rotation)}; }
};

/// Index of the pair nearest to `time`.
std::size_t nearest_pair(const PosePairs& pairs, Time time) {
  const auto next = std::lower_bound(pairs.begin(), pairs.end(), time,
                                     [](const PosePair& pair, Time t) { return pair.time < t; });
  const auto index = static_cast<std::size_t>(next - pairs.begin());
  if (next == pairs.end() || (index > 0 && time - pairs[index - 1].time <= next->time - time))
    return index - 1;
  return index;
}

std::vector<double> distances_along(const PosePairs& pairs) {
  std::vector<double> distances(pairs.size(), 0.0);
  for (std::size_t i = 1; i < pairs.size(); ++i) {
    distances[i] = distances[i - 1] + (pairs[i].T_truth_imu.t - pairs[i - 1].T_truth_imu.t).norm();
  }
  return distances;
}

}  // namespace

Statistics statistics_of(std::vector<double> values) {
  Statistics s;
  if (values.empty()) return s;
  std::sort(values.begin(), values.end());
  const auto count = static_cast<double>(values.size());
  double sum = 0.0;
  double squares = 0.0;
  for (const double value : values) {
    sum += value;
    squares += value * value;
  }
  s.count = static_cast<int>(values.size());
  s.mean = sum / count;
  s.rmse = std::sqrt(squares / count);
  s.max = values.back();
  s.median = 0.5 * (values[(values.size() - 1) / 2] + values[values.size() / 2]);
  double deviations = 0.0;
  for (const double value : values) deviations += (value - s.mean) * (value - s.mean);
  s.std = std::sqrt(deviations / count);
  return s;
}

PosePairs match_poses(const math::Trajectory& truth, const math::Trajectory& estimate) {
  const Duration longest_hole = kGapFactor * median_period(truth);
  PosePairs pairs;
  for (const math::StampedPose& stamped : estimate) {
    if (const auto T_truth_imu = math::pose_at(truth, stamped.time, longest_hole)) {
      pairs.push_back({stamped.time, *T_truth_imu, stamped.pose});
    }
  }
  return pairs;
}

double path_length(const PosePairs& pairs) { return pairs.empty() ? 0.0 : distances_along(pairs).back(); }

ErrorFigures absolute_errors(const PosePairs& pairs, const SE3& T_truth_estimate) {
  Errors errors;
  for (const PosePair& pair : pairs) {
    errors.add(pair.T_truth_imu.inverse() * (T_truth_estimate * pair.T_estimate_imu));
  }
  return errors.figures();
}

std::optional<ErrorFigures> relative_errors_over_time(const PosePairs& pairs, Duration interval) {
  Errors errors;
  for (const PosePair& from : pairs) {
    const Time end = from.time + interval;
    if (end > pairs.back().time) break;
    const PosePair& to = pairs[nearest_pair(pairs, end)];
    if (to.time > from.time && std::chrono::abs(to.time - end) <= interval / 4)
      errors.add(motion_error(from, to));
  }
  if (errors.translation.empty()) return std::nullopt;
  return errors.figures();
}

std::optional<ErrorFigures> relative_errors_per_100m(const PosePairs& pairs) {
  const std::vector<double> distances = distances_along(pairs);
  Errors errors;
  std::size_t to = 0;
  for (std::size_t from = 0; from < pairs.size(); ++from) {
    while (to < pairs.size() && distances[to] < distances[from] + kSegment) ++to;
    if (to == pairs.size()) break;
    const SE3 error = motion_error(pairs[from], pairs[to]);
    errors.add(error, 100.0 / (distances[to] - distances[from]));
  }
  if (errors.translation.empty()) return std::nullopt;
  return errors.figures();
}

EndToEndError end_to_end_error(const PosePairs& pairs) {
  MMLINS_CHECK(!pairs.empty());
  const SE3 error = motion_error(pairs.front(), pairs.back());
  return {error.t.norm(), angle_deg(error.R)};
}

Coverage coverage_of(const math::Trajectory& truth, const math::Trajectory& estimate) {
  MMLINS_CHECK(!truth.empty() && !estimate.empty());
  const Time begin = truth.front().time;
  const Time end = truth.back().time;
  const Duration longest_period = kGapFactor * median_period(estimate);
  Duration covered = Duration::zero();
  Duration longest_gap = Duration::zero();
  for (std::size_t i = 1; i < estimate.size(); ++i) {
    const Time from = std::max(begin, estimate[i - 1].time);
    const Time to = std::min(end, estimate[i].time);
    if (to <= from) continue;
    longest_gap = std::max(longest_gap, to - from);
    if (estimate[i].time - estimate[i - 1].time <= longest_period) covered += to - from;
  }
  Coverage coverage;
  coverage.share = end > begin ? to_seconds(covered) / to_seconds(end - begin) : 0.0;
  coverage.longest_gap = to_seconds(longest_gap);
  coverage.late_start = std::max(0.0, to_seconds(estimate.front().time - begin));
  coverage.early_end = std::max(0.0, to_seconds(end - estimate.back().time));
  return coverage;
}

}  // namespace mmlins::eval
