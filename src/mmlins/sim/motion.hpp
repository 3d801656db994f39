// SPDX-License-Identifier: MIT
#pragma once
// How the body (the IMU) moves: smooth motions whose velocity, acceleration and angular rate are known in
// closed form, so that an ideal IMU on them is exact.

#include <memory>

#include "mmlins/base/config_fields.hpp"
#include "mmlins/math/se3.hpp"
#include "mmlins/sim/course.hpp"

namespace mmlins::sim {

/// Everything about the body at one instant. The world's z axis points up.
struct Kinematics {
  math::SE3 T_world_imu;
  math::Vector3d velocity_world = math::Vector3d::Zero();      ///< [m/s]
  math::Vector3d acceleration_world = math::Vector3d::Zero();  ///< without gravity [m/s^2]
  math::Vector3d angular_rate_imu = math::Vector3d::Zero();    ///< [rad/s]
};

/// The same motion seen from a world in which the old one is placed at `T_new_old`.
[[nodiscard]] Kinematics transformed(const math::SE3& T_new_old, const Kinematics& old);

/// Any motion; at least three times continuously differentiable in time.
class Motion {
 public:
  virtual ~Motion() = default;
  /// @param seconds  since the start of the recording
  [[nodiscard]] virtual Kinematics at(double seconds) const = 0;
};

enum class PathStyle { kEllipse, kRoute };

/// A corner of a course that somebody wrote down; in the coordinates of the scene.
struct RouteCorner {
  double x = 0.0, y = 0.0;  ///< [m]
  double z = 0.0;           ///< of the ground [m]

  [[nodiscard]] Fields fields();
};

struct TrajectoryConfig {
  PathStyle style = PathStyle::kEllipse;
  std::vector<RouteCorner> route;
  double speed = 1.2;
  double stand_still = 3.0;
  bool start_in_motion = false;
  double ramp = 3.0;
  double start_lap = 0.1;
  bool reverse = false;
  double semi_axis_x = 9.0;
  double semi_axis_y = 6.0;
  double corner_ratio = 0.6;
  double corner_smoothing = 0.8;
  double height = 1.3;
  double rise = 0.1;
  double bob = 0.01;
  double bob_hz = 1.7;
  double sway_deg = 3.0;
  double sway_hz = 0.45;
  double look_deg = 8.0;
  double look_hz = 0.21;
  double mount_yaw_deg = 17.0;

  [[nodiscard]] Fields fields();
};

/// @param scene_route  the course that the scene offers, used by PathStyle::kRoute unless the config has its
/// own
[[nodiscard]] std::unique_ptr<Motion> make_motion(const TrajectoryConfig& config, const Route& scene_route);

}  // namespace mmlins::sim
