// SPDX-License-Identifier: MIT
#include "mmlins/io/to_scan.hpp"

#include <algorithm>
#include <cstddef>
#include <utility>
#include <vector>

namespace mmlins::io {
namespace {

// No sensor takes that long for a scan. [ns]
constexpr std::int64_t kLongestScan = 5'000'000'000;

std::pair<std::int64_t, std::int64_t> extremes_of(const std::vector<std::int64_t>& times) {
  const auto [first, last] = std::minmax_element(times.begin(), times.end());
  return {*first, *last};
}

/// Drops stray times. @return the first and the last time that remain
std::pair<std::int64_t, std::int64_t> drop_strays(LidarCloud& cloud) {
  const auto extremes = extremes_of(cloud.times);
  if (extremes.second - extremes.first <= kLongestScan) return extremes;
  std::vector<std::int64_t> times = cloud.times;
  const auto middle = times.begin() + static_cast<std::ptrdiff_t>(times.size() / 2);
  std::nth_element(times.begin(), middle, times.end());
  drop_outside(cloud, *middle - kLongestScan / 2, *middle + kLongestScan / 2);
  return extremes_of(cloud.times);
}

/// The time at which the time field is zero.
Time zero_of_field(const PointTimeModel& model, Time stamp, std::int64_t first, std::int64_t last) {
  switch (model.origin) {
    case TimeOrigin::kStamp:
      return stamp + model.shift;
    case TimeOrigin::kEpoch:
      return Time{} + model.shift;
    case TimeOrigin::kOwnClock:
      break;
  }
  return stamp - Duration(model.stamp == sensor::StampReference::kEnd ? last : first);
}

}  // namespace

Time zero_of_times(LidarCloud cloud, const PointTimeModel& model) {
  if (cloud.times.empty()) return cloud.stamp;
  const auto [first, last] = drop_strays(cloud);
  return zero_of_field(model, cloud.stamp, first, last);
}

sensor::LidarScan to_scan(LidarCloud cloud, const PointTimeModel& model, Duration time_offset) {
  sensor::LidarScan scan;
  scan.start_time = scan.end_time = cloud.stamp + time_offset;
  if (cloud.times.empty()) {
    scan.offsets.resize(cloud.points.size(), 0.0F);
  } else {
    const auto [first, last] = drop_strays(cloud);
    const Time zero = zero_of_field(model, cloud.stamp, first, last) + time_offset;
    scan.start_time = zero + Duration(first);
    scan.end_time = zero + Duration(last);
    scan.offsets.resize(cloud.points.size());
    for (std::size_t i = 0; i < cloud.times.size(); ++i) {
      scan.offsets[i] = static_cast<float>(1e-9 * static_cast<double>(cloud.times[i] - first));
    }
  }
  scan.num_invalid = cloud.num_invalid;
  scan.intensities = std::move(cloud.intensities);
  scan.intensities.resize(cloud.points.size(), 0.0F);
  scan.rings = std::move(cloud.rings);
  scan.points = std::move(cloud.points);
  return scan;
}

}  // namespace mmlins::io
