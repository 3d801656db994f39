// SPDX-License-Identifier: MIT
#include "mmlins/io/to_scan.hpp"

#include <algorithm>
#include <utility>

namespace mmlins::io {
namespace {

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

sensor::LidarScan to_scan(LidarCloud cloud, const PointTimeModel& model, Duration time_offset) {
  sensor::LidarScan scan;
  scan.num_invalid = cloud.num_invalid;
  scan.start_time = scan.end_time = cloud.stamp + time_offset;
  scan.offsets.resize(cloud.points.size(), 0.0F);
  if (!cloud.times.empty()) {
    const auto [first, last] = std::minmax_element(cloud.times.begin(), cloud.times.end());
    const Time zero = zero_of_field(model, cloud.stamp, *first, *last) + time_offset;
    scan.start_time = zero + Duration(*first);
    scan.end_time = zero + Duration(*last);
    for (std::size_t i = 0; i < cloud.times.size(); ++i) {
      scan.offsets[i] = static_cast<float>(1e-9 * static_cast<double>(cloud.times[i] - *first));
    }
  }
  scan.intensities = std::move(cloud.intensities);
  scan.intensities.resize(cloud.points.size(), 0.0F);
  scan.rings = std::move(cloud.rings);
  scan.points = std::move(cloud.points);
  return scan;
}

}  // namespace mmlins::io
