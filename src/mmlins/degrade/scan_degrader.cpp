// SPDX-License-Identifier: MIT
#include "mmlins/degrade/scan_degrader.hpp"

#include <algorithm>
#include <utility>

#include "mmlins/base/check.hpp"
#include "mmlins/degrade/effects.hpp"
#include "mmlins/math/random.hpp"

namespace mmlins::degrade {

namespace {

using math::sub_seed;

/// Nearer than this nothing is measured: the origin marks a beam without an echo. [m]
constexpr float kOrigin = 1e-6F;

bool has_echo(const Eigen::Vector3f& point) { return point.allFinite() && point.norm() > kOrigin; }

std::vector<EffectPoint> all_points(const SweepView& sweep) {
  std::vector<EffectPoint> points(sweep.points->size());
  for (std::size_t i = 0; i < points.size(); ++i) {
    const Eigen::Vector3f& position = (*sweep.points)[i];
    points[i] = {static_cast<std::uint32_t>(i), position, has_echo(position), Duration{0}};
  }
  return points;
}

std::size_t num_echoes(const std::vector<EffectPoint>& points) {
  return static_cast<std::size_t>(
      std::count_if(points.begin(), points.end(), [](const EffectPoint& point) { return point.has_echo; }));
}

/// Takes the points of the event out, has them changed, and puts them back in order.
std::vector<EffectPoint> with_effect(const std::vector<EffectPoint>& points, const std::vector<Time>& times,
                                     Time begin, const EffectContext& context) {
  const Duration duration = context.event.end() - context.event.begin();
  std::vector<EffectPoint> inside;
  std::vector<EffectPoint> result;
  for (EffectPoint point : points) {
    point.since_begin = times[point.index] - begin;
    const bool active = point.since_begin >= Duration{0} && point.since_begin < duration;
    (active ? inside : result).push_back(point);
  }
  if (inside.empty()) return points;
  const std::vector<EffectPoint> left = apply_effect(inside, context);
  const auto middle = static_cast<std::ptrdiff_t>(result.size());
  result.insert(result.end(), left.begin(), left.end());
  std::inplace_merge(result.begin(), result.begin() + middle, result.end(),
                     [](const EffectPoint& a, const EffectPoint& b) { return a.index < b.index; });
  return result;
}

bool moved(const Eigen::Vector3f& a, const Eigen::Vector3f& b) {
  return has_echo(a) && a != b;  // what is not finite is never equal, and never moved
}

}  // namespace

ScanDegrader::ScanDegrader(std::vector<EventSpec> events, Time recording_start, const DegradeOptions& options)
    : events_(std::move(events)), recording_start_(recording_start), options_(options) {}

DegradedSweep ScanDegrader::apply(const SweepView& sweep) const {
  MMLINS_CHECK(sweep.points->size() == sweep.times->size());
  std::vector<EffectPoint> points = all_points(sweep);
  const std::size_t sweep_size = num_echoes(points);
  DegradedSweep result;
  const auto stamp = static_cast<std::uint64_t>(to_ns(sweep.stamp));
  for (std::size_t i = 0; i < events_.size(); ++i) {
    const std::uint64_t event_seed = sub_seed(options_.seed, i);
    const EffectContext context{events_[i], event_seed, sub_seed(event_seed, stamp), sweep_size};
    const bool had_points = !points.empty();
    points = with_effect(points, *sweep.times, recording_start_ + events_[i].begin(), context);
    const bool loses_sweeps =
        events_[i].kind == EventKind::kPacketLoss || events_[i].kind == EventKind::kKidnap;
    result.lost |= loses_sweeps && had_points && points.empty();
  }
  for (const EffectPoint& point : points) {
    const Eigen::Vector3f& before = (*sweep.points)[point.index];
    const bool is_moved = moved(before, point.position);
    if (is_moved && static_cast<double>(point.position.norm()) < options_.min_range) continue;
    result.changed |= is_moved;
    result.kept.push_back(point.index);
    result.points.push_back(point.position);
  }
  result.changed |= result.kept.size() != sweep.points->size();
  return result;
}

std::vector<Time> point_times(const sensor::LidarScan& scan) {
  std::vector<Time> times;
  times.reserve(scan.size());
  for (const float offset : scan.offsets) {
    times.push_back(scan.start_time + from_seconds(static_cast<double>(offset)));
  }
  return times;
}

sensor::LidarScan degraded(const sensor::LidarScan& scan, const DegradedSweep& sweep) {
  if (!sweep.changed) return scan;
  sensor::LidarScan result;
  result.num_invalid = scan.num_invalid;
  result.points = sweep.points;
  for (const std::uint32_t i : sweep.kept) {
    result.offsets.push_back(scan.offsets[i]);
    result.intensities.push_back(scan.intensities[i]);
    if (!scan.rings.empty()) result.rings.push_back(scan.rings[i]);
  }
  result.start_time = result.end_time = scan.start_time;
  if (result.offsets.empty()) return result;
  const auto [first, last] = std::minmax_element(result.offsets.begin(), result.offsets.end());
  const float earliest = *first;
  result.start_time = scan.start_time + from_seconds(static_cast<double>(earliest));
  result.end_time = scan.start_time + from_seconds(static_cast<double>(*last));
  for (float& offset : result.offsets) offset -= earliest;
  return result;
}

}  // namespace mmlins::degrade
