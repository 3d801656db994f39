// SPDX-License-Identifier: MIT
#include "mmlins/sim/travel_clock.hpp"

#include <algorithm>
#include <utility>

#include "mmlins/sim/smooth_step.hpp"

namespace mmlins::sim {

namespace {

void sort_by_time(std::vector<Stop>& stops) {
  std::sort(stops.begin(), stops.end(), [](const Stop& a, const Stop& b) { return a.at < b.at; });
}

}  // namespace

TravelClock::TravelClock(const TrajectoryConfig& config, std::vector<Stop> stops)
    : stand_still_(config.stand_still),
      ramp_(config.ramp),
      start_in_motion_(config.start_in_motion),
      old_start_(config.carrier == Carrier::kCustom && stops.empty()),
      stops_(std::move(stops)) {
  sort_by_time(stops_);
}

Jet TravelClock::at(double seconds) const {
  Jet travelled = without_stops(seconds);
  for (const Stop& stop : stops_) {
    if (seconds <= stop.at - ramp_) break;
    // Slowing down loses what starting again wins back, shifted.
    const double slow = 1.0 / ramp_;
    const Jet lost = smooth_start({(seconds - stop.at + ramp_) * slow, slow, 0.0});
    const Jet won = smooth_start({(seconds - stop.at - stop.duration) * slow, slow, 0.0});
    travelled = travelled + (-ramp_) * lost + ramp_ * won;
  }
  return travelled;
}

Jet TravelClock::without_stops(double seconds) const {
  if (start_in_motion_) return {seconds, 1.0, 0.0};
  const double since_start = seconds - stand_still_;
  if (!old_start_) return ramp_ * smooth_start({since_start / ramp_, 1.0 / ramp_, 0.0});
  // The older scenarios keep their start, whose speed is a quintic step: three times continuously
  // differentiable.
  if (since_start <= 0.0) return {};
  if (since_start >= ramp_) return {since_start - 0.5 * ramp_, 1.0, 0.0};
  const double s = since_start / ramp_;
  const double s2 = s * s, s3 = s2 * s, s4 = s3 * s;
  return {ramp_ * s4 * (s2 - 3.0 * s + 2.5), s3 * (6.0 * s2 - 15.0 * s + 10.0),
          30.0 * s2 * (s2 - 2.0 * s + 1.0) / ramp_};
}

Status validate_stops(const TrajectoryConfig& config, std::vector<Stop> stops, double duration,
                      const std::string& source) {
  sort_by_time(stops);
  double free_from = config.start_in_motion ? 0.0 : config.stand_still + config.ramp;
  const Stop* last = nullptr;
  for (const Stop& stop : stops) {
    if (stop.at + stop.duration > duration) {
      return make_error(
          ErrorCode::kInvalid,
          "{}: the stop at {} s for {} s lies outside of the recording, which lasts {} s; let it "
          "end within",
          source, stop.at, stop.duration, duration);
    }
    if (stop.at - config.ramp < free_from) {
      const std::string before =
          last == nullptr ? "the start" : fmt::format("the stop at {} s for {} s", last->at, last->duration);
      return make_error(ErrorCode::kInvalid,
                        "{}: the stop at {} s overlaps {}: slowing down takes {} s (trajectory.ramp), so it "
                        "can begin at {} s",
                        source, stop.at, before, config.ramp, free_from + config.ramp);
    }
    free_from = stop.at + stop.duration + config.ramp;
    last = &stop;
  }
  return {};
}

}  // namespace mmlins::sim
