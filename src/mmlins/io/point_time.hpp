// SPDX-License-Identifier: MIT
#pragma once
// When each point was measured. Drivers agree neither on the name of the field, nor on its unit, nor on
// what it counts from. All of it can be told from a few scans and their stamps.

#include <string>
#include <vector>

#include "mmlins/base/result.hpp"
#include "mmlins/base/time.hpp"
#include "mmlins/io/point_field.hpp"
#include "mmlins/sensor/rig.hpp"

namespace mmlins::io {

/// What the time field counts from.
enum class TimeOrigin {
  kStamp,    ///< the stamp of the cloud
  kEpoch,    ///< the same zero as the stamps: absolute
  kOwnClock  ///< neither: the sensor's own clock; only differences within a scan are used
};

/// How to turn the time field of a recording into time.
struct PointTimeModel {
  std::string field;  ///< empty: the points have no time, deskewing is impossible
  sensor::TimeUnit unit = sensor::TimeUnit::kSeconds;
  TimeOrigin origin = TimeOrigin::kStamp;
  sensor::StampReference stamp = sensor::StampReference::kStart;  ///< where in the scan the stamp lies
  bool instantaneous = false;  ///< in the scans looked at, all points of a scan had the same time
  Duration span{0};            ///< median time from the first to the last point of a scan
  Duration shift{0};           ///< added to every time; not zero only if the rig moves the stamp
};

/// The extremes of the time field of one scan, in the unit of the recording.
struct TimeFieldRange {
  Time stamp;
  double min = 0.0;
  double max = 0.0;
};

/// [ns] in one unit of the field; `unit` must be known.
[[nodiscard]] std::int64_t nanoseconds_per(sensor::TimeUnit unit);

/// The name of the field that holds the time: that of the rig, or one of the usual names, or empty.
/// Errors: the rig names a field that does not exist, or one that is not a single number.
[[nodiscard]] Result<std::string> find_time_field(const std::vector<PointField>& fields,
                                                  const sensor::Rig& rig);

/// Unit, origin and place of the stamp. What the rig says is taken; the rest is found out:
/// the unit from the span, which must be about one scan period; the origin by whether the values are
/// close to zero or close to the stamps.
/// @param ranges  of consecutive scans that have points
/// @param type    of the field: decides the unit if all times are the same
[[nodiscard]] PointTimeModel find_time_model(const std::string& field, FieldType type,
                                             const std::vector<TimeFieldRange>& ranges,
                                             const sensor::Rig& rig);

}  // namespace mmlins::io
