// SPDX-License-Identifier: MIT
#pragma once
// Events that move the carrier without its doing: kidnaps and elevators.

#include <functional>
#include <vector>

#include "mmlins/degrade/event_spec.hpp"
#include "mmlins/math/se3.hpp"
#include "mmlins/sim/travel_clock.hpp"

namespace mmlins::sim {

/// The doors of an elevator close in its first second and open in its last; it rises between.
inline constexpr double kDoorTime = 1.0;  // [s]

/// How far an elevator has risen [m].
[[nodiscard]] Jet elevator_rise(const degrade::EventSpec& elevator, double seconds);

/// The stops, with one for each elevator, which the carrier rides standing.
[[nodiscard]] std::vector<Stop> all_stops(std::vector<Stop> stops,
                                          const std::vector<degrade::EventSpec>& events);

/// Whether an event of this kind holds at `seconds` of the recording.
[[nodiscard]] bool holds(const std::vector<degrade::EventSpec>& events, degrade::EventKind kind,
                         double seconds);

/// What the rides add to a motion.
class Rides {
 public:
  explicit Rides(const std::vector<degrade::EventSpec>& events);

  /// Finds how much time on the path each kidnap saves, so that it covers the way it should.
  /// @param place  on the path after a time on it
  void measure_kidnaps(const TravelClock& clock, const std::function<math::Vector3d(double)>& place);

  /// Time on the path that kidnaps have saved, or lost.
  [[nodiscard]] Jet time_gained(double seconds) const;
  /// Height above the path: of elevators, and while lifted [m].
  [[nodiscard]] Jet rise(double seconds) const;

 private:
  struct Kidnap {
    degrade::EventSpec event;
    double time_gained = 0.0;  // [s]
  };
  std::vector<Kidnap> kidnaps_;  // in order of time
  std::vector<degrade::EventSpec> elevators_;
};

/// Whether the rides are possible: long enough, one at a time, with the LiDAR inside of the cabin.
/// @param p_imu_lidar  [m]
/// @param source  what to call the recording in the message
[[nodiscard]] Status validate_rides(const std::vector<degrade::EventSpec>& events,
                                    const math::Vector3d& p_imu_lidar, const std::string& source);

}  // namespace mmlins::sim
