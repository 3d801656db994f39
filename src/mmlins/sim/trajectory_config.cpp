// SPDX-License-Identifier: MIT
#include "mmlins/sim/trajectory_config.hpp"

namespace mmlins::sim {

namespace {

/// What the fields of a carrier are.
TrajectoryConfig values_of(Carrier carrier) {
  TrajectoryConfig c;
  switch (carrier) {
    case Carrier::kCustom:
      break;
    case Carrier::kVehicle:
      c.speed = 7.0, c.ramp = 5.0, c.corner_ratio = 0.45, c.corner_smoothing = 1.5;
      c.height = 1.8, c.rise = 0.0, c.bob = 0.012, c.bob_hz = 1.3;
      c.sway_deg = 0.8, c.sway_hz = 0.6, c.look_deg = 0.0;
      break;
    case Carrier::kHandheld:
      c.speed = 1.2, c.ramp = 1.5, c.corner_ratio = 0.6, c.corner_smoothing = 0.8;
      c.height = 1.4, c.rise = 0.08, c.bob = 0.02, c.bob_hz = 2.0;
      c.sway_deg = 4.0, c.sway_hz = 0.9, c.look_deg = 25.0, c.look_hz = 0.23;
      break;
    case Carrier::kQuadruped:
      c.speed = 1.0, c.ramp = 1.5, c.corner_ratio = 0.5, c.corner_smoothing = 0.8;
      c.height = 0.55, c.rise = 0.02, c.bob = 0.008, c.bob_hz = 3.0;
      c.sway_deg = 3.0, c.sway_hz = 3.0, c.look_deg = 5.0, c.look_hz = 0.2;
      break;
    case Carrier::kDrone:
      c.speed = 2.5, c.ramp = 2.5, c.corner_ratio = 0.6, c.corner_smoothing = 1.2;
      c.height = 2.3, c.rise = 1.0, c.bob = 0.03, c.bob_hz = 0.6;
      c.sway_deg = 8.0, c.sway_hz = 0.35, c.look_deg = 30.0, c.look_hz = 0.12;
      break;
  }
  return c;
}

}  // namespace

std::vector<std::string> carrier_names() { return {"custom", "vehicle", "handheld", "quadruped", "drone"}; }

TrajectoryConfig TrajectoryConfig::resolved() const {
  using C = TrajectoryConfig;
  const C usual;
  const C of_carrier = values_of(carrier);
  C result = *this;
  for (double C::*member : {&C::speed, &C::ramp, &C::corner_ratio, &C::corner_smoothing, &C::height, &C::rise,
                            &C::bob, &C::bob_hz, &C::sway_deg, &C::sway_hz, &C::look_deg, &C::look_hz}) {
    if (this->*member == usual.*member) result.*member = of_carrier.*member;
  }
  return result;
}

Fields RouteCorner::fields() {
  return {
      field("x", x, "m", {-1e5, 1e5}, "in the coordinates of the scene"),
      field("y", y, "m", {-1e5, 1e5}, ""),
      field("z", z, "m", {-1e4, 1e4}, "height of the ground"),
  };
}

Fields Stop::fields() {
  return {
      field("at", at, "s", {0.0, 36000.0},
            "from when on the carrier stands, after the start of the recording"),
      field("duration", duration, "s", {0.1, 36000.0}, "how long it stands"),
  };
}

Fields TrajectoryConfig::fields() {
  return {
      field("carrier", carrier, carrier_names(),
            "what moves: its values take the place of all that are left at their defaults"),
      field("style", style, {"ellipse", "route"},
            "an ellipse about the middle of the scene, or the scene's own course"),
      groups("route", route,
             "corners of a course that takes the place of the scene's; at least three, closed"),
      field("speed", speed, "m/s", {0.05, 40.0}, "cruising speed; of an ellipse the mean"),
      field("stand_still", stand_still, "s", {0.0, 600.0}, "time before the first movement"),
      field("start_in_motion", start_in_motion,
            "moving at full speed from the first sample on; no standing still"),
      groups("stops", stops, "pauses on the way"),
      field("ramp", ramp, "s", {0.1, 60.0}, "time from standing to full speed, and back at stops"),
      field("start_lap", start_lap, "", {0.0, 1.0}, "where on the course to start, as a share of a lap"),
      field("reverse", reverse, "travel the course the other way round"),
      field("semi_axis_x", semi_axis_x, "m", {0.5, 1000.0}, "of the ellipse"),
      field("semi_axis_y", semi_axis_y, "m", {0.5, 1000.0}, "of the ellipse"),
      field("corner_ratio", corner_ratio, "", {0.1, 1.0},
            "speed at right-angled corners, as a share of the cruise"),
      field("corner_smoothing", corner_smoothing, "s", {0.1, 10.0}, "how widely corners are rounded"),
      field("height", height, "m", {0.1, 100.0}, "of the IMU above the ground"),
      field("rise", rise, "m", {0.0, 10.0}, "amplitude of slow changes of height"),
      field("bob", bob, "m", {0.0, 0.5}, "amplitude of the up and down of steps, or of the suspension"),
      field("bob_hz", bob_hz, "Hz", {0.0, 20.0}, "frequency of the bobbing"),
      field("sway_deg", sway_deg, "deg", {0.0, 45.0}, "amplitude of roll; pitch gets 0.7 of it"),
      field("sway_hz", sway_hz, "Hz", {0.0, 20.0}, "frequency of roll; pitch has 1.37 of it"),
      field("look_deg", look_deg, "deg", {0.0, 180.0}, "amplitude of looking left and right of the course"),
      field("look_hz", look_hz, "Hz", {0.0, 20.0}, "frequency of looking around"),
      field("mount_yaw_deg", mount_yaw_deg, "deg", {-180.0, 180.0},
            "heading of the IMU's x axis on the carrier"),
  };
}

}  // namespace mmlins::sim
