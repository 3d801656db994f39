// SPDX-License-Identifier: MIT
#pragma once
// Time as integer nanoseconds. A double holding epoch seconds resolves only 0.24 us, so seconds in
// floating point are for differences alone. Two points in time cannot be added by accident.

#include <chrono>
#include <cmath>
#include <cstdint>

namespace mmlins {

/// The clock of the recording. It has no now(): the library never reads the wall clock.
struct SensorClock {
  using rep = std::int64_t;
  using period = std::nano;
  using duration = std::chrono::nanoseconds;
  using time_point = std::chrono::time_point<SensorClock, duration>;
  static constexpr bool is_steady = false;
};

using Duration = SensorClock::duration;
using Time = SensorClock::time_point;

[[nodiscard]] constexpr Time time_from_ns(std::int64_t ns) { return Time(Duration(ns)); }
[[nodiscard]] constexpr std::int64_t to_ns(Time time) { return time.time_since_epoch().count(); }
/// A difference in seconds.
[[nodiscard]] constexpr double to_seconds(Duration duration) { return 1e-9 * static_cast<double>(duration.count()); }
/// Seconds to the nearest nanosecond.
[[nodiscard]] inline Duration from_seconds(double seconds) { return Duration(std::llround(seconds * 1e9)); }

}  // namespace mmlins
