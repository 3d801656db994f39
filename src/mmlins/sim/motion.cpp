// SPDX-License-Identifier: MIT
#include "mmlins/sim/motion.hpp"

#include <algorithm>
#include <cmath>
#include <numbers>
#include <optional>

#include "mmlins/sim/rides.hpp"
#include "mmlins/sim/travel_clock.hpp"

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

math::Vector3d place_of(const PathPoint& point) { return {point.x.value, point.y.value, point.z.value}; }

// A closed path in the plane, travelled with swaying, bobbing and looking around.
class LoopMotion : public Motion {
 public:
  /// @param config  resolved
  LoopMotion(const TrajectoryConfig& config, const Route& route,
             const std::vector<degrade::EventSpec>& events)
      : config_(config),
        clock_(config, all_stops(config.stops, events)),
        rides_(events),
        ellipse_(make_ellipse(config)) {
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
    rides_.measure_kidnaps(clock_, [this](double path_time) {
      return place_of(path_at({path_time, 0.0, 0.0}));
    });
  }

  Kinematics at(double seconds) const override {
    const Jet travelled = clock_.at(seconds);
    const PathPoint path = path_at(travelled + rides_.time_gained(seconds));
    const Jet z = height(travelled) + path.z + rides_.rise(seconds);
    const Attitude attitude = attitude_at(travelled, path.heading);
    return {{rotation_of(attitude), {path.x.value, path.y.value, z.value}},
            {path.x.rate, path.y.rate, z.rate},
            {path.x.accel, path.y.accel, z.accel},
            body_rate_of(attitude)};
  }

 private:
  PathPoint path_at(const Jet& path_time) const {
    const double lap_time = course_ ? course_->lap_time() : ellipse_.lap_time();
    const Jet on_path = path_time + config_.start_lap * lap_time;
    return course_ ? course_->at(on_path) : ellipse_.at(on_path);
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
  TravelClock clock_;
  Rides rides_;
  Ellipse ellipse_;
  std::optional<Course> course_;
};

}  // namespace

Kinematics transformed(const math::SE3& T_new_old, const Kinematics& old) {
  return {T_new_old * old.T_world_imu, T_new_old.R * old.velocity_world, T_new_old.R * old.acceleration_world,
          old.angular_rate_imu};
}

std::unique_ptr<Motion> make_motion(const TrajectoryConfig& config, const Route& scene_route,
                                    const std::vector<degrade::EventSpec>& events) {
  const TrajectoryConfig resolved = config.resolved();
  if (config.route.empty()) return std::make_unique<LoopMotion>(resolved, scene_route, events);
  Route own;
  for (const RouteCorner& corner : config.route) {
    own.corners.emplace_back(corner.x, corner.y);
    own.heights.push_back(corner.z);
  }
  return std::make_unique<LoopMotion>(resolved, own, events);
}

}  // namespace mmlins::sim
