// SPDX-License-Identifier: MIT
#include "mmlins/io/point_time.hpp"

#include <algorithm>
#include <array>
#include <cmath>
#include <string_view>
#include <utility>

namespace mmlins::io {
namespace {

using sensor::StampReference;
using sensor::TimeReference;
using sensor::TimeUnit;

constexpr std::array kTimeFields = {"t", "time", "timestamp", "timestamps", "offset_time", "time_stamp"};
constexpr std::array kUnits = {TimeUnit::kSeconds, TimeUnit::kMilliseconds, TimeUnit::kMicroseconds,
                               TimeUnit::kNanoseconds};

// LiDARs turn 5 to 100 times a second. Stamps farther apart mean that scans were left out. [s]
constexpr double kShortestScan = 0.01;
constexpr double kLongestScan = 0.2;
// Times may be this far from the stamps and still count from the same zero. [s]
constexpr double kLargestStampDistance = 2.0;
// A longer scan is nonsense, and must not overflow. [s]
constexpr double kLargestShift = 3600.0;

double seconds_per(TimeUnit unit) { return 1e-9 * static_cast<double>(nanoseconds_per(unit)); }

double median(std::vector<double> values) {
  if (values.empty()) return 0.0;
  const auto middle = values.begin() + static_cast<std::ptrdiff_t>(values.size() / 2);
  std::nth_element(values.begin(), middle, values.end());
  return *middle;
}

double median_span(const std::vector<TimeFieldRange>& ranges) {
  std::vector<double> spans;
  for (const auto& range : ranges) {
    if (range.max > range.min) spans.push_back(range.max - range.min);
  }
  return median(std::move(spans));
}

double stamp_seconds(const TimeFieldRange& range) { return 1e-9 * static_cast<double>(to_ns(range.stamp)); }

/// How long a scan takes, judged by the stamps. [s]
double expected_span(const std::vector<TimeFieldRange>& ranges) {
  std::vector<double> periods;
  for (std::size_t i = 1; i < ranges.size(); ++i) {
    const double period = to_seconds(ranges[i].stamp - ranges[i - 1].stamp);
    if (period > 0.0) periods.push_back(period);
  }
  return periods.empty() ? 0.1 : std::clamp(median(std::move(periods)), kShortestScan, kLongestScan);
}

/// Distance of the times of a scan from zero (relative) or from the stamp (absolute), median over the
/// scans, so that a few stray points do not matter. [s]
double typical_distance(const std::vector<TimeFieldRange>& ranges, TimeUnit unit, TimeReference reference) {
  std::vector<double> distances;
  for (const auto& range : ranges) {
    const double origin = reference == TimeReference::kAbsolute ? stamp_seconds(range) : 0.0;
    const double unit_seconds = seconds_per(unit);
    distances.push_back(
        std::max(std::abs(range.min * unit_seconds - origin), std::abs(range.max * unit_seconds - origin)));
  }
  return median(std::move(distances));
}

/// The unit in which a span looks most like that of a scan; units are a factor of 1000 apart.
TimeUnit unit_from_span(double span, double expected) {
  const auto misfit = [&](TimeUnit unit) { return std::abs(std::log(span * seconds_per(unit) / expected)); };
  return *std::min_element(kUnits.begin(), kUnits.end(),
                           [&](auto a, auto b) { return misfit(a) < misfit(b); });
}

/// The unit in which the times are closest to the stamps.
TimeUnit unit_from_stamps(const std::vector<TimeFieldRange>& ranges) {
  const auto misfit = [&](TimeUnit unit) { return typical_distance(ranges, unit, TimeReference::kAbsolute); };
  return *std::min_element(kUnits.begin(), kUnits.end(),
                           [&](auto a, auto b) { return misfit(a) < misfit(b); });
}

TimeUnit find_unit(const std::vector<TimeFieldRange>& ranges, FieldType type, const sensor::Rig& rig) {
  if (rig.time_unit != TimeUnit::kAuto) return rig.time_unit;
  if (const double span = median_span(ranges); span > 0.0) return unit_from_span(span, expected_span(ranges));
  const TimeUnit absolute = unit_from_stamps(ranges);
  const bool is_zero =
      std::all_of(ranges.begin(), ranges.end(), [](const auto& range) { return range.max == 0.0; });
  const double distance = typical_distance(ranges, absolute, TimeReference::kAbsolute);
  if (rig.time_reference == TimeReference::kAbsolute || (!is_zero && distance < kLargestStampDistance))
    return absolute;
  const bool is_float = type == FieldType::kFloat32 || type == FieldType::kFloat64;
  return is_float ? TimeUnit::kSeconds : TimeUnit::kNanoseconds;
}

TimeOrigin find_origin(const std::vector<TimeFieldRange>& ranges, TimeUnit unit, const sensor::Rig& rig) {
  if (rig.time_reference == TimeReference::kAbsolute) return TimeOrigin::kEpoch;
  if (rig.time_reference == TimeReference::kRelative) return TimeOrigin::kStamp;
  const double from_zero = typical_distance(ranges, unit, TimeReference::kRelative);
  const double from_stamp = typical_distance(ranges, unit, TimeReference::kAbsolute);
  if (std::min(from_zero, from_stamp) > kLargestStampDistance) return TimeOrigin::kOwnClock;
  return from_zero <= from_stamp ? TimeOrigin::kStamp : TimeOrigin::kEpoch;
}

/// First and last time of the points after the stamp, medians over the scans. [s]
std::pair<double, double> times_after_stamp(const std::vector<TimeFieldRange>& ranges,
                                            const PointTimeModel& model) {
  std::vector<double> first;
  std::vector<double> last;
  for (const auto& range : ranges) {
    const double origin = model.origin == TimeOrigin::kEpoch ? stamp_seconds(range) : 0.0;
    first.push_back(range.min * seconds_per(model.unit) - origin);
    last.push_back(range.max * seconds_per(model.unit) - origin);
  }
  return {median(std::move(first)), median(std::move(last))};
}

/// Where the stamp lies in the scan. Times that count from the stamp or from the epoch say so themselves;
/// a rig that says otherwise moves them by a constant, so that the jitter of the outermost points stays out.
void place_stamp(PointTimeModel& model, const std::vector<TimeFieldRange>& ranges, const sensor::Rig& rig) {
  const bool is_forced = rig.stamp_reference != StampReference::kAuto;
  if (is_forced) model.stamp = rig.stamp_reference;
  if (model.origin == TimeOrigin::kOwnClock || ranges.empty()) return;
  const auto [first, last] = times_after_stamp(ranges, model);
  const StampReference found =
      std::abs(last) < std::abs(first) ? StampReference::kEnd : StampReference::kStart;
  if (!is_forced) model.stamp = found;
  if (!is_forced || model.stamp == found || model.origin == TimeOrigin::kEpoch) return;
  model.shift = from_seconds(
      std::clamp(model.stamp == StampReference::kEnd ? -last : -first, -kLargestShift, kLargestShift));
}

}  // namespace

std::int64_t nanoseconds_per(TimeUnit unit) {
  switch (unit) {
    case TimeUnit::kMilliseconds:
      return 1'000'000;
    case TimeUnit::kMicroseconds:
      return 1'000;
    case TimeUnit::kNanoseconds:
      return 1;
    case TimeUnit::kSeconds:
    case TimeUnit::kAuto:
      break;
  }
  return 1'000'000'000;
}

Result<std::string> find_time_field(const std::vector<PointField>& fields, const sensor::Rig& rig) {
  const auto has = [&fields](std::string_view name) {
    return std::any_of(fields.begin(), fields.end(),
                       [name](const auto& field) { return field.name == name; });
  };
  if (!rig.time_field.empty()) {
    if (has(rig.time_field)) return rig.time_field;
    std::string names;
    for (const PointField& field : fields) names += (names.empty() ? "" : ", ") + field.name;
    return make_error(ErrorCode::kInvalid,
                      "the points have no field {} (fields: {}); correct time_field in the rig",
                      rig.time_field, names);
  }
  for (const std::string_view name : kTimeFields) {
    if (has(name)) return std::string(name);
  }
  return std::string();
}

PointTimeModel find_time_model(const std::string& field, FieldType type,
                               const std::vector<TimeFieldRange>& ranges, const sensor::Rig& rig) {
  PointTimeModel model;
  model.field = field;
  if (field.empty()) return model;
  model.unit = find_unit(ranges, type, rig);
  const double span = median_span(ranges);
  model.instantaneous = !ranges.empty() && span == 0.0;
  model.span = from_seconds(span * seconds_per(model.unit));
  model.origin = find_origin(ranges, model.unit, rig);
  place_stamp(model, ranges, rig);
  return model;
}

}  // namespace mmlins::io
