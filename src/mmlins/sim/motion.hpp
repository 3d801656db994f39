// SPDX-License-Identifier: MIT
#pragma once
// How the body (the IMU) moves: smooth motions whose velocity, acceleration and angular rate are known in
// closed form, so that an ideal IMU on them is exact.

#include <memory>
#include <vector>

#include "mmlins/degrade/event_spec.hpp"
#include "mmlins/math/se3.hpp"
#include "mmlins/sim/course.hpp"
#include "mmlins/sim/trajectory_config.hpp"

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

/// @param scene_route  the course that the scene offers, used by PathStyle::kRoute unless the config has its
/// own
/// @param events  of which kidnaps and elevators move the carrier
[[nodiscard]] std::unique_ptr<Motion> make_motion(const TrajectoryConfig& config, const Route& scene_route,
                                                  const std::vector<degrade::EventSpec>& events = {});

}  // namespace mmlins::sim
