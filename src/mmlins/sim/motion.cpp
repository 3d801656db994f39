// SPDX-License-Identifier: MIT
#include "mmlins/sim/motion.hpp"

#include <algorithm>
#include <cmath>
#include <numbers>
#include <optional>

namespace mmlins::sim {

namespace {

constexpr double kPi = std::numbers::pi;
constexpr double kRadPerDeg = kPi / 180.0;

struct Attitude {
  Jet roll, pitch, yaw;  // [rad]; R = Rz(yaw) Ry(pitch) Rx(roll)
};

math::Matrix3d rotation_of(const Attitude& attitude) {
  using Eigen::AngleAxisd;
  using math::Vector3d;
  return (AngleAxisd(attitude.yaw.value, Vector3d::UnitZ()) *
          AngleAxisd(attitude.pitch.value, Vector3d::UnitY()) *
          AngleAxisd(attitude.roll.value, Vector3d::UnitX()))
      .toRotationMatrix();
}

// Angular rate in the body frame, from R' = R [w]x.
math::Vector3d body_rate_of(const Attitude& attitude) {
  const double cr = std::cos(attitude.roll.value), sr = std::sin(attitude.roll.value);
  const double cp = std::cos(attitude.pitch.value), sp = std::sin(attitude.pitch.value);
  const double roll_rate = attitude.roll.rate, pitch_rate = attitude.pitch.rate, yaw_rate = attitude.yaw.rate;
  return {roll_rate - yaw_rate * sp, pitch_rate * cr + yaw_rate * cp * sr,
          -pitch_rate * sr + yaw_rate * cp * cr};
}

Jet oscillation(double amplitude, double hz, double phase, const Jet& travelled) {
  return amplitude * sin((2.0 * kPi * hz) * travelled + phase);
}

struct Ellipse {
  double semi_axis_x = 1.0, semi_axis_y = 1.0;  // [m]
  double rate = 1.0;                            // of the phase [rad/s]

  double lap_time() const { return 2.0 * kPi / rate; }
  PathPoint at(const Jet& travelled) const {
    const Jet phase = rate * travelled;
    const Jet c = cos(phase);
    const Jet s = sin(phase);
    return {semi_axis_x * c, semi_axis_y * s, atan2(semi_axis_y * c, -semi_axis_x * s)};
  }
};

Ellipse make_ellipse(const TrajectoryConfig& config) {
  const double a = config.semi_axis_x, b = config.semi_axis_y;
  const double perimeter = kPi * (3.0 * (a + b) - std::sqrt((3.0 * a + b) * (a + 3.0 * b)));  // Ramanujan
  return {a, b, 2.0 * kPi * config.speed / perimeter};
}

// A closed path in the plane, travelled with swaying, bobbing and looking around.
class LoopMotion : public Motion {
 public:
  LoopMotion(const TrajectoryConfig& config, const Route& route)
      : config_(config), ellipse_(make_ellipse(config)) {
    if (config.style == PathStyle::kRoute) {
      Route course = route;
      if (config.reverse) {
        std::reverse(course.corners.begin(), course.corners.end());
        std::reverse(course.heights.begin(), course.heights.end());
      }
      course_.emplace(course, CourseSpeed{config.speed, config.corner_ratio, config.corner_smoothing});
    } else if (config.reverse) {
      ellipse_.semi_axis_y = -ellipse_.semi_axis_y;
    }
  }

  Kinematics at(double seconds) const override {
    const Jet travelled = travel_time(seconds);
    const double lap_time = course_ ? course_->lap_time() : ellipse_.lap_time();
    const Jet on_path = travelled + config_.start_lap * lap_time;
    const PathPoint path = course_ ? course_->at(on_path) : ellipse_.at(on_path);
    const Jet z = height(travelled) + path.z;
    const Attitude attitude = attitude_at(travelled, path.heading);
    return {{rotation_of(attitude), {path.x.value, path.y.value, z.value}},
            {path.x.rate, path.y.rate, z.rate},
            {path.x.accel, path.y.accel, z.accel},
            body_rate_of(attitude)};
  }

 private:
  // Seconds spent moving: 0 while standing, then its rate rises smoothly to 1. The third derivative is
  // continuous, because the rate is a quintic step.
  Jet travel_time(double seconds) const {
    if (config_.start_in_motion) return {seconds, 1.0, 0.0};
    const double since_start = seconds - config_.stand_still;
    if (since_start <= 0.0) return {};
    if (since_start >= config_.ramp) return {since_start - 0.5 * config_.ramp, 1.0, 0.0};
    const double s = since_start / config_.ramp;
    const double s2 = s * s, s3 = s2 * s, s4 = s3 * s;
    return {config_.ramp * s4 * (s2 - 3.0 * s + 2.5), s3 * (6.0 * s2 - 15.0 * s + 10.0),
            30.0 * s2 * (s2 - 2.0 * s + 1.0) / config_.ramp};
  }

  Jet height(const Jet& travelled) const {
    return oscillation(config_.rise, 0.07, 0.4, travelled) +
           oscillation(config_.bob, config_.bob_hz, 0.0, travelled) + config_.height;
  }

  // Unrelated frequencies and phases: the body is tilted while it stands, and no axis repeats another.
  Attitude attitude_at(const Jet& travelled, const Jet& heading) const {
    const double sway = config_.sway_deg * kRadPerDeg;
    return {oscillation(sway, config_.sway_hz, 0.7, travelled),
            oscillation(0.7 * sway, 1.37 * config_.sway_hz, 2.1, travelled),
            heading + oscillation(config_.look_deg * kRadPerDeg, config_.look_hz, 0.0, travelled) +
                config_.mount_yaw_deg * kRadPerDeg};
  }

  TrajectoryConfig config_;
  Ellipse ellipse_;
  std::optional<Course> course_;
};

}  // namespace

Kinematics transformed(const math::SE3& T_new_old, const Kinematics& old) {
  return {T_new_old * old.T_world_imu, T_new_old.R * old.velocity_world, T_new_old.R * old.acceleration_world,
          old.angular_rate_imu};
}

std::unique_ptr<Motion> make_motion(const TrajectoryConfig& config, const Route& scene_route) {
  if (config.route.empty()) return std::make_unique<LoopMotion>(config, scene_route);
  Route own;
  for (const RouteCorner& corner : config.route) {
    own.corners.emplace_back(corner.x, corner.y);
    own.heights.push_back(corner.z);
  }
  return std::make_unique<LoopMotion>(config, own);
}

Fields RouteCorner::fields() {
  return {
      field("x", x, "m", {-1e5, 1e5}, "in the coordinates of the scene"),
      field("y", y, "m", {-1e5, 1e5}, ""),
      field("z", z, "m", {-1e4, 1e4}, "height of the ground"),
  };
}

Fields TrajectoryConfig::fields() {
  return {
      field("style", style, {"ellipse", "route"},
            "an ellipse about the middle of the scene, or the scene's own course"),
      groups("route", route,
             "corners of a course that takes the place of the scene's; at least three, closed"),
      field("speed", speed, "m/s", {0.05, 40.0}, "cruising speed; of an ellipse the mean"),
      field("stand_still", stand_still, "s", {0.0, 600.0}, "time before the first movement"),
      field("start_in_motion", start_in_motion,
            "moving at full speed from the first sample on; no standing still"),
      field("ramp", ramp, "s", {0.1, 60.0}, "time from standing to full speed"),
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
