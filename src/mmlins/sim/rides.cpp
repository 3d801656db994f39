// SPDX-License-Identifier: MIT
#include "mmlins/sim/rides.hpp"

#include <algorithm>

#include "mmlins/sim/smooth_step.hpp"

namespace mmlins::sim {

namespace {

using degrade::EventKind;
using degrade::EventSpec;

constexpr double kLift = 0.4;          // of a kidnapped carrier [m]
constexpr double kMeasureStep = 0.02;  // along the path [s]
constexpr double kShortestRide = 4.0;  // [s]
constexpr double kLongestLever = 0.5;  // of the LiDAR from the middle of the cabin [m]

Jet share_of(double start, double duration, double seconds) {
  return {(seconds - start) / duration, 1.0 / duration, 0.0};
}

/// Time on the path after which a carrier has come `metres` farther.
double time_after(double path_time, double metres, const std::function<math::Vector3d(double)>& place) {
  math::Vector3d here = place(path_time);
  double way = 0.0;
  while (true) {
    const math::Vector3d next = place(path_time + kMeasureStep);
    const double step = (next - here).norm();
    if (way + step >= metres) return path_time + kMeasureStep * (metres - way) / step;
    way += step;
    path_time += kMeasureStep;
    here = next;
  }
}

}  // namespace

Jet elevator_rise(const EventSpec& elevator, double seconds) {
  return elevator.effective_severity() *
         smooth_step(share_of(elevator.start + kDoorTime, elevator.duration - 2.0 * kDoorTime, seconds));
}

std::vector<Stop> all_stops(std::vector<Stop> stops, const std::vector<EventSpec>& events) {
  for (const EventSpec& event : events) {
    if (event.kind == EventKind::kElevator) stops.push_back({event.start, event.duration});
  }
  return stops;
}

bool holds(const std::vector<EventSpec>& events, EventKind kind, double seconds) {
  return std::any_of(events.begin(), events.end(), [&](const EventSpec& event) {
    return event.kind == kind && seconds >= event.start && seconds < event.start + event.duration;
  });
}

Rides::Rides(const std::vector<EventSpec>& events) {
  for (const EventSpec& event : events) {
    if (event.kind == EventKind::kKidnap) kidnaps_.push_back({event});
    if (event.kind == EventKind::kElevator) elevators_.push_back(event);
  }
  std::sort(kidnaps_.begin(), kidnaps_.end(),
            [](const Kidnap& a, const Kidnap& b) { return a.event.start < b.event.start; });
}

void Rides::measure_kidnaps(const TravelClock& clock, const std::function<math::Vector3d(double)>& place) {
  double before = 0.0;  // gained by earlier ones
  for (Kidnap& kidnap : kidnaps_) {
    const double start = kidnap.event.start, end = start + kidnap.event.duration;
    const double from = clock.at(start).value + before;
    const double to = time_after(from, kidnap.event.effective_severity(), place);
    kidnap.time_gained = to - from - (clock.at(end).value - clock.at(start).value);
    before += kidnap.time_gained;
  }
}

Jet Rides::time_gained(double seconds) const {
  Jet gained;
  for (const Kidnap& kidnap : kidnaps_) {
    gained = gained +
             kidnap.time_gained * smooth_step(share_of(kidnap.event.start, kidnap.event.duration, seconds));
  }
  return gained;
}

Jet Rides::rise(double seconds) const {
  Jet height;
  for (const EventSpec& elevator : elevators_) height = height + elevator_rise(elevator, seconds);
  for (const Kidnap& kidnap : kidnaps_)
    height = height + kLift * smooth_hump(share_of(kidnap.event.start, kidnap.event.duration, seconds));
  return height;
}

Status validate_rides(const std::vector<EventSpec>& events, const math::Vector3d& p_imu_lidar,
                      const std::string& source) {
  std::vector<EventSpec> rides;
  for (const EventSpec& event : events) {
    if (degrade::info_of(event.kind).moves_carrier) rides.push_back(event);
  }
  std::sort(rides.begin(), rides.end(),
            [](const EventSpec& a, const EventSpec& b) { return a.start < b.start; });
  for (std::size_t i = 0; i < rides.size(); ++i) {
    if (i > 0 && rides[i].start < rides[i - 1].start + rides[i - 1].duration) {
      return make_error(ErrorCode::kInvalid, "{}: event {} overlaps {}; one ride at a time", source,
                        to_text(rides[i]), to_text(rides[i - 1]));
    }
    if (rides[i].kind != EventKind::kElevator) continue;
    if (rides[i].duration < kShortestRide) {
      return make_error(ErrorCode::kInvalid,
                        "{}: event {}: an elevator takes {} s or longer, as its doors take {} s each way",
                        source, to_text(rides[i]), kShortestRide, kDoorTime);
    }
    if (p_imu_lidar.cwiseAbs().maxCoeff() > kLongestLever) {
      return make_error(ErrorCode::kInvalid,
                        "{}: event {}: the LiDAR would stick out of the cabin; sensor.p_imu_lidar must stay "
                        "within {} m",
                        source, to_text(rides[i]), kLongestLever);
    }
  }
  return {};
}

}  // namespace mmlins::sim
